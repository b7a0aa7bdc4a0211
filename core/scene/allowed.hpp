#pragma once

// What values of a scene file may be: of numbers what they are called and which are allowed, of names which
// there are.

#include "core/scene/scene.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss::allowed {

inline constexpr auto any = [](double) { return true; };
inline constexpr auto positive = [](double value) { return value > 0; };
inline constexpr auto not_negative = [](double value) { return value >= 0; };

inline constexpr Quantity cell_counts{"a number of cells",
                                      "three whole numbers, 0 where a sheet or a rope has no extent, or "
                                      "voxels = \"file\"",
                                      [](double value) { return value >= 0; }};
inline constexpr Quantity split_parts{"a number of parts of an edge", "a whole number of at least 1",
                                      [](double value) { return value >= 1; }};
inline constexpr Quantity split_levels{"a number of levels", "a whole number from 1 to 4, each halves cells",
                                       [](double value) { return value >= 1 && value <= 4; }};
inline constexpr Quantity matched_parts{"a number of parts of an edge",
                                        "a whole number from 2 to 64, or none for the limit",
                                        [](double value) { return value >= 2 && value <= 64; }};
inline constexpr Quantity mode_count{"a number of modes", "a whole number from 1 to 64",
                                     [](double value) { return value >= 1 && value <= 64; }};
inline constexpr Quantity length{"a length", "a positive number of metres", positive};
inline constexpr Quantity position{"a position", "three finite numbers of metres", any};
inline constexpr Quantity density{"a density", "a positive number of kg/m^3", positive};
inline constexpr Quantity mass{"a mass", "a positive number of kilograms", positive};
inline constexpr Quantity young{"a stiffness", "a positive number of pascals", positive};
inline constexpr Quantity poisson{"a Poisson's ratio of finite stiffness", "a number above -1 and below 0.5",
                                  [](double value) { return value > -1 && value < 0.5; }};
inline constexpr Quantity share{"a share", "a number from 0 to 1",
                                [](double value) { return value >= 0 && value <= 1; }};
inline constexpr Quantity spring{"a spring constant", "a number of N/m that is not negative", not_negative};
inline constexpr Quantity volume{"a volume stiffness", "a finite number of pascals", any};
inline constexpr Quantity guard{"a stiffness of the fold guard",
                                "a number of shear moduli that is not negative", not_negative};
inline constexpr Quantity relaxation_ratio{
    "a ratio of stiffnesses",
    "a number that is not negative: stiffness at once over that at rest, "
    "less one",
    not_negative};
inline constexpr Quantity relaxation_time{"a time", "a positive number of seconds", positive};
inline constexpr Quantity damping_ratio{"a damping ratio", "a number that is not negative, or thesis = true",
                                        not_negative};
inline constexpr Quantity viscosity{"a viscosity", "a number of Pa s that is not negative", not_negative};
inline constexpr Quantity contact_stiffness{"a stiffness of contact",
                                            "a positive number of stiffnesses of cells", positive};
inline constexpr Quantity acceleration{"an acceleration", "three finite numbers of m/s^2", any};
inline constexpr Quantity velocity{"a velocity", "three finite numbers of m/s", any};
inline constexpr Quantity displacement{"a displacement", "three finite numbers of metres", any};
inline constexpr Quantity axis{"an axis", "a direction [x, y, z] that is not zero", any};
inline constexpr Quantity turn_rate{"an angular rate", "a finite number of rad/s", any};
inline constexpr Quantity angular_velocity{"an angular velocity", "three finite numbers of rad/s", any};
inline constexpr Quantity force{"a force", "three finite numbers of newtons", any};
inline constexpr Quantity path{
    "a path", "rows [t, dx, dy, dz] in seconds and metres, each later than the one before", any};
inline constexpr Quantity box_edges{"a size", "three positive numbers of metres", positive};
inline constexpr Quantity unit_of_mesh{"a scale", "a positive number", positive};
inline constexpr Quantity turned_by{"an angle", "a finite number of degrees", any};
inline constexpr Quantity history{
    "a history", "rows [t, share] of seconds and a number, each later than the one before", any};
inline constexpr Quantity impulse{"an impulse", "three finite numbers of newton seconds", any};
inline constexpr Quantity time_of_strike{"a time", "a finite number of seconds that is not negative",
                                         not_negative};
inline constexpr Quantity sleep_bound{"a distance", "a number of metres that is not negative, 0 for no sleep",
                                      not_negative};
inline constexpr Quantity expected{"a value", "a finite number", any};
inline constexpr Quantity margin{"a margin", "a finite number that is not negative", not_negative};
inline constexpr Quantity normal{"a normal", "a direction [x, y, z] that is not zero", any};
inline constexpr Quantity restitution{"a restitution", "a number from 0 (nothing rebounds) to 1 (no loss)",
                                      [](double value) { return value >= 0 && value <= 1; }};
inline constexpr Quantity friction{"a coefficient of friction", "a number that is not negative",
                                   not_negative};
inline constexpr Quantity step{"a time step", "a positive number of seconds, or \"safe\"", positive};
inline constexpr Quantity duration{"a duration", "a finite number of seconds that is not negative",
                                   not_negative};
inline constexpr Quantity interval{"an interval", "a positive number of seconds", positive};
inline constexpr Quantity tolerance{"a tolerance", "a number above 0 and below 1",
                                    [](double value) { return value > 0 && value < 1; }};
inline constexpr Quantity spectral_radius{
    "a spectral radius at infinite steps",
    "a number from 0 (damps at once what a step cannot resolve) to 1 (keeps it)",
    [](double value) { return value >= 0 && value <= 1; }};
inline constexpr Quantity radius_of_a_pass{"a spectral radius",
                                           "a number from 0 (no acceleration) to below 1",
                                           [](double x) { return x >= 0 && x < 1; }};
inline constexpr Quantity region_width{"a width of regions",
                                       "a whole number of cells from 0 (one region) to 16",
                                       [](double n) { return n >= 0 && n <= 16; }};
inline constexpr Quantity alpha{"a share of the way to the goal", "a number above 0 and up to 1",
                                [](double value) { return value > 0 && value <= 1; }};
inline constexpr int most_threads = 1024;
inline constexpr Quantity iteration_count{"a number of iterations",
                                          "a whole number from 0 (as many as the tolerance needs) to 1000000",
                                          [](double n) { return n >= 0 && n <= 1e6; }};
inline constexpr Quantity thread_count{"a number of threads",
                                       "a whole number from 0 (as many as save time) to 1024",
                                       [](double value) { return value >= 0 && value <= most_threads; }};

inline const std::vector<std::pair<std::string, Topology>> topologies{
    {"full", Topology::full}, {"edges+body", Topology::edges_body}, {"one-diagonal", Topology::one_diagonal}};
inline const std::vector<std::pair<std::string, Sharing>> sharings{{"weighted", Sharing::weighted},
                                                                   {"uniform", Sharing::uniform}};
inline const std::vector<std::pair<std::string, ContactLaw>> contact_laws{
    {"impulse", ContactLaw::impulse}, {"thesis", ContactLaw::thesis}, {"penalty", ContactLaw::penalty}};
inline const std::vector<std::pair<std::string, ObstacleShape>> obstacle_shapes{
    {"sphere", ObstacleShape::sphere},
    {"box", ObstacleShape::box},
    {"capsule", ObstacleShape::capsule},
    {"cylinder", ObstacleShape::cylinder},
    {"mesh", ObstacleShape::mesh}};
inline const std::vector<std::pair<std::string, Tangent>> tangents{{"elastic", Tangent::elastic},
                                                                   {"projected", Tangent::projected}};
inline const std::vector<std::pair<std::string, AutoRefinement::Goal>> refinement_goals{
    {"energy", AutoRefinement::Goal::energy}, {"displacement", AutoRefinement::Goal::displacement}};
inline const std::vector<std::pair<std::string, FrequencyMatch::Of>> frequency_matches{
    {"bending", FrequencyMatch::Of::bending},
    {"torsion", FrequencyMatch::Of::torsion},
    {"both", FrequencyMatch::Of::both},
    {"modes", FrequencyMatch::Of::modes}};
inline const std::vector<std::pair<std::string, Precision>> precisions{{"double", Precision::dbl},
                                                                       {"single", Precision::single}};

template <class Value>
const std::string& name_of(Value value, const std::vector<std::pair<std::string, Value>>& names) {
  for (const auto& [name, named] : names)
    if (named == value) return name;
  return names.front().first;
}

}  // namespace mss::allowed
