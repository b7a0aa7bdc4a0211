#pragma once

#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/fate.hpp"

namespace mss::studies::atlas {

/// The cube of 1 m and what is done to it.
struct AtlasBody {
  int cells = 3;        ///< per edge
  double ratio = 0.05;  ///< of damping to critical, of every spring
  double poisson = 0.3;
  double strain = 0.01;  ///< stretched by, along x; negative: compressed
  std::string name() const;
};

/// A direction in which the atlas is spread out; the other things are as in AtlasBody.
struct AtlasPlane {
  std::string name;            ///< of a column
  std::string label;           ///< of an axis
  std::vector<double> values;  ///< rows; between them, others where fates change
  int halvings = 0;            ///< of what lies between two rows, at most
  void (*set)(AtlasBody& body, double value) = nullptr;

  int levels() const { return (int(values.size()) - 1) << halvings; }
  double value(int level) const;  ///< level 0 to levels(); whole multiples of 2^halvings are `values`
};

/// Steps of the atlas are dt omega_max = 2^(octaves / octave_parts).
inline constexpr int octave_parts = 8;
struct AtlasConfig {
  std::vector<AtlasPlane> planes;
  std::vector<std::string> integrators;
  int finest = 1;      ///< of octave_parts: neighbours of different fate are not closer
  bool quick = false;  ///< shorter ranges
};
AtlasConfig atlas_config(const ExperimentOptions& options);

/// What the journal is asked: of a body, its spectrum and how fast it loses energy; of a method and a body,
/// its largest step; of these at a step, the fate.
struct AtlasQuestion {
  enum class Kind { body, limit, fate };
  Kind kind = Kind::fate;
  AtlasBody body;
  std::string integrator = {};
  int step = 0;  ///< of dt omega_max, in parts of an octave
  std::string name() const;
};

/// Answers one; the journal must know those before it.
Json answer(const AtlasQuestion& question, const Journal& journal);

struct AtlasTables {
  Table points;  ///< every run
  Table limits;  ///< per row: omega_max, largest step that holds and what comes behind it
  Status status = Status::ok;
};
AtlasTables measure_atlas(const AtlasConfig& config, int processes, Journal& journal, Progress& progress);

}  // namespace mss::studies::atlas
