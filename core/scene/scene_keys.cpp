// What a scene file may say, by table.
#include "core/scene/scene_keys.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "core/measures/measures.hpp"
#include "core/scene/allowed.hpp"
#include "core/scene/scene_reference.hpp"

namespace mss {

namespace {

using namespace allowed;
using Json = nlohmann::ordered_json;

/// Access to a member, for what takes access by a function.
template <class Target, class Member>
auto at(Member Target::*member) {
  return [member](auto& target) -> auto& { return target.*member; };
}

/// A key whose value `read(table, target, name)` takes from a table and `write(target)` gives as JSON.
template <class Target, class Read, class Write>
SceneKey<Target> key(std::string name, std::string allowed, std::string meaning, Read read, Write write) {
  return {{name, std::move(allowed), std::move(meaning)},
          [name, read](const TomlTable& table, Target& target) { read(table, target, name); },
          [name, write](const Target& target, Json& json) { json[name] = write(target); }};
}

template <class Target, class Access>
SceneKey<Target> number(const char* name, const Quantity& quantity, Access access, const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.number(n, quantity, access(target));
      },
      [=](const Target& target) { return Json(access(target)); });
}
/// One without a default.
template <class Target, class Access>
SceneKey<Target> needed_number(const char* name, const Quantity& quantity, Access access,
                               const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.number(n, quantity);
      },
      [=](const Target& target) { return Json(access(target)); });
}
template <class Target, class Access>
SceneKey<Target> whole(const char* name, const Quantity& quantity, Access access, const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.whole(n, quantity, access(target));
      },
      [=](const Target& target) { return Json(access(target)); });
}
template <class Target, class Access>
SceneKey<Target> truth(const char* name, Access access, const char* meaning) {
  return key<Target>(
      name, "true or false", meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.boolean(n, access(target));
      },
      [=](const Target& target) { return Json(access(target)); });
}
template <class Target, class Access>
SceneKey<Target> vector(const char* name, const Quantity& quantity, Access access, const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.vector(n, quantity, access(target));
      },
      [=](const Target& target) { return to_json(access(target)); });
}
template <class Target, class Access>
SceneKey<Target> needed_vector(const char* name, const Quantity& quantity, Access access,
                               const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.vector(n, quantity);
      },
      [=](const Target& target) { return to_json(access(target)); });
}
/// A vector of length 1, from one of any.
template <class Target, class Access>
SceneKey<Target> direction(const char* name, const Quantity& quantity, Access access, const char* meaning) {
  return key<Target>(
      name, std::string(quantity.allowed), meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        const Vec3 read = table.vector(n, quantity);
        if (!(read.stableNorm() > 0))
          table.reject(n, fmt::format("is not {}; give {}", quantity.noun, quantity.allowed));
        access(target) = read.stableNormalized();
      },
      [=](const Target& target) { return to_json(access(target)); });
}
template <class Target, class Access>
SceneKey<Target> name_of_method(const char* name, const char* noun, const char* allowed, Access access,
                                const char* meaning) {
  return key<Target>(
      name, allowed, meaning,
      [=](const TomlTable& table, Target& target, const std::string& n) {
        if (table.has(n)) access(target) = table.text(n, noun, allowed);
      },
      [=](const Target& target) { return Json(access(target)); });
}
template <class Value>
using Names = std::vector<std::pair<std::string, Value>>;
template <class Value>
std::string listed(const Names<Value>& names) {
  std::string all;
  for (const auto& [name, value] : names) all += fmt::format("{}\"{}\"", all.empty() ? "" : ", ", name);
  return all;
}
template <class Target, class Value, class Access>
SceneKey<Target> choice(const char* name, const char* noun, const Names<Value>& names, Access access,
                        const char* meaning) {
  return key<Target>(
      name, listed(names), meaning,
      [=, &names](const TomlTable& table, Target& target, const std::string& n) {
        access(target) = table.choice(n, noun, names, access(target));
      },
      [=, &names](const Target& target) { return Json(allowed::name_of(access(target), names)); });
}
constexpr const char* corners = "two corners of a box, [[x, y, z], [x, y, z]]";
template <class Target>
SceneKey<Target> box(const char* meaning) {
  return key<Target>(
      "box", corners, meaning,
      [](const TomlTable& table, Target& target, const std::string& n) { target.box = table.box(n); },
      [](const Target& target) { return to_json(target.box); });
}
/// A box of particles, or of vertices of a mesh, which are read together.
template <class Target>
SceneKeys<Target> two_boxes() {
  const auto of_particles = [](const Target& target, Json& json) {
    if (!target.surface) json["box"] = to_json(target.box);
  };
  const auto of_vertices = [](const Target& target, Json& json) {
    if (target.surface) json["surface_box"] = to_json(target.box);
  };
  return {{{"box", corners, "its particles at rest [m]"}, {}, of_particles},
          {{"surface_box", corners, "in place of it: vertices of the mesh [m]"}, {}, of_vertices}};
}
template <class Target>
SceneKeys<Target> and_also(SceneKeys<Target> keys, const SceneKeys<Target>& more) {
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

std::array<bool, 3> read_axes(const TomlTable& table, const std::string& name) {
  constexpr auto allowed = "one or more of the letters x, y and z, as in \"xyz\"";
  std::array<bool, 3> axes{};
  for (const char letter : table.text(name, "a set of axes", allowed)) {
    const bool known = letter >= 'x' && letter <= 'z';
    if (!known || axes[static_cast<std::size_t>(letter - 'x')])
      table.reject(name, fmt::format("is not a set of axes; give {}", allowed));
    axes[static_cast<std::size_t>(letter - 'x')] = true;
  }
  return axes;
}
std::string written_axes(const std::array<bool, 3>& axes) {
  std::string letters;
  for (std::size_t a = 0; a < 3; ++a)
    if (axes[a]) letters += "xyz"[a];
  return letters;
}

/// "paper" is what "thesis" was called before.
void read_contact_law(const TomlTable& table, Plane& plane, const std::string& name) {
  if (table.is_text(name) && table.text(name, "a law of contact", "a name") == "paper")
    plane.contact = ContactLaw::thesis;
  else
    plane.contact = table.choice(name, "a law of contact", contact_laws, plane.contact);
}

/// Which shapes have a key; all others are of every shape.
bool has_key(ObstacleShape shape, std::string_view key) {
  using enum ObstacleShape;
  const bool round = shape == capsule || shape == cylinder;
  if (key == "radius") return round || shape == sphere;
  if (key == "length" || key == "axis") return round;
  if (key == "size") return shape == box;
  if (key == "mesh" || key == "mesh_scale") return shape == mesh;
  return shape == box || shape == mesh;  // rotation
}

/// A key that only some shapes have.
SceneKey<Obstacle> of_shape(const SceneKey<Obstacle>& key) {
  SceneKey<Obstacle> limited = key;
  limited.read = [key](const TomlTable& table, Obstacle& obstacle) {
    if (has_key(obstacle.shape, key.name)) return key.read(table, obstacle);
    if (table.has(key.name))
      table.reject(key.name, fmt::format("is not of shape \"{}\"; leave it out, or give another shape",
                                         name_of(obstacle.shape, obstacle_shapes)));
  };
  limited.write = [key](const Obstacle& obstacle, Json& json) {
    if (has_key(obstacle.shape, key.name)) key.write(obstacle, json);
  };
  return limited;
}

const SceneKeys<Obstacle>& rotation_keys() {
  static const SceneKeys<Obstacle> keys{
      direction<Obstacle>("axis", axis, at(&Obstacle::axis), "about which"),
      needed_number<Obstacle>("degrees", turned_by, at(&Obstacle::degrees), "how far")};
  return keys;
}

/// How a path in time is read and written.
template <class Target>
SceneKey<Target> path_key(const char* meaning) {
  return {{"path", std::string(path.allowed), meaning},
          [](const TomlTable& table, Target& target) {
            if (!table.has("path")) return;
            for (const std::vector<double>& row : table.rows("path", path, 4))
              target.path.points.push_back({row[0], Vec3(row[1], row[2], row[3])});
          },
          [](const Target& target, Json& json) {
            for (const auto& [t, by] : target.path.points) json["path"].push_back({t, by[0], by[1], by[2]});
          }};
}

void read_step(const TomlTable& table, SolveConfig& solve, const std::string& name) {
  if (table.is_text(name)) {
    if (table.text(name, step.noun, step.allowed) != "safe")
      table.reject(name, fmt::format("is not {}; give {}", step.noun, step.allowed));
  } else if (table.has(name)) {
    solve.dt = table.number(name, step);
  }
}

}  // namespace

Json to_json(const Vec3& v) { return {v[0], v[1], v[2]}; }
Json to_json(const Box& box) { return {to_json(box.lower), to_json(box.upper)}; }

const SceneKeys<Hold>& hold_keys() {
  static const SceneKeys<Hold> keys = and_also(
      two_boxes<Hold>(),
      {key<Hold>(
           "axes", "one or more of the letters x, y and z", "the coordinates that are prescribed; all",
           [](const TomlTable& table, Hold& hold, const std::string& n) {
             if (table.has(n)) hold.axes = read_axes(table, n);
           },
           [](const Hold& hold) { return Json(written_axes(hold.axes)); }),
       vector<Hold>("velocity", velocity, at(&Hold::velocity), "with which it moves [m/s]"),
       vector<Hold>("displacement", displacement, at(&Hold::displacement), "by which it moves at once [m]"),
       path_key<Hold>("by which it moves in time, straight from row to row [s, m]"),
       {{"turn", "a table", "how it turns"}}});
  return keys;
}

const SceneKeys<Turn>& turn_keys() {
  static const SceneKeys<Turn> keys{
      direction<Turn>("axis", axis, at(&Turn::axis), "about which"),
      needed_vector<Turn>("centre", position, at(&Turn::centre), "a point of the axis [m]"),
      needed_number<Turn>("rate", turn_rate, at(&Turn::rate), "how fast [rad/s]"),
      {{"until", std::string(duration.allowed), "when it stops [s]; never"},
       [](const TomlTable& table, Turn& turn) { turn.until = table.number("until", duration, turn.until); },
       [](const Turn& turn, Json& json) {
         if (std::isfinite(turn.until)) json["until"] = turn.until;
       }}};
  return keys;
}

const SceneKeys<Load>& load_keys() {
  static const SceneKeys<Load> keys = and_also(
      two_boxes<Load>(), {needed_vector<Load>("force", force, at(&Load::force), "on all of it together [N]"),
                          {{"history", std::string(history.allowed),
                            "which share of the force acts when, straight from row to row [s, 1]; all of it"},
                           [](const TomlTable& table, Load& load) {
                             if (!table.has("history")) return;
                             for (const std::vector<double>& row : table.rows("history", history, 2))
                               load.history.points.push_back({row[0], row[1]});
                           },
                           [](const Load& load, Json& json) {
                             for (const auto& [t, share] : load.history.points)
                               json["history"].push_back({t, share});
                           }}});
  return keys;
}

const SceneKeys<Strike>& strike_keys() {
  static const SceneKeys<Strike> keys{
      box<Strike>("its particles at rest [m]"),
      needed_number<Strike>("at", time_of_strike, at(&Strike::at), "when [s]"),
      needed_vector<Strike>("impulse", impulse, at(&Strike::impulse), "on all of it together [N s]")};
  return keys;
}

const SceneKeys<Plane>& plane_keys() {
  static const SceneKeys<Plane> keys{
      needed_vector<Plane>("point", position, at(&Plane::point), "any point of it [m]"),
      direction<Plane>("normal", normal, at(&Plane::normal), "towards the side where bodies may be"),
      key<Plane>("contact", listed(contact_laws), "the law of contact, see core/environment/README.md",
                 read_contact_law, [](const Plane& plane) { return Json(to_string(plane.contact)); }),
      number<Plane>("restitution", restitution, at(&Plane::restitution),
                    "of a particle: its speed after a collision over that before"),
      number<Plane>("friction", friction, at(&Plane::friction), "Coulomb's coefficient")};
  return keys;
}

const SceneKeys<Obstacle>& obstacle_keys() {
  static const SceneKeys<Obstacle> keys{
      key<Obstacle>(
          "shape", listed(obstacle_shapes), "what it is",
          [](const TomlTable& table, Obstacle& obstacle, const std::string& n) {
            if (!table.has(n)) table.reject_missing(n, "give " + listed(obstacle_shapes));
            obstacle.shape = table.choice(n, "a shape", obstacle_shapes, obstacle.shape);
          },
          [](const Obstacle& obstacle) { return Json(name_of(obstacle.shape, obstacle_shapes)); }),
      of_shape(needed_number<Obstacle>("radius", length, at(&Obstacle::radius),
                                       "of a sphere, a capsule, a cylinder [m]")),
      of_shape(needed_number<Obstacle>(
          "length", length, at(&Obstacle::length),
          "of a capsule between the centres of its caps, of a cylinder between its faces [m]")),
      of_shape(needed_vector<Obstacle>("size", box_edges, at(&Obstacle::size), "of a box, its edges [m]")),
      of_shape(key<Obstacle>(
          "mesh", "a file name", "a closed triangle mesh, by its path from the scene file",
          [](const TomlTable& table, Obstacle& obstacle, const std::string& n) {
            obstacle.mesh_file = table.text(n, "a file name",
                                            "the path of an OBJ, STL or PLY file, relative to "
                                            "the scene file");
          },
          [](const Obstacle& obstacle) { return Json(obstacle.mesh_file); })),
      of_shape(number<Obstacle>("mesh_scale", unit_of_mesh, at(&Obstacle::mesh_scale),
                                "metres to a unit of its file; 1")),
      needed_vector<Obstacle>("centre", position, at(&Obstacle::centre),
                              "where its centre is, of a mesh its origin [m]"),
      of_shape(key<Obstacle>(
          "axis", std::string(axis.allowed), "along which a capsule or a cylinder is; [0, 0, 1]",
          [](const TomlTable& table, Obstacle& obstacle, const std::string&) {
            if (table.has("axis")) rotation_keys().front().read(table, obstacle);
          },
          [](const Obstacle& obstacle) { return to_json(obstacle.axis); })),
      of_shape({{"rotation", "a table", "turns a box or a mesh about its centre, before it moves"},
                [](const TomlTable& table, Obstacle& obstacle) {
                  if (table.has("rotation")) read_keys(rotation_keys(), table.table("rotation"), obstacle);
                },
                [](const Obstacle& obstacle, Json& json) {
                  if (obstacle.degrees != 0) json["rotation"] = written(rotation_keys(), obstacle);
                }}),
      path_key<Obstacle>("by which it moves in time, straight from row to row [s, m]"),
      {{"turn", "a table", "how it turns, as a hold does"}},
      choice<Obstacle>("contact", "a law of contact", contact_laws, at(&Obstacle::contact),
                       "as a plane's; \"impulse\""),
      number<Obstacle>("restitution", restitution, at(&Obstacle::restitution), "as a plane's; 0.5"),
      number<Obstacle>("friction", friction, at(&Obstacle::friction), "as a plane's; 0.4")};
  return keys;
}

const SceneKeys<Environment>& environment_keys() {
  static const SceneKeys<Environment> keys{
      vector<Environment>("gravity", acceleration, at(&Environment::gravity), "[m/s^2]")};
  return keys;
}

const SceneKeys<Weight>& weight_keys() {
  static const SceneKeys<Weight> keys{
      box<Weight>("its particles at rest [m]"),
      needed_number<Weight>("mass", mass, at(&Weight::mass),
                            "of all together, beside that of the cells [kg]")};
  return keys;
}

const SceneKeys<RefinedBox>& refine_keys() {
  static const SceneKeys<RefinedBox> keys{
      box<RefinedBox>("where cells are split in eight [m]"),
      whole<RefinedBox>("levels", split_levels, at(&RefinedBox::levels), "how often")};
  return keys;
}

const SceneKeys<BodyContact>& contact_keys() {
  using C = BodyContact;
  static const SceneKeys<C> keys{
      truth<C>("bodies", at(&C::bodies), "bodies touch each other"),
      truth<C>("self", at(&C::self), "bodies touch themselves"),
      number<C>("friction", friction, at(&C::friction), "Coulomb's coefficient"),
      number<C>("stiffness", contact_stiffness, at(&C::stiffness),
                "of a touch over that of the cells that touch, see core/bodies/README.md")};
  return keys;
}

const SceneKeys<SceneBody>& start_keys() {
  using S = SceneBody;
  static const SceneKeys<S> keys{
      vector<S>("velocity", velocity, at(&S::start_velocity), "of the body [m/s]"),
      vector<S>("angular_velocity", angular_velocity, at(&S::start_angular_velocity),
                "of the body about its centre of mass [rad/s]")};
  return keys;
}

const SceneKeys<SolveConfig>& solve_keys() {
  using S = SolveConfig;
  const auto bound = [](auto& solve) -> auto& { return solve.sleep.bound; };
  const auto after = [](auto& solve) -> auto& { return solve.sleep.after; };
  static const SceneKeys<S> keys{
      name_of_method<S>("integrator", "an integrator", "its name, such as \"verlet\"", at(&S::integrator),
                        "the method, of `mss list integrators`; METHOD:N, METHOD/SOLVER or METHOD/SOLVER:N "
                        "fix iterations and nonlinear_solver too"),
      key<S>(
          "dt", std::string(step.allowed),
          "the step [s]; \"safe\": 0.9 of the guaranteed stability limit; of adaptive methods the first step",
          read_step, [](const S& solve) { return solve.dt ? Json(*solve.dt) : Json("safe"); }),
      number<S>("duration", duration, at(&S::duration), "what is simulated [s]"),
      whole<S>("threads", thread_count, at(&S::threads), "that compute forces; 0: as many as save time"),
      choice<S>("precision", "a precision", precisions, at(&S::precision), "of all numbers"),
      name_of_method<S>("device", "a device", "\"cpu\", \"gpu\", or \"gpu:N\"", at(&S::device),
                        "that takes the steps, of `mss list devices`; \"gpu\": the first card, or else "
                        "software in its place"),
      name_of_method<S>("linear_solver", "a linear solver", "its name, such as \"cholmod\"",
                        at(&S::linear_solver), "of implicit methods, of `mss list linear_solvers`"),
      name_of_method<S>("nonlinear_solver", "a nonlinear solver", "its name, such as \"lbfgs\"",
                        at(&S::nonlinear_solver), "of implicit methods, of `mss list nonlinear_solvers`"),
      whole<S>("iterations", iteration_count, at(&S::iterations),
               "of the nonlinear solver in a stage, or passes of xpbd and vbd; 0: as many as its tolerance "
               "needs, or one pass"),
      choice<S>("tangent", "a tangent", tangents, at(&S::tangent),
                "of implicit methods; projected where the elastic is indefinite"),
      number<S>("spectral_radius", spectral_radius, at(&S::spectral_radius),
                "of generalized_alpha, at infinite steps"),
      number<S>("chebyshev_radius", radius_of_a_pass, at(&S::chebyshev_radius),
                "of vbd: the spectral radius of a pass, for Chebyshev's semi-iteration; 0: none"),
      whole<S>("region_width", region_width, at(&S::region_width),
               "of shape_matching, in cells; 0: one region"),
      number<S>("alpha", alpha, at(&S::alpha),
                "of shape_matching: the share of the way to the goal in a step"),
      number<S>("tolerance", tolerance, at(&S::tolerance),
                "of adaptive methods: local error over a cell's size; of dynamic_relaxation, and static but "
                "by newton: how far the body may still move, in cells"),
      number<S>("every", interval, at(&S::every), "seconds between rows of series.csv"),
      truth<S>("local_steps", at(&S::local_steps),
               "of cells of several sizes: larger cells take longer steps"),
      number<S>("sleep", sleep_bound, bound,
                "how far a plane of particles that sleeps may be from where it would be [m]; 0: none sleeps"),
      number<S>("sleep_after", interval, after, "how long particles rest before they sleep [s]")};
  return keys;
}

namespace {

/// Keys whose values depend on each other: scene.cpp reads them one after the other.
struct Together {
  const char* table;
  std::vector<KeyText> keys;
};
const std::vector<Together>& read_together() {
  static const std::vector<Together> all{
      {"body",
       {{"cells", "three whole numbers, not all of them 0",
         "a box of so many cells; [n, m, 0] is a sheet of squares, [n, 0, 0] a rope, along any axes"},
        {"voxels", "a file name", "in place of it: a text file of cells, layer by layer"},
        {"mesh", "a file name", "in place of it: a triangle mesh, which cells fill"},
        {"refine", std::string(split_parts.allowed), "parts that an edge of a cell is split into; 1"},
        {"refinement", "\"auto\"", "cells are chosen to be smaller, by an estimate of the error at rest"},
        {"refinement_levels", std::string(split_levels.allowed), "how often at most; 1"},
        {"refinement_goal", listed(refinement_goals), "of what the error is estimated; \"energy\""},
        {"cell_size", std::string(length.allowed), "the edge of a cell [m]"},
        {"thickness", std::string(length.allowed),
         "of a sheet, and of a rope the edge of its square section [m]; cell_size, which is warned of"},
        {"match", listed(frequency_matches),
         "E, or E and nu, are changed so that these slowest vibrations are those of smaller cells, see "
         "experiments/README.md"},
        {"match_to", std::string(matched_parts.allowed),
         "parts that each cell's edge is split into for that; the limit of many"},
        {"cells_across", "a whole number of at least 1",
         "of a mesh, in place of it: cells along its longest extent"},
        {"origin", std::string(position.allowed), "where the body's lowest corner is [m]; [0, 0, 0]"},
        {"topology", listed(topologies), "which springs there are; \"full\""},
        {"sharing", listed(sharings), "how cells share springs; \"weighted\""},
        {"mesh_scale", "a positive number", "metres to a unit of the mesh's file; 1"},
        {"mesh_rotation", "a table", "turns the mesh"},
        {"mesh_translation", std::string(position.allowed), "then moves it [m]"},
        {"fill", "\"local\", \"staircase\"",
         "what a mesh fills of a cell, see core/mesh/README.md; \"local\""},
        {"contact_on", "\"particles\", \"surface\"",
         "what planes touch: particles, or the mesh's vertices; \"particles\""},
        {"name", "a text", "of one of several bodies, which are [[body]]"},
        {"material", "a table", "as [material], whose keys it stands for"},
        {"damping", "a table", "as [damping], in place of it"},
        {"start", "a table", "as [start], whose keys it stands for"},
        {"part", "an array of tables", "as [[part]]"},
        {"weight", "an array of tables", "as [[weight]]"}}},
      {"body.mesh_rotation",
       {{"axis", std::string(axis.allowed), "about which"}, {"degrees", "a finite number", "how far"}}},
      {"material",
       {{"model", "a name",
         "what fills the cells, of `mss list models`; modal ones need solve.integrator = \"reduced\", see "
         "integrators/reduction/README.md; \"springs\""},
        {"modes", std::string(mode_count.allowed),
         "of models that reduce the body, how many shapes; 8, modal_cubic 16, where nothing is held 18"},
        {"density", std::string(density.allowed), "[kg/m^3]"},
        {"young", std::string(young.allowed), "E, for which springs are calibrated [Pa]"},
        {"poisson", std::string(poisson.allowed), "nu"},
        {"face_share", std::string(share.allowed),
         "the part of shear stiffness that face diagonals carry; 0.5"},
        {"springs", "a table", "in place of E and nu: spring constants"},
        {"volume", std::string(volume.allowed), "beside these: the volume stiffness k_vol [Pa]; 0"},
        {"volume_force", "true or false", "false: calibrated springs without a volume force; true"},
        {"fold_guard", std::string(guard.allowed), "keeps cells from folding; 0: nothing does"},
        {"relaxation", "a table", "springs relax, as a standard linear solid"}}},
      {"material.relaxation",
       {{"ratio", std::string(relaxation_ratio.allowed), "of a Maxwell branch's stiffness to its spring's"},
        {"time", std::string(relaxation_time.allowed), "in which its tension decays to 1/e [s]"}}},
      {"material.springs",
       {{"edge", std::string(spring.allowed), "along edges [N/m]"},
        {"face", std::string(spring.allowed), "across faces [N/m]"},
        {"body", std::string(spring.allowed), "through the body of a cell [N/m]"}}},
      {"damping",
       {{"ratio", std::string(damping_ratio.allowed),
         "of a spring's damper to the critical one of its two particles; 0"},
        {"viscosity", std::string(viscosity.allowed), "in place of it: of shear [Pa s]; 0"},
        {"thesis", "true or false", "in place of both: the thesis's eq. 2-4; false"}}},
      {"part",
       {{"name", "a text", "of a material in some cells; in voxel files a letter from A to Z"},
        {"mesh", "a file name", "what it fills, if the body is a mesh"},
        {"density", std::string(density.allowed), "[kg/m^3]; [material]'s, as the next"},
        {"young", std::string(young.allowed), "[Pa]"},
        {"poisson", std::string(poisson.allowed), "nu"},
        {"damping", "a table", "as [damping]"}}},
      {"expect.displacement",
       {{"box", corners, "its particles at rest [m]"},
        {"surface_box", corners, "in place of it: vertices of the mesh [m]"},
        {"value", std::string(displacement.allowed), "their mean displacement at the end [m]"},
        {"within", std::string(margin.allowed), "how far each number may be off"}}}};
  return all;
}

struct TextTable {
  std::string heading;
  std::vector<KeyText> keys;
  Json defaults;  ///< by key
};
template <class Target>
TextTable texts(const std::string& table, const SceneKeys<Target>& keys, bool has_defaults) {
  return {table, {keys.begin(), keys.end()}, has_defaults ? written(keys, Target{}) : Json::object()};
}
/// All tables but [expect], whose keys are columns.
std::vector<TextTable> all_tables() {
  std::vector<TextTable> all;
  for (const Together& together : read_together())
    all.push_back({together.table, together.keys, Json::object()});
  all.push_back(texts("weight", weight_keys(), false));
  all.push_back(texts("refine", refine_keys(), true));
  all.push_back(texts("environment", environment_keys(), true));
  all.push_back(texts("contact", contact_keys(), true));
  all.push_back(texts("hold", hold_keys(), true));
  all.push_back(texts("hold.turn", turn_keys(), false));
  all.push_back(texts("load", load_keys(), false));
  all.push_back(texts("strike", strike_keys(), false));
  all.push_back(texts("plane", plane_keys(), true));
  all.push_back(texts("obstacle", obstacle_keys(), false));
  all.push_back(texts("obstacle.rotation", rotation_keys(), false));
  all.push_back(texts("obstacle.turn", turn_keys(), false));
  all.push_back(texts("start", start_keys(), true));
  all.push_back(texts("solve", solve_keys(), true));
  return all;
}

KnownKeys make_keys() {
  KnownKeys keys{{"",
                  {"body", "material", "damping", "part", "weight", "refine", "environment", "contact",
                   "hold", "load", "strike", "plane", "obstacle", "start", "solve", "expect"}},
                 {"expect", {energy_drift, mean_displacement}},
                 {"expect.energy_drift", {"value", "within"}}};
  for (const TextTable& table : all_tables())
    for (const KeyText& text : table.keys) keys[table.heading].push_back(text.name);
  keys["part.damping"] = keys["damping"];
  for (const char* table : {"part", "part.damping", "weight", "material", "material.springs",
                            "material.relaxation", "damping", "start"})
    keys[fmt::format("body.{}", table)] = keys[table];
  for (const MeasureColumn& column : measure_columns) {
    keys["expect"].emplace_back(column.name);
    keys["expect." + std::string(column.name)] = {"value", "within"};
  }
  for (const char* force : {"hold_#", "plane_#", "obstacle_#", "obstacle_#_torque"})
    for (const char* axis : {"_x", "_y", "_z"}) {
      keys["expect"].push_back(std::string(force) + axis);
      keys["expect." + keys["expect"].back()] = {"value", "within"};
    }
  for (const char* column :
       {"body_#_x", "body_#_y", "body_#_z", "body_#_kinetic", "body_#_volume_ratio", "body_#_min_jacobian",
        "contact_touches", "contact_depth", "contact_force", "contact_energy"}) {
    keys["expect"].emplace_back(column);
    keys["expect." + std::string(column)] = {"value", "within"};
  }
  return keys;
}

bool is_array(const std::string& table) {
  for (const char* array : {"part", "weight", "refine", "hold", "load", "strike", "plane", "obstacle"})
    if (table == array) return true;
  return false;
}

}  // namespace

const KnownKeys& scene_keys() {
  static const KnownKeys keys = make_keys();
  return keys;
}

const RenamedKeys& renamed_scene_keys() {
  static const RenamedKeys all = [] {
    RenamedKeys keys{{"damping", {{"paper", "thesis"}}},
                     {"start", {{"spin", "angular_velocity"}}},
                     {"solve", {{"acceleration", "chebyshev_radius"}}}};
    for (const auto& [before, now] : renamed_columns) keys["expect"].emplace(before, now);
    return keys;
  }();
  return all;
}

std::string scene_reference() {
  std::string text;
  for (const TextTable& table : all_tables()) {
    text += fmt::format("\n### `{}`\n\n", is_array(table.heading) ? fmt::format("[[{}]]", table.heading)
                                                                  : fmt::format("[{}]", table.heading));
    text += "| key | what it is | what may be given | default |\n|---|---|---|---|\n";
    for (const KeyText& key : table.keys) {
      const bool has_default = table.defaults.contains(key.name) && key.name != "box" &&
                               key.name != "point" && key.name != "normal";
      text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, key.meaning, key.allowed,
                          has_default ? fmt::format("`{}`", table.defaults[key.name].dump()) : "");
    }
  }
  return text;
}

std::vector<std::pair<std::string, std::string>> scene_key_lines() {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const TextTable& table : all_tables())
    for (const KeyText& key : table.keys)
      lines.emplace_back(fmt::format("{}.{}", table.heading, key.name),
                         fmt::format("{} ({})", key.meaning, key.allowed));
  return lines;
}

}  // namespace mss
