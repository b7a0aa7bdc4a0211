#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/refinement/refined_body.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/studies/refine/problems.hpp"

namespace mss::studies::refine {

/// How it is decided which cells of a body are smaller.
enum class Map {
  uniform,    ///< none
  by_hand,    ///< around what concentrates stress: smaller by half, the closer the more often
  estimated,  ///< repeatedly those that half of the estimated error comes from
  for_time,   ///< the same, those of little depth first: Saved::time
  surface     ///< two layers at the surface, of cells half as large: the thesis, 5.3 (3)
};
const std::string& to_string(Map map);

/// What is wanted of a problem.
enum class Quantity {
  displacement,  ///< static, small: the mean under the only load, or over another part of the surface [m]
  frequency,     ///< of the slowest vibration [Hz]
  impact         ///< the way of the centre of mass from a plane's first touch to where it turns back [m]
};

/// One quantity of a body in cells of some size, or of several.
struct MapProblem {
  std::string name{};
  std::string description{};
  Quantity quantity = Quantity::displacement;
  Problem shape{};                                ///< without loads; its goal is not used
  Box patch{};                                    ///< loaded: flat along one axis, on the surface [m]
  Vec3 direction = Vec3::UnitZ();                 ///< of the load or of the fall, of length 1
  std::optional<Box> looked_at{};                 ///< flat, on the surface; none: the patch [m]
  Vec3 looked_along = Vec3::UnitZ();              ///< direction of the displacement there
  double speed = 0;                               ///< of the fall [m/s]
  std::function<double(const Vec3&)> distance{};  ///< from what concentrates stress [m]
  int multiple = 1;                               ///< of which all cells a metre are
  int coarsest = 2;                               ///< cells a metre that refinement begins with
  int finest = 32;                                ///< and those of the reference
  std::size_t most_particles = 300000;            ///< that the quantity is found for in time
  /// Cells a metre and levels of maps chosen by hand.
  std::vector<std::pair<int, int>> by_hand{};
};
std::vector<MapProblem> map_problems();

/// What of `mss refine` is about bodies with cells of several sizes. References are extrapolated from three
/// sizes of cells of which the last is the problem's finest.
struct MapConfig {
  std::vector<MapProblem> problems{};
  std::vector<int> uniform_cells{};  ///< a metre
  int reference_coarsening = 1;      ///< of the problems' references
  std::size_t most_uniform = 0;      ///< particles of bodies with cells of one size,
  std::size_t most_particles = 0;    ///< and of several
  double face_share = 0.5;
  ElasticConstants material{.young = 1e5, .poisson = 0.3};
  double sample_seconds = 0.05;  ///< of steps that are timed
};
MapConfig map_config(const ExperimentOptions& options);

struct MapTables {
  Table rows;   ///< a problem in cells of one size or of several
  Table gains;  ///< uniform over refined, at equal errors
  Status status = Status::ok;
};
/// Of cells of one size over those of several, at equal errors: of particles, and of times.
Table gains_of(const Table& rows);

MapTables measure_maps(const MapConfig& config, Progress& progress);

/// Errors against particles, against the time of a static solution and of explicit steps.
std::vector<NamedChart> map_charts(const Table& rows);

/// Cells of a depth are split that are closer to what concentrates stress than two of them are long.
RefinementMap split_near(const BodyConfig& body, const std::function<double(const Vec3&)>& distance,
                         int levels);

/// Cells with a face that no other cell has are split: two layers of smaller ones.
RefinementMap split_surface(const BodyConfig& body);

}  // namespace mss::studies::refine
