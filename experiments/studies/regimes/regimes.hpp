#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/held_cube.hpp"

namespace mss::studies::regimes {

/// A point of the map: a scene that people have, in a material.
struct RegimePoint {
  std::string scene = "held_box";  ///< see bench_scenes.hpp
  int cells = 4;                   ///< as the scene counts them
  double damping_ratio = 0;        ///< of every spring
  double young = 1e6;              ///< [Pa]

  /// Its name in the journal.
  std::string name() const;
};

/// Kinds of methods that the map distinguishes.
enum class Kind { explicit_steps, linear_systems, quasi_newton, second_order, projections, descents, none };
Kind kind_of(const std::string& method);
/// In the enumeration's order.
std::vector<std::string> kind_labels();

/// What is asked of a method. Always that it stays within bounds, see motion_bounds.hpp.
struct Demand {
  std::string name;   ///< in tables
  std::string label;  ///< on charts
  bool at_rest;       ///< of the equilibrium, not of the motion
  double error;       ///< largest allowed, over the displacement; infinite: any
};
const std::vector<Demand>& demands();

/// An error is only judged where the true motion is known so many times better.
inline constexpr double certainty = 10;
/// The status where it is not.
inline constexpr const char* uncertain = "the reference is not that certain";

/// Where a run stays within bounds, what its column says.
inline constexpr const char* within_bounds = "within";

/// A cube held at one face and pushed sideways at the opposite one, which it follows until it is at rest.
struct LoadedConfig {
  int cells = 10;              ///< per edge
  double damping_ratio = 0.5;  ///< of every spring
  double force = 1e5;          ///< [N]
  int frames = 60;
  std::vector<double> moduli;  ///< ascending [Pa]
};

/// A map: of one scene, over stiffness and damping.
struct RegimesGrid {
  std::string scene;
  int cells;
  std::vector<double> damping_ratios;
  std::vector<double> moduli;  ///< of the coarse grid, ascending; equal ratios [Pa]
  int halvings = 0;            ///< of that ratio, between neighbours where another kind is cheapest
};

/// What `mss regimes` computes.
struct RegimesConfig {
  std::vector<RegimesGrid> grids;
  int frames = 0;  ///< 0: as the scene has them
  int repetitions = 3;
  double most_seconds = 1;                         ///< that a run may take
  double most_over_best = 1.5;                     ///< times the time of the quickest that meets the same
  double most_reference_seconds = 40;              ///< that the reference of a motion or a rest may take
  int reference_threads = as_many_threads_as_pay;  ///< of that of a motion, which is not timed
  LoadedConfig loaded = {};
};
RegimesConfig regimes_config(const ExperimentOptions& options);

/// Steps a frame, iterations or passes a step, and tolerances of linear solvers, that are tried of every
/// family that has them. The rule by which all are tuned: of these, and of the settings that the family alone
/// has, the cheapest that meets the demand.
inline constexpr std::array tried_steps{1, 2, 4, 8, 16, 32};
inline constexpr std::array tried_iterations{1, 2, 5, 10, 20};
inline constexpr std::array tried_tolerances{1e-2, 1e-4, 1e-6};

/// How far a step is solved.
struct Effort {
  int iterations = 0;    ///< 0: as many as it takes
  double tolerance = 0;  ///< of a linear solver; 0: it has none
};

/// A method for any step, with a choice of what it alone has.
struct RegimeFamily {
  std::string method;             ///< without its number of iterations
  IntegratorOptions own{};        ///< linear solver, Chebyshev's radius
  std::string setting{};          ///< the same in words
  std::vector<Effort> efforts{};  ///< ascending
  int untuned = -1;  ///< index of the effort that it was given before it was tuned; -1: none of these
};
const std::vector<RegimeFamily>& regime_families();

/// The runs of one point, as the journal keeps them.
Json compute_point(const RegimePoint& point, const RegimesConfig& config);

/// The loaded cube of one modulus by every method, as the journal keeps it.
Json compute_loaded(double young, const RegimesConfig& config);

struct RegimesTables {
  Table runs;        ///< per point, motion or rest, method, setting, and steps a frame or tolerance
  Table points;      ///< per point: what an explicit step takes, and the safe one
  Table cheapest;    ///< per point and demand
  Table families;    ///< per point, demand and family: tuned, and as it was before
  Table boundaries;  ///< per scene and damping: where explicit and implicit frames cost the same
  Table loaded;      ///< the loaded cube: per modulus and method
  Table crossings;   ///< of it: per implicit method, from where on it costs less than any explicit one
  Status status = Status::ok;
};
RegimesTables measure_regimes(const RegimesConfig& config, int processes, Journal& journal,
                              Progress& progress);
/// All tables under the names of their files.
std::vector<NamedTable> regimes_files(RegimesTables tables);

/// Of the runs: for every point and demand the cheapest method that meets it, and the next of another kind; a
/// tie if their quartiles overlap, or differ by less than a tenth.
Table cheapest_methods(const Table& runs);

/// Of the runs: for every point, demand and family the cheapest that meets the demand, and the cheapest of
/// those that are not tuned.
Table tuned_families(const Table& runs);

/// For every scene, resolution and damping the modulus from which frames that only stay stable are cheaper by
/// a method for any step. Predicted: where as many explicit steps as a frame needs of the safe one, at what
/// one of them takes, cost as much as such a method's cheapest frame. Measured: between the neighbouring
/// points of the map where the cheapest kind changes.
Table boundaries(const Table& points, const Table& runs, const Table& cheapest);

/// The largest of measured over predicted moduli and their inverses, over the rows where both are known; NaN
/// if there is none.
double worst_factor(const Table& boundaries);

/// Where the ratio of two costs passes 1, from its logarithms at ascending moduli: between two of them, or
/// beyond the first or last as if it grew as the square root of the modulus, as explicit steps do. NaN
/// without any.
double crossing(const std::vector<double>& log_moduli, const std::vector<double>& log_ratios);

/// Per modulus and method of the loaded cube: wall time with quartiles, energies at the end [J], how far
/// their sum is from that of velocity Verlet, over it, and how far the motion is, a root mean square over
/// frames and particles, over that of the displacements.
Table empty_loaded();
void add_loaded(const LoadedConfig& config, double young, const Json& runs, Table& loaded);
/// Per method that is no explicit one: the modulus from which on it takes less time than any of those, and
/// how far its energy is from that of velocity Verlet there, at most.
Table loaded_crossings(const Table& loaded);
/// Wall time of the loaded cube against Young's modulus, a line a method.
Chart loaded_chart(const Table& loaded, const Table& crossings);

/// The maps, a row per scene and a column per demand, and the loaded cube.
Drawings draw_regimes(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::regimes
