#pragma once

#include <string>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/outcome.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::atlas {

/// A cube of 1 m and how far it is stretched before it is released.
struct AtlasBody {
  int cells = 3;         ///< per edge
  double ratio = 0.05;   ///< damping ratio of every spring
  double viscosity = 0;  ///< in place of the ratio, unless 0 [Pa s]
  double poisson = 0.3;
  double strain = 0.01;  ///< initial, along x; negative: compressed
  std::string name() const;
};

/// A parameter that is mapped against the step; all others are as in AtlasBody.
struct AtlasParameter {
  std::string name;            ///< of its column
  std::string label;           ///< of its axis
  std::vector<double> values;  ///< rows of the map; further rows between them where the outcome changes
  int halvings = 0;            ///< of the interval between two values, at most
  void (*set)(AtlasBody& body, double value) = nullptr;

  int levels() const { return (int(values.size()) - 1) << halvings; }
  double value(int level) const;  ///< level 0 to levels(); whole multiples of 2^halvings are `values`
};

/// Steps of the atlas are dt omega_max = 2^(step / octave_parts), `step` an integer.
inline constexpr int octave_parts = 32;
double dt_omega(double step);

/// Whether energy without damping grows at every step by a part (dt w)^2, as with explicit Euler: then slow
/// motions may be those that grow, and damped bodies have much smaller steps than by other methods.
inline bool is_slowly_unstable(const IntegratorInfo& method) {
  return method.order_undamped == 1 && !method.symplectic && method.limit;
}

struct AtlasConfig {
  std::vector<AtlasParameter> parameters;
  std::vector<std::string> integrators;
  /// Least difference between two steps of different outcome, in parts of an octave: of methods with a
  /// largest stable step, and of others.
  int finest = 1, finest_without_limit = octave_parts / 4;
  bool quick = false;  ///< shorter ranges
};
AtlasConfig atlas_config(const ExperimentOptions& options);

/// Whether a method, with or without its number of iterations, has no steps but intervals to map.
bool chooses_its_steps(const std::string& family);

/// One computation: of a body, its spectrum and a reference of its energy; of a method and a body, the
/// predicted largest step; of a method, a body and a step, the outcome.
struct AtlasCase {
  enum class Kind { body, limit, outcome };
  Kind kind = Kind::outcome;
  AtlasBody body;
  std::string integrator = {};
  int step = 0;  ///< of dt omega_max, in parts of an octave
  std::string name() const;
};

/// Computes a case. The journal must have the result of its body, unless that is the case.
Json compute(const AtlasCase& atlas_case, const Journal& journal);

struct AtlasTables {
  Table points;      ///< per run
  Table limits;      ///< per row of a map: omega_max, largest stable step, next outcome, where energy grows
  Table parameters;  ///< every row that a map may have: its value and position on the map's axis
  Status status = Status::ok;
};
AtlasTables measure_atlas(const AtlasConfig& config, int processes, Journal& journal, Progress& progress);
/// The tables as they are written, by the names of their files.
std::vector<NamedTable> atlas_files(AtlasTables tables);

/// A map per parameter.
Drawings draw_atlas(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::atlas
