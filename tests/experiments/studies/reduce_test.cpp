// `mss reduce`: the same scenes on every lattice, and errors and gains of what stands for them.
#include "experiments/studies/reduce/reduce.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "experiments/studies/reduce/drawing.hpp"
#include "experiments/studies/reduce/errors.hpp"
#include "experiments/studies/reduce/losses.hpp"
#include "experiments/studies/reduce/scenes.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::reduce {
namespace {

const ReduceScene& scene_of(const ReduceConfig& config, const std::string& name) {
  return *std::find_if(config.scenes.begin(), config.scenes.end(),
                       [&](const ReduceScene& scene) { return scene.name == name; });
}

const ReduceConfig& quick() {
  static const ReduceConfig config = reduce_config({.quick = true});
  return config;
}

/// G15 and S3 once, without models that reduce.
const ReduceTables& tables() {
  static const ReduceTables all = [] {
    ReduceConfig config = quick();
    std::erase_if(config.scenes, [](const ReduceScene& s) { return s.name != "G15" && s.name != "S3"; });
    for (Subject& subject : config.subjects) subject.models.clear();
    config.repetitions = 1;
    config.sample_seconds = 1e-4;
    Progress progress;
    return measure_reduce(config, progress);
  }();
  return all;
}

/// The row of a lattice with face share 1.
double number(const std::string& scene, const std::string& model, int cells, const std::string& column) {
  const Table found =
      tables().rows.where("scene", scene).where("model", model).where("cells", cells).where("face_share", 1);
  return found.number(0, column);
}

TEST(Reduce, DrawsWhatIsLinearInEachCoordinateExactly) {
  const auto body_of = [](int n) {
    BodyConfig config{.voxels = VoxelGrid::box(2 * n, n, n), .cell_size = 1.0 / n};
    config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
    return config;
  };
  const Body coarse(body_of(3)), fine(body_of(8));
  const auto at = [](const Vec3& x) {
    return Vec3(1 + x[0] * x[1] * x[2], x[0] - 2 * x[1] * x[2], 3 * x[2] + x[0] * x[1]);
  };
  // Linear in each coordinate over the whole box, so in every cell too.
  Field<double> from(coarse.lattice().size), drawn(fine.lattice().size);
  for (const std::ptrdiff_t site : coarse.sites()) from.set(site, at(coarse.rest_position(site)));
  Trilinear(coarse, fine).draw(from, drawn);
  for (const std::ptrdiff_t site : fine.sites())
    EXPECT_LT((drawn.at(site) - at(fine.rest_position(site))).norm(), 1e-13);
}

TEST(Reduce, APatchIsTheSameLoadOnEveryLattice) {
  const ReduceScene& pressed = scene_of(quick(), "P");
  const Solid& beam = quick().subjects[pressed.solid].solid;
  for (const int cells : {4, 12, 32}) {
    const Scene scene = scene_on(pressed, beam, {cells, beam.young});
    const Body body(scene.body);
    Field<double> forces(body.lattice().size);
    LoadedSites(body, scene.environment.loads)
        .add(0, 0, body.lattice().size, std::array{forces.axis(0), forces.axis(1), forces.axis(2)});
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    for (const std::ptrdiff_t site : body.sites()) {
      force += forces.at(site);
      moment += body.rest_position(site).cross(forces.at(site));
    }
    EXPECT_LT((force - pressed.amount).norm(), 1e-9);
    const Vec3 middle(beam.size[0] / 2, beam.size[1] / 2, beam.size[2]);
    EXPECT_LT((moment - middle.cross(pressed.amount)).norm(), 1e-9);
  }
}

TEST(Reduce, ErrorsOfFreeBodiesAreThoseOfTheirShape) {
  const Solid cube{.name = "cube", .cells = 2, .young = 1e6, .clamped = false};
  const Scene scene = scene_on({}, cube, {2, cube.young});
  const Body body(scene.body);
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  Field<double> stretched(body.lattice().size), turned = stretched, halfway = stretched;
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 rest = body.rest_position(site), way = 0.1 * Vec3(rest[0], 0, 0);
    stretched.set(site, rest + way);
    turned.set(site, Vec3(3, 2, 1) + turn * (rest + way));
    halfway.set(site, turn * (rest + way / 2));
  }
  const MotionErrors errors(cube, body, {stretched});
  EXPECT_NEAR(errors.of({turned}), 0, 1e-12);
  EXPECT_NEAR(errors.of({halfway}), 0.5, 1e-9);
}

TEST(Reduce, AScenesBodyMustGoAsFarAsIsMeant) {
  ReduceScene bent = scene_of(quick(), "R15");
  const Solid& beam = quick().subjects[bent.solid].solid;
  const Scene scene = scene_on(bent, beam, {8, beam.young});
  const Body body(scene.body);
  const State<double> start = start_of(bent, beam, scene, body);
  const double reached = -end_displacement(beam, body, start.x)[2] / beam.size[0];
  bent.meant = reached;
  EXPECT_EQ(reduce_complaint(bent, beam, body, start, {}), "");
  bent.meant = 2 * reached;
  EXPECT_NE(reduce_complaint(bent, beam, body, start, {}).find("of the length, not"), std::string::npos);
}

TEST(Reduce, MatchedModuliMakeLargeCellsWorthTheirCost) {
  EXPECT_GT(number("G15", "springs", 4, "error"), 0.5);
  EXPECT_LT(number("G15", "matched_bending", 4, "error"), 0.073);
  EXPECT_LT(number("G15", "matched_bending", 8, "error"), 0.029);
  EXPECT_LT(number("G15", "matched_both", 8, "error"), 0.03);
  EXPECT_GT(number("G15", "matched_bending", 4, "gain_unmatched"), 5);
  for (std::size_t r = 0; r < tables().scenes.size(); ++r) {
    EXPECT_EQ(tables().scenes.text(r, "status"), "ok");
    EXPECT_LT(tables().scenes.number(r, "uncertainty"), 1e-3);
  }
}

/// What a row of a model is warned of in a scene, from a run in few lattices.
std::string warned_of(const std::string& scene, const std::string& model) {
  static const Table rows = [] {
    ReduceConfig config = quick();
    std::erase_if(config.scenes, [](const ReduceScene& s) {
      return s.name != "G2" && s.name != "G60" && s.name != "T15" && s.name != "C15" && s.name != "S25";
    });
    for (Subject& subject : config.subjects) {
      subject.cells = {subject.cells.back()};
      if (subject.solid.clamped) subject.models = {{"modal", 8}, {"modal_warped", 8}, {"modal_cubic", 12}};
    }
    config.repetitions = 1;
    config.sample_seconds = 0;
    Progress progress;
    return measure_reduce(config, progress).rows;
  }();
  return rows.where("scene", scene).where("model", model).text(0, "warned");
}

TEST(Reduce, ModelsWarnWhereTheyFail) {
  for (const char* model : {"modal", "modal_warped", "modal_cubic"}) {
    EXPECT_EQ(warned_of("G2", model), "");
    EXPECT_NE(warned_of("C15", model).find("a plane pushes the body"), std::string::npos) << model;
  }
  EXPECT_NE(warned_of("G60", "modal").find("at its end"), std::string::npos);
  EXPECT_NE(warned_of("G60", "modal_warped").find("at its end"), std::string::npos);
  EXPECT_NE(warned_of("T15", "modal_cubic").find("twists by"), std::string::npos);
  EXPECT_EQ(warned_of("T15", "modal_warped"), "");
  EXPECT_NE(warned_of("S25", "modal").find("at its end"), std::string::npos);
}

TEST(Reduce, FramesBendTooStifflyUnlessTheirModulusIsMatched) {
  const auto error = [](const std::string& setting) {
    return tables().rows.where("model", "frames").where("setting", setting).number(0, "error");
  };
  EXPECT_GT(error("3 control points, E as it is"), 0.3);
  EXPECT_LT(error("3 control points, E matched"), error("3 control points, E as it is") / 3);
}

TEST(Reduce, RegionsOfSeveralSizesKeepABodyAtRest) {
  ReduceScene still = scene_of(quick(), "G15");
  still.amount.setZero();
  const Solid& beam = quick().subjects[still.solid].solid;
  const Scene scene = scene_on(still, beam, {8, beam.young});
  const Body body(scene.body);
  const State<double> start = start_of(still, beam, scene, body);
  const std::unique_ptr<Mover> mover = adaptive_shape_mover(still, beam, body, start, 2, 0.5);
  mover->restart();
  for (int i = 0; i < 5; ++i) ASSERT_EQ(mover->advance(), Status::ok);
  EXPECT_LT((mover->draw().array() - start.x.array()).abs().maxCoeff(), 1e-12);
}

TEST(Reduce, DrawsFromTables) {
  const std::vector<NamedTable> files{{"reduce", tables().rows}, {"reduce_scenes", tables().scenes}};
  const Drawings drawings = find_experiment("reduce").draw(files);
  expect_same_drawings(find_experiment("reduce"), files);
  ASSERT_EQ(drawings.charts.size(), 4U);  // no model that could gain over matched lattices
  EXPECT_EQ(drawings.charts[0].name, "reduce");
  EXPECT_EQ(drawings.charts[1].name, "reduce_losses");
  EXPECT_EQ(drawings.charts[2].name, "reduce_G15");
  EXPECT_EQ(drawings.charts[2].chart.series.size(), 5U);
}

}  // namespace
}  // namespace mss::studies::reduce
