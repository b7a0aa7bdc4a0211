#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/refined_body.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/studies/refine/problems.hpp"

namespace mss::studies::refine {

/// How it is decided which cells of a body are smaller.
enum class Map {
  uniform,    ///< none
  by_hand,    ///< around what concentrates stress: smaller by half, the closer the more often
  estimated,  ///< repeatedly those that half of the estimated error comes from
  surface     ///< two layers at the surface, of cells half as large: the thesis, 5.3 (3)
};
const std::string& to_string(Map map);

/// A static problem of small deformations with one load, evenly spread over a flat box. What is wanted is the
/// displacement under the load, the mean that the load's work goes with.
struct LoadProblem {
  std::string name;
  std::string description;
  Problem shape;                                  ///< without loads; its goal is not used
  Box patch{};                                    ///< flat along one axis, on the body's surface [m]
  Vec3 direction;                                 ///< of the load, of length 1
  std::function<double(const Vec3&)> distance{};  ///< from what concentrates stress [m]
  int coarsest = 2;                               ///< cells a metre that refinement begins with
  int finest = 32;                                ///< and those of the reference
  /// Cells a metre and levels of maps chosen by hand.
  std::vector<std::pair<int, int>> by_hand{};
};
std::vector<LoadProblem> load_problems();

/// References are extrapolated from three sizes of cells of which the last is the problem's finest.
/// What of `mss refine` is about bodies with cells of several sizes.
struct MapConfig {
  std::vector<LoadProblem> problems{};
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
MapTables measure_maps(const MapConfig& config, Progress& progress);

/// Errors against particles, against the time of a static solution and of explicit steps.
std::vector<NamedChart> map_charts(const Table& rows);

/// A force of size 1 along a direction, spread evenly over a flat box on the surface of a body whose
/// lattices are given: what each corner of a cell's face gets is the integral of its bilinear weight over
/// what the box covers of the face. Throws InputError if the box covers no face.
Field<double> traction(const std::vector<Level>& levels, const Box& patch, const Vec3& direction);

}  // namespace mss::studies::refine
