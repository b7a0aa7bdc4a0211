// Reduced bodies against the lattices that they stand for, and against what their formulas promise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/integrator.hpp"
#include "integrators/reduction/cubic_motion.hpp"
#include "integrators/reduction/floating_motion.hpp"
#include "integrators/reduction/reduced_system.hpp"
#include "integrators/reduction/warped_motion.hpp"

namespace mss {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double frame = 1.0 / 60;
constexpr int frames = 30;

/// The bodies of `mss reduce`: 1 m long, E in pascals, viscosity 8e-5 s of the shear modulus at 1e7 Pa.
BodyConfig block(int nx, int ny, int nz, double young) {
  BodyConfig config{.voxels = VoxelGrid::box(nx, ny, nz), .cell_size = 1.0 / nx};
  config.density = 1000;
  config.elastic = ElasticConstants{.young = young, .poisson = 0.3};
  config.springs = calibrate(*config.elastic, config.cell_size, 0.5);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 8e-5 * std::sqrt(1e7 / young) * young / 2.6};
  return config;
}
BodyConfig beam() { return block(16, 4, 4, 1e7); }

const Hold clamp{.box = {{0, 0, 0}, {0, 1, 1}}};
const Box end_face{{1, 0, 0}, {1, 1, 1}};

Environment clamped(const Vec3& gravity = Vec3::Zero()) { return {.gravity = gravity, .holds = {clamp}}; }

double distance(const Body& body, const Field<double>& a, const Field<double>& b) {
  double sum = 0;
  for (const std::ptrdiff_t site : body.sites()) sum += (a.at(site) - b.at(site)).squaredNorm();
  return std::sqrt(sum / double(body.sites().size()));
}

/// The same after the best motion of a as a whole onto b, by masses.
double distance_of_shapes(const Body& body, const Field<double>& a, const Field<double>& b) {
  Vec3 centre_a = Vec3::Zero(), centre_b = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites()) {
    centre_a += body.mass(site) / body.total_mass() * a.at(site);
    centre_b += body.mass(site) / body.total_mass() * b.at(site);
  }
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  for (const std::ptrdiff_t site : body.sites())
    product += body.mass(site) * (b.at(site) - centre_b) * (a.at(site) - centre_a).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  Field<double> moved = a;
  for (const std::ptrdiff_t site : body.sites()) moved.set(site, turn * (a.at(site) - centre_a) + centre_b);
  return distance(body, moved, b);
}

/// Of a body over half a second: what its lattice does, and how far a reduced one is from that.
class Motion {
 public:
  Motion(const BodyConfig& config, const Environment& environment)
      : body(config), environment_(environment), lattice_(body, environment, {.threads = 1}) {
    start = lattice_.rest_state();
  }

  /// Begins at rest in another environment, at time 1.
  void begin_at_rest_in(const Environment& environment) {
    SpringSystem<double> other(body, environment, {.threads = 1});
    State<double> state = other.rest_state();
    Work work;
    ASSERT_EQ(find_integrator("static").make<double>({.dt = 0})->advance(other, state, 1, work), Status::ok);
    start.x = state.x;
  }

  /// Largest distance over the frames, over the largest from the body at rest.
  double error(const ReductionChoice& choice) {
    if (reference_.empty()) compute_reference();
    const bool is_free = environment_.holds.empty();
    ReducedSystem system(body, environment_, choice, shapes_for(body, environment_, choice));
    const auto method = find_integrator("reduced").make<double>({.dt = 0});
    State<double> state = start;
    Work work;
    double most = 0, moved = 0;
    for (int f = 0; f < frames; ++f) {
      EXPECT_EQ(method->advance(system, state, (f + 1) * frame, work), Status::ok);
      const Field<double>& exact = reference_[std::size_t(f)];
      const Field<double> rest = lattice_.rest_state().x;
      most =
          std::max(most, is_free ? distance_of_shapes(body, state.x, exact) : distance(body, state.x, exact));
      moved = std::max(moved, is_free ? distance_of_shapes(body, rest, exact) : distance(body, rest, exact));
    }
    return most / moved;
  }

  const Body body;
  State<double> start;

 private:
  void compute_reference() {
    const double steps = std::ceil(frame * lattice_.spectral_bound().omega / 1.2);
    const auto method = find_integrator("rk4").make<double>({.dt = frame / steps});
    State<double> state = start;
    Work work;
    for (int f = 0; f < frames; ++f) {
      ASSERT_EQ(method->advance(lattice_, state, (f + 1) * frame, work), Status::ok);
      reference_.push_back(state.x);
    }
  }

  Environment environment_;
  SpringSystem<double> lattice_;
  std::vector<Field<double>> reference_;
};

TEST(Reduction, KernelsMultiplyByPanelsOfAnySize) {
  for (const ReductionKernels& kernels : runnable_copies<ReductionKernels>())
    for (const int rows : {1, 31, 32, 100})
      for (const int columns : {1, 7, 18}) {
        SCOPED_TRACE(kernels.name);
        const MatrixXd a = MatrixXd::Random(rows, columns);
        const std::ptrdiff_t panels = (rows + panel_rows - 1) / panel_rows;
        VectorXd values = VectorXd::Zero(panels * panel_rows * columns);
        for (int i = 0; i < rows; ++i)
          for (int c = 0; c < columns; ++c)
            values[(i / panel_rows * columns + c) * panel_rows + i % panel_rows] = a(i, c);
        const Panels<double> matrix{.values = values.data(), .panels = panels, .columns = columns};
        const VectorXd base = VectorXd::Random(panels * panel_rows), q = VectorXd::Random(columns);
        VectorXd out(base.size()), p(columns);
        kernels.expand(matrix, base.data(), q.data(), out.data());
        EXPECT_LT((out.head(rows) - base.head(rows) - a * q).cwiseAbs().maxCoeff(), 1e-13);
        const Eigen::VectorXf values_f = values.cast<float>(), base_f = base.cast<float>(),
                              q_f = q.cast<float>();
        Eigen::VectorXf out_f(base.size());
        kernels.expand_single({.values = values_f.data(), .panels = panels, .columns = columns},
                              base_f.data(), q_f.data(), out_f.data());
        EXPECT_LT((out_f.cast<double>() - out).cwiseAbs().maxCoeff(), 1e-5);
        kernels.project(matrix, base.data(), p.data());
        EXPECT_LT((p - a.transpose() * base.head(rows)).cwiseAbs().maxCoeff(), 1e-12);
      }
}

/// Energy of springs and cells one by one, as PolynomialForce defines it.
double energy_of(const Body& body, const MatrixXd& shapes, const VectorXd& q) {
  const Eigen::Index particles = shapes.rows() / 3;
  const VectorXd u = shapes * q;
  const auto displacement = [&](std::ptrdiff_t site) {
    const Eigen::Index p = body.particle(site);
    return Vec3(u[p], u[particles + p], u[2 * particles + p]);
  };
  double energy = 0;
  body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double k, double) {
    const double square = std::pow(body.rest_length(slot.kind), 2);
    const Vec3 d = body.rest_position(b) - body.rest_position(a) + displacement(b) - displacement(a);
    energy += k / (8 * square) * std::pow(d.squaredNorm() - square, 2);
  });
  body.for_each_cell([&](std::ptrdiff_t site) {
    Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        f.col(axis) += corner_sign(corner, axis) / (4 * body.config().cell_size) *
                       displacement(site + body.lattice().corner(corner));
    const double trace = (f.transpose() * f - Eigen::Matrix3d::Identity()).trace() / 2;
    energy += body.elements_at(site).volume * body.cell_volume() / 2 * trace * trace;
  });
  return energy;
}

TEST(Reduction, PolynomialIsTheEnergyOfSpringsAndCellsAndItsGradient) {
  for (const auto& [poisson, count] :
       {std::pair{0.3, 1}, {0.3, 5}, {0.25, 8}, {0.1, 13}, {0.1, 5}, {0.4, 33}}) {
    BodyConfig config = block(4, 2, 2, 1e5);
    config.springs = calibrate({.young = 1e5, .poisson = poisson}, config.cell_size, 0.5);
    const Body body(config);
    const MatrixXd shapes = 0.01 * MatrixXd::Random(3 * Eigen::Index(body.sites().size()), count);
    const PolynomialForce force(body, shapes);
    const VectorXd q = VectorXd::Random(count);
    const double energy = energy_of(body, shapes, q);
    EXPECT_NEAR(force.energy(q), energy, 1e-11 * energy) << count;
    VectorXd gradient(force.padded());
    force.gradient(q, gradient);
    for (int i = 0; i < count; ++i) {
      const VectorXd step = 1e-4 * VectorXd::Unit(count, i);
      const double slope = (energy_of(body, shapes, q + step) - energy_of(body, shapes, q - step)) / 2e-4;
      EXPECT_NEAR(gradient[i], slope, 1e-6 * gradient.norm()) << count;
    }
  }
}

TEST(Reduction, ShapesAreOrthonormalVibrations) {
  const Body body(beam());
  const Environment environment = clamped();
  RestBody rest(body, environment);
  const ReducedShapes shapes = modal_shapes(rest, environment, 12);
  SpringSystem<double> lattice(body, environment, {.threads = 1});
  Work work;
  const Modes modes = slowest_modes(lattice, lattice.rest_state(), 12, work);
  ASSERT_EQ(modes.modes.size(), 12U);
  for (int i = 0; i < 12; ++i)
    EXPECT_NEAR(std::sqrt(shapes.squares[i]), modes.modes[std::size_t(i)].omega,
                1e-6 * std::sqrt(shapes.squares[0]))
        << i;
  VectorXd masses(shapes.shapes.rows());
  const Eigen::Index particles = masses.size() / 3;
  for (Eigen::Index i = 0; i < masses.size(); ++i)
    masses[i] = body.mass(body.sites()[std::size_t(i % particles)]);
  const MatrixXd gram = shapes.shapes.transpose() * masses.asDiagonal() * shapes.shapes;
  EXPECT_LT((gram - MatrixXd::Identity(12, 12)).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_NEAR(shapes.squares[0], shapes.squares[1], 1e-6 * shapes.squares[0])
      << "a square beam bends two ways";
  for (Eigen::Index i = 1; i < shapes.count(); ++i) EXPECT_GE(shapes.squares[i], shapes.squares[i - 1]);
}

TEST(Reduction, VibrationsAreExactInStepsOfAnyLength) {
  const Body body(beam());
  const Environment environment = clamped({0, 0, -4.358});
  const ReductionChoice choice{.reduction = Reduction::modal, .modes = 8};
  const ReducedShapes shapes = shapes_for(body, environment, choice);
  ReducedSystem once(body, environment, choice, shapes), often(body, environment, choice, shapes);
  State<double> a = once.rest_state(), b = a;
  for (ReducedSystem* system : {&once, &often}) system->reduced()->take(a);
  ASSERT_TRUE(once.reduced()->step(0.5, 1));
  ASSERT_TRUE(often.reduced()->step(0.5 / 4096, 4096));
  once.reduced()->give(a);
  often.reduced()->give(b);
  const double moved = distance(body, a.x, once.rest_state().x);
  EXPECT_GT(moved, 1e-4);
  EXPECT_LT(distance(body, a.x, b.x), 1e-10 * moved);
  EXPECT_NEAR(a.t, 0.5, 1e-15);
}

TEST(Reduction, GivesBackWhatItTakes) {
  const Body body(beam());
  const Environment environment = clamped();
  for (const Reduction reduction : {Reduction::modal, Reduction::warped, Reduction::cubic}) {
    const ReductionChoice choice{.reduction = reduction};
    ReducedSystem system(body, environment, choice, shapes_for(body, environment, choice));
    State<double> state = system.rest_state(), again = state;
    Field<double> kick(system.size());
    for (const std::ptrdiff_t site : body.sites())
      kick.set(site, Vec3(0, 0.3, 1) * std::pow(body.rest_position(site)[0], 2));
    state.v = kick;
    system.reduced()->take(state);
    ASSERT_TRUE(system.reduced()->step(1e-3, 20));
    system.reduced()->give(state);
    system.reduced()->take(state);
    system.reduced()->give(again);
    EXPECT_GT(distance(body, state.x, system.rest_state().x), 1e-3);
    EXPECT_LT(distance(body, state.x, again.x), 1e-9) << int(reduction);
    EXPECT_LT(distance(body, state.v, again.v), 1e-7) << int(reduction);
  }
}

// `mss reduce` has the errors on 32 x 8 x 8 cells.
TEST(Reduction, FollowsTheLatticeUnderGravity) {
  Motion little(beam(), clamped({0, 0, -4.358}));
  EXPECT_LT(little.error({.reduction = Reduction::modal, .modes = 8}), 0.012);
  EXPECT_LT(little.error({.reduction = Reduction::cubic}), 0.003);
  Motion more(beam(), clamped({0, 0, -32.85}));
  EXPECT_LT(more.error({.reduction = Reduction::cubic}), 0.02);
  EXPECT_LT(more.error({.reduction = Reduction::warped}), 0.02);
  const double linear = more.error({.reduction = Reduction::modal, .modes = 8});
  EXPECT_GT(linear, 0.05) << "half of deflection over length is missed";
  EXPECT_LT(linear, 0.09);
}

TEST(Reduction, FollowsALatticeThatIsLetGo) {
  Motion bent(beam(), clamped());
  Environment loaded = clamped();
  loaded.loads = {{.box = end_face, .force = {0, 0, -1570}}};
  bent.begin_at_rest_in(loaded);
  EXPECT_LT(bent.error({.reduction = Reduction::cubic}), 0.04);
  Motion twisted(beam(), clamped());
  Environment turned = clamped();
  turned.holds.push_back({.box = end_face,
                          .turn = Turn{.axis = Vec3::UnitX(),
                                       .centre = {1, 0.125, 0.125},
                                       .rate = 15 * std::numbers::pi / 180,
                                       .until = 1}});
  twisted.begin_at_rest_in(turned);
  EXPECT_LT(twisted.error({.reduction = Reduction::warped, .modes = 16}), 0.012);
}

TEST(Reduction, FollowsALatticeUnderAPatch) {
  Environment environment = clamped();
  environment.loads = {{.box = {{0.4375, 0.09375, 0.25}, {0.5625, 0.15625, 0.25}}, .force = {0, 0, -2000}}};
  Motion patch(beam(), environment);
  EXPECT_LT(patch.error({.reduction = Reduction::cubic}), 0.02);
  EXPECT_LT(patch.error({.reduction = Reduction::warped}), 0.03);
}

TEST(Reduction, FreeBodiesFloatAndKeepTheirMomenta) {
  Motion spun(block(6, 6, 6, 1e6), {});
  const Vec3 spin = 10 * Vec3(1, 2, 3).normalized();
  for (const std::ptrdiff_t site : spun.body.sites())
    spun.start.v.set(site, Vec3(0.3, 0, -0.2) + spin.cross(spun.start.x.at(site) - Vec3::Constant(0.5)));
  EXPECT_LT(spun.error({.modes = 18}), 0.1);  // of 16 cells a side 0.067
  ReducedSystem system(spun.body, {}, {}, shapes_for(spun.body, {}, {}));
  State<double> state = spun.start;
  system.reduced()->take(state);
  ASSERT_TRUE(system.reduced()->step(1e-3, 500));
  system.reduced()->give(state);
  Vec3 momentum[2] = {Vec3::Zero(), Vec3::Zero()}, angular[2] = {Vec3::Zero(), Vec3::Zero()};
  for (const std::ptrdiff_t site : spun.body.sites())
    for (const auto& [i, s] : {std::pair{0, &spun.start}, {1, &state}}) {
      momentum[i] += spun.body.mass(site) * s->v.at(site);
      angular[i] += spun.body.mass(site) * s->x.at(site).cross(s->v.at(site));
    }
  EXPECT_LT((momentum[1] - momentum[0]).norm(), 1e-12 * momentum[0].norm());
  EXPECT_LT((angular[1] - angular[0]).norm(), 1e-12 * angular[0].norm());
}

TEST(Reduction, AFreeBodyFallsAsAWhole) {
  const Body body(block(3, 2, 2, 1e6));
  const Environment environment{.gravity = {1, 0, -9.81}};
  ReducedSystem system(body, environment, {}, shapes_for(body, environment, {}));
  State<double> state = system.rest_state();
  const State<double> rest = state;
  system.reduced()->take(state);
  ASSERT_TRUE(system.reduced()->step(1e-3, 1000));
  system.reduced()->give(state);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((state.x.at(site) - rest.x.at(site) - 0.5 * environment.gravity).norm(), 1e-9);
}

TEST(Reduction, StepsOfAFloatingFrameAreOfFourthOrder) {
  BodyConfig config = block(3, 3, 2, 1e6);
  config.damping = {};
  const Body body(config);
  const ReducedShapes shapes = shapes_for(body, {}, {.modes = 6});
  ReducedSystem system(body, {}, {}, shapes);
  State<double> start = system.rest_state();
  for (const std::ptrdiff_t site : body.sites())
    start.v.set(site, Vec3(5, 8, 12).cross(start.x.at(site) - Vec3::Constant(0.5)));
  const auto after = [&](long steps) {
    State<double> state = start;
    system.reduced()->take(start);
    EXPECT_TRUE(system.reduced()->step(0.2 / double(steps), steps));
    system.reduced()->give(state);
    return state.x;
  };
  const Field<double> exact = after(2048);
  const double coarse = distance(body, after(64), exact), fine = distance(body, after(128), exact);
  EXPECT_GT(coarse, 0);
  EXPECT_GT(std::log2(coarse / fine), 3.7);
}

TEST(Reduction, WarpedMotionsHardlyDependOnHowOftenTheyAreLookedAt) {
  const Body body(beam());
  const Environment environment = clamped({0, 0, -32.85});
  const ReductionChoice choice{.reduction = Reduction::warped};
  const ReducedShapes shapes = shapes_for(body, environment, choice);
  const auto after = [&](int rows) {
    ReducedSystem system(body, environment, choice, shapes);
    const auto method = find_integrator("reduced").make<double>({.dt = 0});
    State<double> state = system.rest_state();
    Work work;
    for (int row = 1; row <= rows; ++row) method->advance(system, state, 0.2 * row / rows, work);
    return state.x;
  };
  const Field<double> often = after(64);
  const double moved = distance(body, often, ReducedSystem(body, environment, choice, shapes).rest_state().x);
  EXPECT_LT(distance(body, after(1), often), 0.02 * moved);
  EXPECT_LT(distance(body, after(8), often), 0.02 * moved);
}

TEST(Reduction, HalfCurlsOfRotationsAreTheirAnglesAndStopAtGaps) {
  VoxelGrid legs = VoxelGrid::box(3, 1, 2);
  legs.set(1, 0, 0, false);
  BodyConfig config = block(3, 1, 2, 1e6);
  config.voxels = legs;
  const Body body(config);
  const auto particles = Eigen::Index(body.sites().size());
  MatrixXd turned(3 * particles, 1);
  const Vec3 angle(0.1, -0.2, 0.3);
  for (Eigen::Index p = 0; p < particles; ++p) {
    const Vec3 u = angle.cross(body.rest_position(body.sites()[std::size_t(p)]));
    for (int axis = 0; axis < 3; ++axis) turned(axis * particles + p, 0) = u[axis];
  }
  const MatrixXd curls = half_curls(body, turned);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LT((curls.col(0).segment(axis * particles, particles).array() - angle[axis]).abs().maxCoeff(),
              1e-12);
  // One leg goes down, the other stays: where no cell joins them there is no slope along x.
  MatrixXd apart = MatrixXd::Zero(3 * particles, 1);
  for (Eigen::Index p = 0; p < particles; ++p) {
    const Vec3 rest = body.rest_position(body.sites()[std::size_t(p)]);
    if (rest[0] > 1.5 * config.cell_size) apart(2 * particles + p, 0) = 1;
  }
  const MatrixXd slopes = half_curls(body, apart);
  const int foot = body.particle(body.lattice().site(1, 0, 0));
  EXPECT_LT(std::abs(slopes(particles + foot, 0)), 1e-12);
}

std::string refusal(const std::function<void()>& task) {
  try {
    task();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Reduction, RefusesInWordsWhatItIsNotFor) {
  using ::testing::HasSubstr;
  const Body body(block(3, 2, 2, 1e6));
  const auto refusal_of = [&](const Environment& environment, Reduction reduction = Reduction::modal) {
    return refusal([&] { shapes_for(body, environment, {.reduction = reduction}); });
  };
  Environment moving = clamped();
  moving.holds[0].velocity = {1, 0, 0};
  EXPECT_THAT(refusal_of(moving), HasSubstr("a hold moves what it holds"));
  Environment sliding = clamped();
  sliding.holds[0].axes = {true, false, true};
  EXPECT_THAT(refusal_of(sliding), HasSubstr("free to move as a whole in some ways"));
  Environment floor = clamped();
  floor.planes = {{}};
  EXPECT_THAT(refusal_of(floor), HasSubstr("contact = \"impulse\" changes velocities of particles"));
  EXPECT_THAT(refusal_of({}, Reduction::cubic), HasSubstr("nothing holds this one"));
  Environment pinned = clamped();
  pinned.loads.assign(100, {.box = end_face, .force = {0, 0, -1}});
  EXPECT_THAT(refusal_of(pinned), HasSubstr("vibrations, loads and planes make"));
  SpringSystem<double> lattice(body, {});
  ReducedSystem reduced(body, {}, {}, shapes_for(body, {}, {}));
  EXPECT_THAT(refusal([&] { find_integrator("reduced").make<double>({})->check(lattice); }),
              HasSubstr("particles move by themselves"));
  EXPECT_THAT(refusal([&] { find_integrator("verlet").make<double>({})->check(reduced); }),
              HasSubstr("give solve.integrator = \"reduced\""));
}

}  // namespace
}  // namespace mss
