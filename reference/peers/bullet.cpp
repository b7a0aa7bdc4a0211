// Bullet (Debian's libbullet-dev, zlib licence): a soft body of the deformable world, backward Euler of
// tetrahedra, or of position-based links. Built by CMake where Bullet has the deformable world.
//
//     mss_peer_bullet EXPORT_DIR RESULT_DIR --step 0.0041667 --model linear
//
// Reads what `mss peer export` wrote and writes what `mss peer score` reads; experiments/peer/README.md
// describes both.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Tetrahedron = std::array<int, 4>;
using Triangle = std::array<int, 3>;

struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Options {
  std::string export_folder, result_folder, model = "linear";
  double step = 1.0 / 60;        ///< [s]
  int iterations = 0;            ///< Newton iterations of deformable models, of links; 0: Bullet's own
  double drag = 0;               ///< damping of all motion [1/s]
  double stiffness_damping = 0;  ///< of deformable models: times stiffness it is a damping [s]
  bool recalibrate = false;  ///< Lame's constants of the neo-Hookean solid are given as its law takes them
  int repeat = 1;            ///< runs at most, of which the cheapest counts
  bool deformable() const { return model != "links"; }
  int iterations_or_default() const { return iterations > 0 ? iterations : deformable() ? 5 : 1; }
};

// ---- what was exported

struct Exported {
  Json scene;
  std::vector<btVector3> rest, start, velocity;
  std::vector<double> mass;
  std::vector<bool> held;
  std::vector<std::array<int, 2>> springs;
  std::vector<Tetrahedron> tetrahedra;
};

std::string read_file(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream)
    throw InputError(file.string() + ": cannot be read; \"mss peer export SCENE --out DIR\" writes it");
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Calls `use` with the numbers of every row of a table, in the order of `columns`.
template <class Use>
void for_each_row(const fs::path& file, const std::vector<std::string>& columns, Use&& use) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::istringstream lines(read_file(file));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> header = split(line);
  std::vector<std::size_t> places;
  for (const std::string& column : columns) {
    const auto place = std::find(header.begin(), header.end(), column);
    if (place == header.end()) throw InputError(file.string() + ": has no column " + column);
    places.push_back(std::size_t(place - header.begin()));
  }
  for (int number = 2; std::getline(lines, line); ++number) {
    const std::vector<std::string> cells = split(line);
    std::vector<double> values;
    for (const std::size_t place : places) {
      char* end = nullptr;
      values.push_back(place < cells.size() ? std::strtod(cells[place].c_str(), &end) : 0);
      if (end == nullptr || end == cells[place].c_str())
        throw InputError(
            fmt::format("{}:{}: {}: a number is expected", file.string(), number, header[place]));
    }
    use(values);
  }
}

btVector3 vector(double x, double y, double z) { return {btScalar(x), btScalar(y), btScalar(z)}; }
btVector3 vector(const Json& v) { return vector(v[0], v[1], v[2]); }

Json read_scene(const fs::path& file) {
  Json scene = Json::parse(read_file(file), nullptr, false);
  if (scene.is_discarded()) throw InputError(file.string() + ": is not JSON");
  if (!scene.is_object() || scene.value("format", Json()) != "mss-peer-1")
    throw InputError(file.string() + ": format: \"mss-peer-1\" is expected");
  for (const char* key : {"gravity", "young", "poisson", "damping", "planes", "loads", "sample_times"})
    if (!scene.contains(key)) throw InputError(file.string() + ": has no key " + key);
  return scene;
}

/// Refuses what Bullet is not given and what changes where a body goes; warns of damping.
void check_scene(const Json& scene, const Options& options) {
  if (!scene.at("loads").empty())
    throw InputError("the scene has loads, which this adapter does not give to Bullet");
  for (const Json& plane : scene.at("planes"))
    for (const char* key : {"friction", "restitution"})
      if (plane.at(key) != scene.at("planes")[0].at(key))
        throw InputError(
            "the scene has planes of different friction or restitution; this adapter gives all those of one");
  if (options.deformable() && (scene.at("young").is_null() || scene.at("poisson").is_null()))
    throw InputError("this scene has no single E and nu, which --model " + options.model + " needs");
  const Json& damping = scene.at("damping");
  if (damping.at("law") == "thesis" || damping.value("ratio", 0.0) > 0 || damping.value("viscosity", 0.0) > 0)
    fmt::print(stderr,
               "mss_peer_bullet: warning: the scene is damped, and this adapter does not give Bullet "
               "the damping\n");
}

Exported read_export(const fs::path& folder, const Options& options) {
  Exported exported;
  exported.scene = read_scene(folder / "scene.json");
  check_scene(exported.scene, options);
  for_each_row(
      folder / "particles.csv",
      {"x", "y", "z", "start_x", "start_y", "start_z", "start_vx", "start_vy", "start_vz", "mass", "held"},
      [&](const std::vector<double>& p) {
        exported.rest.push_back(vector(p[0], p[1], p[2]));
        exported.start.push_back(vector(p[3], p[4], p[5]));
        exported.velocity.push_back(vector(p[6], p[7], p[8]));
        exported.mass.push_back(p[9]);
        exported.held.push_back(p[10] != 0);
      });
  for_each_row(folder / "springs.csv", {"a", "b"}, [&](const std::vector<double>& s) {
    exported.springs.push_back({int(s[0]), int(s[1])});
  });
  for_each_row(folder / "tetrahedra.csv", {"a", "b", "c", "d"}, [&](const std::vector<double>& t) {
    exported.tetrahedra.push_back({int(t[0]), int(t[1]), int(t[2]), int(t[3])});
  });
  return exported;
}

/// Triangles of tetrahedra that no other one shares.
std::vector<Triangle> surface_of(const std::vector<Tetrahedron>& tetrahedra) {
  std::map<Triangle, Triangle> open;  // by sorted corners
  for (const auto& [a, b, c, d] : tetrahedra)
    for (const Triangle& face :
         {Triangle{a, c, b}, Triangle{a, b, d}, Triangle{b, c, d}, Triangle{a, d, c}}) {
      Triangle key = face;
      std::sort(key.begin(), key.end());
      if (open.erase(key) == 0) open[key] = face;
    }
  std::vector<Triangle> faces;
  for (const auto& [key, face] : open) faces.push_back(face);
  return faces;
}

// ---- the engine

/// The solver of the deformable world, whose number of Newton iterations has no setter.
struct NewtonSolver : btDeformableBodySolver {
  void set_iterations(int iterations) { m_maxNewtonIterations = iterations; }
};

/// A world with the body in it. What it points to lives until the program ends, as Bullet wants no order of
/// its end.
class Engine {
 public:
  Engine(const Exported& exported, const Options& options) : exported_(exported), options_(options) {
    options.deformable() ? make_deformable_world() : make_world_of_links();
    const btVector3 gravity = vector(exported.scene.at("gravity"));
    world_->setGravity(gravity);
    info_->m_gravity = gravity;
    info_->air_density = 0;
    info_->m_sparsesdf.setDefaultVoxelsz(0.25);
    info_->m_sparsesdf.Reset();
    info_->m_sparsesdf.Initialize();
    for (const Json& plane : exported.scene.at("planes")) add_plane(plane);
    make_body();
    options.deformable() ? add_deformable(gravity)
                         : static_cast<btSoftRigidDynamicsWorld*>(world_)->addSoftBody(body_);
    set_start();
  }

  void step() {
    world_->stepSimulation(btScalar(options_.step), 0, btScalar(options_.step));
    if (options_.drag == 0) return;
    const auto kept = btScalar(std::exp(-options_.drag * options_.step));
    for (int a = 0; a < body_->m_nodes.size(); ++a) {
      body_->m_nodes[a].m_v *= kept;
      body_->m_nodes[a].m_vn *= kept;
    }
  }

  const btSoftBody& body() const { return *body_; }

 private:
  void make_deformable_world() {
    auto* bodies = new NewtonSolver;
    bodies->set_iterations(options_.iterations_or_default());
    auto* constraints = new btDeformableMultiBodyConstraintSolver;
    constraints->setDeformableSolver(bodies);
    auto* world = new btDeformableMultiBodyDynamicsWorld(dispatcher(), new btDbvtBroadphase, constraints,
                                                         configuration_, bodies);
    world->setImplicit(true);
    world->setLineSearch(false);
    world->setUseProjection(true);  // else nothing moves in the implicit mode
    world_ = world;
    info_ = &world->getWorldInfo();
  }

  void make_world_of_links() {
    auto* world = new btSoftRigidDynamicsWorld(dispatcher(), new btDbvtBroadphase,
                                               new btSequentialImpulseConstraintSolver, configuration_);
    world_ = world;
    info_ = &world->getWorldInfo();
  }

  btCollisionDispatcher* dispatcher() {
    configuration_ = new btSoftBodyRigidBodyCollisionConfiguration;
    return new btCollisionDispatcher(configuration_);
  }

  /// A box of 40 m whose upper face is the plane.
  void add_plane(const Json& plane) {
    const btVector3 normal = vector(plane.at("normal")).normalized();
    btTransform place;
    place.setIdentity();
    place.setRotation(shortestArcQuat(btVector3(0, 0, 1), normal));
    place.setOrigin(vector(plane.at("point")) - normal / 2);
    auto* box = new btRigidBody(0, nullptr, new btBoxShape(btVector3(20, 20, btScalar(0.5))));
    box->setWorldTransform(place);
    box->setFriction(1);  // the product with that of the body acts
    box->setRestitution(btScalar(plane.at("restitution").get<double>()));
    world_->addRigidBody(box);
  }

  void make_body() {
    std::vector<btScalar> masses;
    for (std::size_t a = 0; a < exported_.mass.size(); ++a)
      masses.push_back(exported_.held[a] ? 0 : btScalar(exported_.mass[a]));
    body_ = new btSoftBody(info_, int(masses.size()), exported_.rest.data(), masses.data());
    for (const auto& [a, b] : exported_.springs)
      body_->appendLink(a, b);  // without links rebuildNodeTree() never ends
    body_->m_cfg.piterations = options_.iterations_or_default();
    const Json& planes = exported_.scene.at("planes");
    if (!planes.empty()) body_->m_cfg.kDF = btScalar(planes[0].at("friction").get<double>());
    body_->updateLinkConstants();
    if (options_.deformable())
      for (const auto& [a, b, c, d] : exported_.tetrahedra) body_->appendTetra(a, b, c, d);
    for (const auto& [a, b, c] : surface_of(exported_.tetrahedra)) body_->appendFace(a, b, c);
    body_->getCollisionShape()->setMargin(btScalar(0.01));
    body_->setActivationState(DISABLE_DEACTIVATION);
  }

  void add_deformable(const btVector3& gravity) {
    body_->initializeDmInverse();
    body_->m_tetraScratches.resize(body_->m_tetras.size());  // appendTetra() does not
    body_->m_tetraScratchesTn.resize(body_->m_tetras.size());
    body_->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN;
    body_->m_sleepingThreshold = 0;
    body_->setSelfCollision(false);
    body_->updateNormals();
    auto& world = static_cast<btDeformableMultiBodyDynamicsWorld&>(*world_);
    world.addSoftBody(body_);
    const double young = exported_.scene.at("young"), poisson = exported_.scene.at("poisson");
    double mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
    if (options_.recalibrate) {  // Smith et al. 2018, eq. 15
      lambda += 5.0 / 6 * mu;
      mu *= 4.0 / 3;
    }
    const auto shear = btScalar(mu), lame = btScalar(lambda);
    const auto damping = btScalar(options_.stiffness_damping);
    if (options_.model == "linear")
      world.addForce(body_, new btDeformableLinearElasticityForce(shear, lame, 0, damping));
    else
      world.addForce(body_, new btDeformableNeoHookeanForce(shear, lame, damping));
    world.addForce(body_, new btDeformableGravityForce(gravity));
  }

  /// Rest lengths and shapes are those of the nodes as given, so where the body starts is set afterwards.
  void set_start() {
    for (int a = 0; a < body_->m_nodes.size(); ++a) {
      btSoftBody::Node& node = body_->m_nodes[a];
      node.m_x = node.m_q = exported_.start[std::size_t(a)];
      node.m_v = node.m_vn = exported_.velocity[std::size_t(a)];
    }
  }

  const Exported& exported_;
  const Options& options_;
  btSoftBodyRigidBodyCollisionConfiguration* configuration_ = nullptr;
  btDiscreteDynamicsWorld* world_ = nullptr;
  btSoftBodyWorldInfo* info_ = nullptr;
  btSoftBody* body_ = nullptr;
};

// ---- a run

struct Sample {
  double t = 0;
  std::vector<btVector3> x, v;
};

struct Run {
  std::vector<Sample> samples;
  double wall = 0, cpu = 0;  ///< of stepping alone [s]
  std::string status = "ok";
};

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

Sample snapshot(const btSoftBody& body, double t) {
  Sample sample;
  sample.t = t;
  for (int a = 0; a < body.m_nodes.size(); ++a) {
    sample.x.push_back(body.m_nodes[a].m_x);
    sample.v.push_back(body.m_nodes[a].m_v);
  }
  return sample;
}

/// Between two steps positions are on the straight line.
Sample between(const Sample& before, const Sample& now, double t) {
  const double share = now.t > before.t ? std::min(1.0, (t - before.t) / (now.t - before.t)) : 1;
  Sample sample = now;
  sample.t = t;
  if (share > 1 - 1e-6) return sample;
  for (std::size_t a = 0; a < now.x.size(); ++a) {
    sample.x[a] = before.x[a] + (now.x[a] - before.x[a]) * btScalar(share);
    sample.v[a] = before.v[a] + (now.v[a] - before.v[a]) * btScalar(share);
  }
  return sample;
}

bool blown_up(const Sample& sample, btScalar limit) {
  return std::any_of(sample.x.begin(), sample.x.end(),
                     [&](const btVector3& x) { return !(x.length() < limit); });
}

/// Takes the engine through the sample times, timing its steps alone.
Run simulate(const Exported& exported, const Options& options) {
  Engine engine(exported, options);
  Run run;
  btScalar size = 1;
  for (const btVector3& x : exported.rest) size = std::max(size, x.length());
  Sample now = snapshot(engine.body(), 0), before = now;
  long taken = 0;
  for (const double t : exported.scene.at("sample_times")) {
    while (now.t < t - 1e-6 * options.step && run.status == "ok") {
      const auto wall = std::chrono::steady_clock::now();
      const double cpu = processor_seconds();
      engine.step();
      run.cpu += processor_seconds() - cpu;
      run.wall += std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
      before = std::move(now);
      now = snapshot(engine.body(), double(++taken) * options.step);
      if (blown_up(now, 100 * size)) run.status = fmt::format("blew up at t = {:.4g} s", now.t);
    }
    if (run.status != "ok") break;
    run.samples.push_back(between(before, now, t));
  }
  return run;
}

Run cheapest_run(const Exported& exported, const Options& options) {
  Run best = simulate(exported, options);
  double spent = best.wall;
  for (int round = 1; round < options.repeat && spent < 0.5 && best.status == "ok"; ++round) {
    Run run = simulate(exported, options);
    spent += run.wall;
    if (run.cpu < best.cpu) best = std::move(run);
  }
  return best;
}

// ---- results

/// Whole or not at all.
void write(const fs::path& file, const std::string& text) {
  const fs::path part = file.string() + ".part";
  std::ofstream stream(part);
  stream << text;
  stream.close();
  if (!stream) throw InputError(file.string() + ": cannot be written");
  fs::rename(part, file);
}

const char* precision() { return sizeof(btScalar) == sizeof(float) ? "single" : "double"; }
std::string version() { return fmt::format("{}.{}", btGetVersion() / 100, btGetVersion() % 100); }

Json settings_of(const Options& options) {
  Json settings{
      {"model", options.model}, {"iterations", options.iterations_or_default()}, {"drag", options.drag}};
  if (options.deformable()) {
    settings["recalibrate"] = options.recalibrate;
    settings["stiffness_damping"] = options.stiffness_damping;
    settings["implicit"] = settings["use_projection"] = true;
    settings["line_search"] = false;
  }
  return settings;
}

void write_results(const Options& options, const Exported& exported, const Run& run) {
  const fs::path folder = options.result_folder;
  fs::create_directories(folder);
  std::string samples = "t,id,x,y,z,vx,vy,vz\n";
  for (const Sample& sample : run.samples)
    for (std::size_t a = 0; a < sample.x.size(); ++a)
      samples += fmt::format("{},{},{},{},{},{},{},{}\n", sample.t, a, sample.x[a].x(), sample.x[a].y(),
                             sample.x[a].z(), sample.v[a].x(), sample.v[a].y(), sample.v[a].z());
  write(folder / "samples.csv", samples);
  Json given = settings_of(options);
  given["step"] = options.step;
  for (const char* key : {"gravity", "planes", "young", "poisson"}) given[key] = exported.scene.at(key);
  given["nodes"] = "particles.csv: x, y, z, mass, 0 if held";
  given["links"] = "springs.csv, of Bullet's full stiffness";
  if (options.deformable()) given["tetrahedra"] = "tetrahedra.csv";
  given["faces"] = "the surface of the tetrahedra";
  write(folder / "bullet.json", given.dump(2) + "\n");
  const Json cost{{"engine", "Bullet"},
                  {"version", version()},
                  {"step", options.step},
                  {"iterations", options.iterations_or_default()},
                  {"precision", precision()},
                  {"wall_seconds", run.wall},
                  {"cpu_seconds", run.cpu},
                  {"threads", 1},
                  {"settings", settings_of(options)},
                  {"status", run.status}};
  write(folder / "cost.json", cost.dump(2) + "\n");
}

int run_program(const Options& options) {
  try {
    const Exported exported = read_export(options.export_folder, options);
    write_results(options, exported, cheapest_run(exported, options));
    return 0;
  } catch (const InputError& error) {
    fmt::print(stderr, "mss_peer_bullet: {}\n", error.what());
    return 2;
  } catch (const Json::exception&) {
    fmt::print(stderr, "mss_peer_bullet: {}: a key has another type than \"mss peer export\" writes\n",
               (fs::path(options.export_folder) / "scene.json").string());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "mss_peer_bullet: {}\n", error.what());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Takes a scene of `mss peer export` through Bullet", "mss_peer_bullet"};
  app.set_version_flag("--version", "Bullet " + version());
  app.add_option("export", options.export_folder, "folder that `mss peer export` wrote")->required();
  app.add_option("result", options.result_folder, "folder to write to")->required();
  app.add_option("--step", options.step, "[s]; 1/60")->check(CLI::PositiveNumber);
  app.add_option("--iterations", options.iterations, "of Newton's method, 5; of links, 1")
      ->check(CLI::PositiveNumber);
  app.add_option("--model", options.model, "linear, neo_hookean or links")
      ->check(CLI::IsMember({"linear", "neo_hookean", "links"}));
  app.add_flag("--recalibrate", options.recalibrate,
               "constants of neo_hookean by which it has the scene's E and nu at small strain");
  app.add_option("--drag", options.drag, "damping of all motion [1/s], to find rest; 0")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--stiffness-damping", options.stiffness_damping,
                 "of tetrahedra, times their stiffness [s]; 0")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--repeat", options.repeat, "runs at most, of which the cheapest counts; 1")
      ->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const int status = run_program(options);
  std::fflush(nullptr);
  _exit(status);  // Bullet's worlds are left as they are
}
