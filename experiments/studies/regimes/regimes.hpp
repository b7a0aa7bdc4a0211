#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"

namespace mss::studies::regimes {

/// The time between two pictures [s].
inline constexpr double frame = 1.0 / 60;

/// A point of the map: a cube held at one face and released under gravity.
struct RegimePoint {
  int cells = 4;             ///< per edge
  double damping_ratio = 0;  ///< of every spring
  double young = 1e6;        ///< [Pa]

  /// Its name in the journal.
  std::string name() const;
};

/// Kinds of methods that the map distinguishes.
enum class Kind { explicit_steps, linear_systems, quasi_newton, second_order, projections, descents, none };
Kind kind_of(const std::string& method);
/// In the enumeration's order.
std::vector<std::string> kind_labels();

/// What is asked of a method.
struct Demand {
  std::string name;   ///< in tables
  std::string label;  ///< on charts
  bool at_rest;       ///< of the equilibrium, not of the motion
  double error;       ///< largest allowed, over the displacement
};
const std::vector<Demand>& demands();

/// What `mss regimes` computes.
struct RegimesConfig {
  std::vector<int> cells;
  std::vector<double> damping_ratios;
  std::vector<double> moduli;  ///< of the coarse grid, ascending; equal ratios [Pa]
  int halvings = 0;            ///< of that ratio, between neighbours where another kind is cheapest
  int frames = 10;
  int repetitions = 3;
  double most_seconds = 10;  ///< that the reference of a motion may take, and a run of it
};
RegimesConfig regimes_config(const ExperimentOptions& options);

/// The runs of one point, as the journal keeps them.
Json compute_point(const RegimePoint& point, const RegimesConfig& config);

struct RegimesTables {
  Table runs;        ///< per point, motion or rest, method, and steps a frame or tolerance
  Table points;      ///< per point: what an explicit step takes, and the safe one
  Table cheapest;    ///< per point and demand
  Table boundaries;  ///< per resolution and damping: where explicit and implicit frames cost the same
  Status status = Status::ok;
};
RegimesTables measure_regimes(const RegimesConfig& config, int processes, Journal& journal,
                              Progress& progress);

/// Of the runs: for every point and demand the cheapest method that meets it, and the next of another kind; a
/// tie if their quartiles overlap, or differ by less than a tenth.
Table cheapest_methods(const Table& runs);

/// For every resolution and damping the modulus from which frames that only stay stable are cheaper by a
/// method for any step. Predicted: where as many explicit steps as a frame needs of the safe one, at what one
/// of them takes, cost as much as such a method's cheapest frame. Measured: between the neighbouring points
/// of the map where the cheapest kind changes.
Table boundaries(const Table& points, const Table& runs, const Table& cheapest, int frames);

/// The maps, a panel per resolution and demand.
Drawings draw_regimes(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::regimes
