#include "core/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.hpp"
#include "core/measures.hpp"
#include "core/toml_reader.hpp"

namespace mss {

namespace {

/// Everything a scene may say. A key that is not here is an error that suggests the nearest one that is.
KnownKeys make_known_keys() {
  KnownKeys keys{
      {"",
       {"body", "material", "damping", "weight", "environment", "hold", "load", "strike", "plane", "start",
        "solve", "expect"}},
      {"expect", {energy_drift, mean_displacement}},
      {"expect.energy_drift", {"value", "within"}},
      {"expect.displacement", {"box", "value", "within"}},
      {"body", {"cells", "voxels", "refine", "cell_size", "origin", "topology", "sharing"}},
      {"material",
       {"model", "density", "young", "poisson", "face_share", "springs", "volume", "volume_force",
        "fold_guard"}},
      {"material.springs", {"edge", "face", "body"}},
      {"damping", {"ratio", "thesis"}},
      {"weight", {"box", "mass"}},
      {"environment", {"gravity"}},
      {"hold", {"box", "axes", "velocity", "displacement", "turn"}},
      {"hold.turn", {"axis", "centre", "rate", "until"}},
      {"load", {"box", "force"}},
      {"strike", {"box", "at", "impulse"}},
      {"plane", {"point", "normal", "contact", "restitution", "friction"}},
      {"start", {"velocity", "spin"}},
      {"solve",
       {"integrator", "dt", "duration", "threads", "precision", "linear_solver", "tangent", "tolerance",
        "every", "sleep", "sleep_after"}},
  };
  for (const MeasureColumn& column : measure_columns) {
    keys["expect"].emplace_back(column.name);
    keys["expect." + std::string(column.name)] = {"value", "within"};
  }
  return keys;
}

const KnownKeys& known_keys() {
  static const KnownKeys keys = make_known_keys();
  return keys;
}

/// Names that keys had before.
const KnownKeys old_keys{{"damping", {"paper"}}};

constexpr auto any = [](double) { return true; };
constexpr auto positive = [](double value) { return value > 0; };
constexpr auto not_negative = [](double value) { return value >= 0; };

constexpr Quantity cell_counts{"a number of cells", "three whole numbers of at least 1, or voxels = \"file\"",
                               [](double value) { return value >= 1; }};
constexpr Quantity split_parts{"a number of parts of an edge", "a whole number of at least 1",
                               [](double value) { return value >= 1; }};
constexpr Quantity length{"a length", "a positive number of metres", positive};
constexpr Quantity position{"a position", "three finite numbers of metres", any};
constexpr Quantity density{"a density", "a positive number of kg/m^3", positive};
constexpr Quantity mass{"a mass", "a positive number of kilograms", positive};
constexpr Quantity young{"a stiffness", "a positive number of pascals", positive};
constexpr Quantity poisson{"a Poisson's ratio of finite stiffness", "a number above -1 and below 0.5",
                           [](double value) { return value > -1 && value < 0.5; }};
constexpr Quantity share{"a share", "a number from 0 to 1",
                         [](double value) { return value >= 0 && value <= 1; }};
constexpr Quantity spring{"a spring constant", "a number of N/m that is not negative", not_negative};
constexpr Quantity volume{"a volume stiffness", "a finite number of pascals", any};
constexpr Quantity guard{"a stiffness of the guard against folding",
                         "a number of shear moduli that is not negative", not_negative};
constexpr Quantity damping_ratio{"a damping ratio", "a number that is not negative, or thesis = true",
                                 not_negative};
constexpr Quantity acceleration{"an acceleration", "three finite numbers of m/s^2", any};
constexpr Quantity velocity{"a velocity", "three finite numbers of m/s", any};
constexpr Quantity displacement{"a displacement", "three finite numbers of metres", any};
constexpr Quantity axis{"an axis", "a direction [x, y, z] that is not zero", any};
constexpr Quantity turn_rate{"an angular rate", "a finite number of rad/s", any};
constexpr Quantity spin{"an angular velocity", "three finite numbers of rad/s", any};
constexpr Quantity force{"a force", "three finite numbers of newtons", any};
constexpr Quantity impulse{"an impulse", "three finite numbers of newton seconds", any};
constexpr Quantity time_of_strike{"a time", "a finite number of seconds that is not negative", not_negative};
constexpr Quantity sleep_bound{"a distance", "a number of metres that is not negative, 0 for no sleep",
                               not_negative};
constexpr Quantity expected{"a value", "a finite number", any};
constexpr Quantity margin{"a margin", "a finite number that is not negative", not_negative};
constexpr Quantity normal{"a normal", "a direction [x, y, z] that is not zero", any};
constexpr Quantity restitution{"a restitution", "a number from 0 (nothing rebounds) to 1 (no loss)",
                               [](double value) { return value >= 0 && value <= 1; }};
constexpr Quantity friction{"a coefficient of friction", "a number that is not negative", not_negative};
constexpr Quantity step{"a time step", "a positive number of seconds, or \"safe\"", positive};
constexpr Quantity duration{"a duration", "a finite number of seconds that is not negative", not_negative};
constexpr Quantity interval{"an interval", "a positive number of seconds", positive};
constexpr Quantity tolerance{"a tolerance", "a number above 0 and below 1",
                             [](double value) { return value > 0 && value < 1; }};
constexpr int most_threads = 1024;
constexpr Quantity thread_count{"a number of threads", "a whole number from 0 (all that pay) to 1024",
                                [](double value) { return value >= 0 && value <= most_threads; }};

const std::vector<std::pair<std::string, Topology>> topologies{
    {"full", Topology::full}, {"edges+body", Topology::edges_body}, {"one-diagonal", Topology::one_diagonal}};
const std::vector<std::pair<std::string, Sharing>> sharings{{"weighted", Sharing::weighted},
                                                            {"uniform", Sharing::uniform}};
const std::vector<std::pair<std::string, ContactLaw>> contact_laws{
    {"impulse", ContactLaw::impulse}, {"thesis", ContactLaw::thesis}, {"penalty", ContactLaw::penalty}};
const std::vector<std::pair<std::string, Tangent>> tangents{{"elastic", Tangent::elastic},
                                                            {"projected", Tangent::projected}};
const std::vector<std::pair<std::string, Precision>> precisions{{"double", Precision::dbl},
                                                                {"single", Precision::single}};

template <class Value>
const std::string& name_of(Value value, const std::vector<std::pair<std::string, Value>>& names) {
  for (const auto& [name, named] : names)
    if (named == value) return name;
  return names.front().first;
}

/// What `resolved` tells beside the Scene itself: how the body and the springs were asked for.
struct Asked {
  std::string voxels;  ///< empty: a box of cells
  int refine = 1;
  double face_share = 0.5;
};

/// Some 100 bytes per lattice site are needed: beyond this, bodies outgrow the memory of a large workstation.
constexpr double most_sites = 2e8;

void check_size(const TomlTable& body, std::string_view key, const std::array<int, 3>& cells, int refine) {
  double sites = 1;
  for (const int count : cells) sites *= double(count) * refine + 1;
  if (sites > most_sites)
    body.reject(
        key,
        fmt::format("makes a lattice of {:.0f} million particles; give fewer cells, at most {:.0f} million "
                    "particles fit",
                    sites / 1e6, most_sites / 1e6));
}

/// Every cell split into `parts` along each axis.
VoxelGrid split(const VoxelGrid& grid, int parts) {
  if (parts == 1) return grid;
  VoxelGrid fine(grid.nx() * parts, grid.ny() * parts, grid.nz() * parts);
  for (int k = 0; k < fine.nz(); ++k)
    for (int j = 0; j < fine.ny(); ++j)
      for (int i = 0; i < fine.nx(); ++i) fine.set(i, j, k, grid.at(i / parts, j / parts, k / parts));
  return fine;
}

VoxelGrid read_voxels(const TomlTable& body, const std::filesystem::path& folder, Asked& asked) {
  if (body.has("cells") && body.has("voxels"))
    body.reject("voxels", "stands beside body.cells; give one of the two");
  if (!body.has("voxels")) {
    auto cells = body.three_whole("cells", cell_counts);
    check_size(body, "cells", cells, asked.refine);
    return split(VoxelGrid::box(cells[0], cells[1], cells[2]), asked.refine);
  }
  asked.voxels = body.text("voxels", "a file name", "the path of a voxel file, relative to the scene file");
  try {
    VoxelGrid grid = VoxelGrid::read(folder / asked.voxels);
    check_size(body, "voxels", grid.size(), asked.refine);
    return split(grid, asked.refine);
  } catch (const InputError& error) {
    body.reject("voxels", fmt::format("does not give a body: {}", error.what()));
  }
}

/// Springs as given, or of the elastic constants given, which are kept.
SpringConstants read_springs(const TomlTable& material, double cell_size,
                             std::optional<ElasticConstants>& elastic, Asked& asked) {
  const bool calibrated = material.has("young") || material.has("poisson");
  if (material.has("springs")) {
    for (const auto* key : {"young", "poisson", "face_share", "volume_force"})
      if (material.has(key)) material.reject(key, "stands beside material.springs; give one of the two");
    const TomlTable springs = material.table("springs");
    return {.edge = springs.number("edge", spring),
            .face = springs.number("face", spring),
            .body = springs.number("body", spring),
            .volume = material.number("volume", volume, 0)};
  }
  if (!calibrated)
    material.reject_missing("young",
                            "give young and poisson, or springs = { edge = .., face = .., body = .. }");
  if (material.has("volume"))
    material.reject("volume", "stands beside material.young, which determines it; give one of the two");
  elastic = {.young = material.number("young", young), .poisson = material.number("poisson", poisson)};
  asked.face_share = material.number("face_share", share, 0.5);
  SpringConstants springs = calibrate(*elastic, cell_size, asked.face_share);
  if (!material.boolean("volume_force", true)) springs.volume = 0;
  if (!std::isfinite(springs.edge + springs.volume))
    material.reject("young", "is too large to compute with; give a smaller number of pascals");
  return springs;
}

Damping read_damping(const TomlTable& damping) {
  const char* key = damping.has("thesis") ? "thesis" : "paper";
  const bool thesis = damping.boolean(key, false);
  if (thesis && damping.has("ratio"))
    damping.reject("ratio", fmt::format("stands beside damping.{} = true; give one of the two", key));
  const double zeta = damping.number("ratio", damping_ratio, 0);
  if (thesis) return {.law = Damping::Law::thesis};
  return {.law = zeta > 0 ? Damping::Law::ratio : Damping::Law::none, .zeta = zeta};
}

double read_fold_guard(const TomlTable& material, const BodyConfig& config) {
  const double stiffness = material.number("fold_guard", guard, 0);
  if (stiffness > 0 && cubic_stiffness(config.springs, config.cell_size).c44 == 0)
    material.reject("fold_guard",
                    "is in shear moduli, and these springs have none; give face or body diagonals");
  return stiffness;
}

BodyConfig read_body(const TomlTable& scene, const std::filesystem::path& folder, Asked& asked) {
  const TomlTable body = scene.table("body");
  const TomlTable material = scene.table("material");
  BodyConfig config;
  asked.refine = body.whole("refine", split_parts, 1);
  config.voxels = read_voxels(body, folder, asked);
  config.cell_size = body.number("cell_size", length) / asked.refine;
  config.origin = body.vector("origin", position, Vec3::Zero());
  config.topology = body.choice("topology", "a topology", topologies, Topology::full);
  config.sharing = body.choice("sharing", "a way of sharing springs", sharings, Sharing::weighted);
  config.density = material.number("density", density);
  if (!std::isnormal(config.density * std::pow(config.cell_size, 3) / 8))
    body.reject("cell_size", fmt::format("gives particles of mass {} kg; change it or material.density",
                                         config.density * std::pow(config.cell_size, 3) / 8));
  config.springs = read_springs(material, config.cell_size, config.elastic, asked);
  config.fold_guard = read_fold_guard(material, config);
  config.damping = read_damping(scene.table("damping"));
  for (const TomlTable& table : scene.tables("weight"))
    config.weights.push_back({.box = table.box("box"), .mass = table.number("mass", mass)});
  return config;
}

std::array<bool, 3> read_axes(const TomlTable& hold) {
  if (!hold.has("axes")) return {true, true, true};
  constexpr auto allowed = "one or more of the letters x, y and z, as in \"xyz\"";
  std::array<bool, 3> axes{};
  for (const char letter : hold.text("axes", "a set of axes", allowed)) {
    const bool known = letter >= 'x' && letter <= 'z';
    if (!known || axes[static_cast<std::size_t>(letter - 'x')])
      hold.reject("axes", fmt::format("is not a set of axes; give {}", allowed));
    axes[static_cast<std::size_t>(letter - 'x')] = true;
  }
  return axes;
}

/// A vector of length 1.
Vec3 read_direction(const TomlTable& table, std::string_view key, const Quantity& quantity) {
  const Vec3 read = table.vector(key, quantity);
  if (!(read.stableNorm() > 0))
    table.reject(key, fmt::format("is not {}; give {}", quantity.noun, quantity.allowed));
  return read.stableNormalized();
}

Turn read_turn(const TomlTable& turn) {
  Turn read{.axis = read_direction(turn, "axis", axis),
            .centre = turn.vector("centre", position),
            .rate = turn.number("rate", turn_rate)};
  read.until = turn.number("until", duration, read.until);
  return read;
}

/// "paper" is what "thesis" was called before.
ContactLaw read_contact_law(const TomlTable& plane, ContactLaw fallback) {
  if (plane.is_text("contact") && plane.text("contact", "a law of contact", "a name") == "paper")
    return ContactLaw::thesis;
  return plane.choice("contact", "a law of contact", contact_laws, fallback);
}

Plane read_plane(const TomlTable& table) {
  Plane plane{.point = table.vector("point", position), .normal = read_direction(table, "normal", normal)};
  plane.contact = read_contact_law(table, plane.contact);
  plane.restitution = table.number("restitution", restitution, plane.restitution);
  plane.friction = table.number("friction", friction, plane.friction);
  return plane;
}

Environment read_environment(const TomlTable& scene) {
  Environment environment;
  environment.gravity = scene.table("environment").vector("gravity", acceleration, Vec3::Zero());
  for (const TomlTable& table : scene.tables("hold")) {
    Hold hold{.box = table.box("box"), .axes = read_axes(table), .turn = {}};
    hold.velocity = table.vector("velocity", velocity, Vec3::Zero());
    hold.displacement = table.vector("displacement", displacement, Vec3::Zero());
    if (table.has("turn")) hold.turn = read_turn(table.table("turn"));
    environment.holds.push_back(hold);
  }
  for (const TomlTable& table : scene.tables("load"))
    environment.loads.push_back({.box = table.box("box"), .force = table.vector("force", force)});
  for (const TomlTable& table : scene.tables("strike"))
    environment.strikes.push_back({.box = table.box("box"),
                                   .at = table.number("at", time_of_strike),
                                   .impulse = table.vector("impulse", impulse)});
  for (const TomlTable& table : scene.tables("plane")) environment.planes.push_back(read_plane(table));
  return environment;
}

/// A box that reaches no particle is a slip: what it is for would silently do nothing.
void check_selection(const TomlTable& table, const Body& body, const Box& box) {
  if (!body.select(box.lower, box.upper).empty()) return;
  const BodyConfig& config = body.config();
  const Vec3 lower = config.origin;
  const Vec3 upper =
      lower + config.cell_size * Vec3(config.voxels.nx(), config.voxels.ny(), config.voxels.nz());
  table.reject("box", fmt::format("contains no particle; give one that does, the body at rest spans "
                                  "[{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}]",
                                  lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]));
}

void check_selections(const TomlTable& scene, const BodyConfig& config, const Environment& environment) {
  const auto holds = scene.tables("hold"), loads = scene.tables("load"), strikes = scene.tables("strike"),
             weights = scene.tables("weight");
  if (holds.empty() && loads.empty() && strikes.empty() && weights.empty()) return;
  const Body body(config);
  for (std::size_t i = 0; i < holds.size(); ++i) check_selection(holds[i], body, environment.holds[i].box);
  for (std::size_t i = 0; i < loads.size(); ++i) check_selection(loads[i], body, environment.loads[i].box);
  for (std::size_t i = 0; i < strikes.size(); ++i)
    check_selection(strikes[i], body, environment.strikes[i].box);
  for (std::size_t i = 0; i < weights.size(); ++i) check_selection(weights[i], body, config.weights[i].box);
}

std::vector<Expectation> read_expectations(const TomlTable& expect) {
  std::vector<Expectation> all;
  for (const std::string& quantity : known_keys().at("expect")) {
    if (!expect.has(quantity)) continue;
    const TomlTable table = expect.table(quantity);
    Expectation e{.quantity = quantity, .within = table.number("within", margin)};
    if (quantity == mean_displacement) {
      const Vec3 value = table.vector("value", displacement);
      e.value = {value[0], value[1], value[2]};
      e.box = table.box("box");
    } else {
      e.value = {table.number("value", expected)};
    }
    all.push_back(std::move(e));
  }
  return all;
}

SolveConfig read_solve(const TomlTable& solve) {
  SolveConfig config;
  if (solve.has("integrator"))
    config.integrator = solve.text("integrator", "an integrator", "its name, such as \"verlet\"");
  if (solve.is_text("dt")) {
    if (solve.text("dt", step.noun, step.allowed) != "safe")
      solve.reject("dt", fmt::format("is not {}; give {}", step.noun, step.allowed));
  } else if (solve.has("dt")) {
    config.dt = solve.number("dt", step);
  }
  config.duration = solve.number("duration", duration, config.duration);
  config.threads = solve.whole("threads", thread_count, config.threads);
  config.precision = solve.choice("precision", "a precision", precisions, config.precision);
  if (solve.has("linear_solver"))
    config.linear_solver = solve.text("linear_solver", "a linear solver", "its name, such as \"cholmod\"");
  config.tangent = solve.choice("tangent", "a tangent", tangents, config.tangent);
  config.tolerance = solve.number("tolerance", tolerance, config.tolerance);
  config.every = solve.number("every", interval, config.every);
  config.sleep.bound = solve.number("sleep", sleep_bound, config.sleep.bound);
  config.sleep.after = solve.number("sleep_after", interval, config.sleep.after);
  return config;
}

/// What a user should know before trusting the material, whose constants assume the full, weighted lattice.
std::vector<std::string> read_warnings(const Scene& scene) {
  const BodyConfig& body = scene.body;
  if (!has_springs(scene.model)) return {};  // the springs are not asked
  if (body.topology != Topology::full)
    return {
        fmt::format("body.topology = \"{}\" leaves out face diagonals: the body is softer in shear than its "
                    "material says, and differs with direction",
                    name_of(body.topology, topologies))};
  std::vector<std::string> warnings = material_warnings(body.springs, body.cell_size);
  if (body.sharing == Sharing::uniform && body.elastic)
    warnings.emplace_back(
        "body.sharing = \"uniform\" makes surfaces stiffer than material.young says; only "
        "\"weighted\" keeps it");
  return warnings;
}

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& v) { return {v[0], v[1], v[2]}; }
Json to_json(const Box& box) { return {to_json(box.lower), to_json(box.upper)}; }

/// Cells along each axis before they were split.
std::array<int, 3> cells_before(const BodyConfig& body, int refine) {
  std::array<int, 3> cells = body.voxels.size();
  for (int& count : cells) count /= refine;
  return cells;
}

Json to_json(const BodyConfig& body, const Asked& asked) {
  Json json;
  if (asked.voxels.empty())
    json["cells"] = cells_before(body, asked.refine);
  else
    json["voxels"] = asked.voxels;
  json["refine"] = asked.refine;
  json["cell_count"] = body.voxels.count();
  json["cell_size"] = body.cell_size * asked.refine;
  json["origin"] = to_json(body.origin);
  json["topology"] = name_of(body.topology, topologies);
  json["sharing"] = name_of(body.sharing, sharings);
  return json;
}

Json material_to_json(const Scene& scene, const Asked& asked) {
  const BodyConfig& body = scene.body;
  Json json{{"model", scene.model}, {"density", body.density}};
  if (body.elastic) {
    json["young"] = body.elastic->young;
    json["poisson"] = body.elastic->poisson;
    json["face_share"] = asked.face_share;
  }
  json["springs"] = {{"edge", body.springs.edge}, {"face", body.springs.face}, {"body", body.springs.body}};
  json["volume"] = body.springs.volume;
  json["fold_guard"] = body.fold_guard;
  return json;
}

Json to_json(const Damping& damping) {
  return {{"ratio", damping.zeta}, {"thesis", damping.law == Damping::Law::thesis}};
}

Json to_json(const Hold& hold) {
  std::string axes;
  for (std::size_t a = 0; a < 3; ++a)
    if (hold.axes[a]) axes += "xyz"[a];
  Json json{{"box", to_json(hold.box)},
            {"axes", axes},
            {"velocity", to_json(hold.velocity)},
            {"displacement", to_json(hold.displacement)}};
  if (!hold.turn) return json;
  json["turn"] = {
      {"axis", to_json(hold.turn->axis)}, {"centre", to_json(hold.turn->centre)}, {"rate", hold.turn->rate}};
  if (std::isfinite(hold.turn->until)) json["turn"]["until"] = hold.turn->until;
  return json;
}

Json to_json(const Plane& plane) {
  return {{"point", to_json(plane.point)},
          {"normal", to_json(plane.normal)},
          {"contact", to_string(plane.contact)},
          {"restitution", plane.restitution},
          {"friction", plane.friction}};
}

Json to_json(const SolveConfig& solve) {
  return {{"integrator", solve.integrator},
          {"dt", solve.dt ? Json(*solve.dt) : Json("safe")},
          {"duration", solve.duration},
          {"threads", solve.threads},
          {"precision", name_of(solve.precision, precisions)},
          {"linear_solver", solve.linear_solver},
          {"tangent", name_of(solve.tangent, tangents)},
          {"tolerance", solve.tolerance},
          {"every", solve.every},
          {"sleep", solve.sleep.bound},
          {"sleep_after", solve.sleep.after}};
}

Json to_json(const std::vector<Expectation>& expectations) {
  Json json = Json::object();
  for (const Expectation& e : expectations) {
    json[e.quantity] = {{"value", e.value}, {"within", e.within}};
    if (e.quantity == mean_displacement)
      json[e.quantity]["box"] = to_json(e.box);
    else
      json[e.quantity]["value"] = e.value.front();
  }
  return json;
}

std::string to_json(const Scene& scene, const Asked& asked) {
  Json weights = Json::array(), holds = Json::array(), loads = Json::array(), strikes = Json::array(),
       planes = Json::array();
  for (const Weight& weight : scene.body.weights)
    weights.push_back({{"box", to_json(weight.box)}, {"mass", weight.mass}});
  for (const Hold& hold : scene.environment.holds) holds.push_back(to_json(hold));
  for (const Load& load : scene.environment.loads)
    loads.push_back({{"box", to_json(load.box)}, {"force", to_json(load.force)}});
  for (const Strike& strike : scene.environment.strikes)
    strikes.push_back(
        {{"box", to_json(strike.box)}, {"at", strike.at}, {"impulse", to_json(strike.impulse)}});
  for (const Plane& plane : scene.environment.planes) planes.push_back(to_json(plane));
  const Json json{
      {"name", scene.name},
      {"body", to_json(scene.body, asked)},
      {"material", material_to_json(scene, asked)},
      {"damping", to_json(scene.body.damping)},
      {"weight", weights},
      {"environment", {{"gravity", to_json(scene.environment.gravity)}}},
      {"hold", holds},
      {"load", loads},
      {"strike", strikes},
      {"plane", planes},
      {"start", {{"velocity", to_json(scene.start_velocity)}, {"spin", to_json(scene.start_spin)}}},
      {"solve", to_json(scene.solve)},
      {"expect", to_json(scene.expectations)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace);  // an override need not be valid UTF-8
}

}  // namespace

const std::string& to_string(ContactLaw law) { return name_of(law, contact_laws); }

std::string scene_text(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const TomlFile toml(file, overrides, known_keys(), old_keys);
  std::ostringstream text;
  text << toml::toml_formatter(toml.root()) << "\n";
  return text.str();
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const TomlFile toml(file, overrides, known_keys(), old_keys);
  const TomlTable root(toml);
  Asked asked;
  Scene scene;
  scene.file = file;
  scene.name = file.stem().string();
  scene.body = read_body(root, file.parent_path(), asked);
  scene.environment = read_environment(root);
  if (const TomlTable material = root.table("material"); material.has("model"))
    scene.model = material.text("model", "a model", "its name, such as \"springs\"");
  scene.start_velocity = root.table("start").vector("velocity", velocity, Vec3::Zero());
  scene.start_spin = root.table("start").vector("spin", spin, Vec3::Zero());
  scene.solve = read_solve(root.table("solve"));
  scene.expectations = read_expectations(root.table("expect"));
  check_selections(root, scene.body, scene.environment);
  scene.warnings = read_warnings(scene);
  scene.resolved = to_json(scene, asked);
  return scene;
}

}  // namespace mss
