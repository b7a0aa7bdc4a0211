#pragma once

// What was measured: the format of data files stands in README.md beside this file.

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss::fit {

/// What an observation is of.
enum class Kind {
  at_end,     ///< "static": a value at the end of the run
  series,     ///< values in time
  frequency,  ///< of a ring-down, or of a mode [Hz]
  damping     ///< ratio of a ring-down
};
const std::string& to_string(Kind kind);

/// A scene that is run for some of the observations.
struct RunSpec {
  std::string name{};                                                          ///< the scene's
  std::function<Scene(const std::vector<std::string>& more_settings)> load{};  ///< throws InputError
  bool modes = false;    ///< its vibrations about rest are computed, and it is not run
  bool at_rest = false;  ///< it is an equilibrium
  double every = std::numeric_limits<double>::infinity();  ///< rows are at least so near to each other [s]
};

/// Measured numbers of one quantity of one run.
struct Observation {
  std::string place{};  ///< in the data file, for messages
  std::string name{};   ///< for tables
  Kind kind = Kind::at_end;
  std::size_t run = 0;          ///< of the problem's runs
  std::optional<Vec3> point{};  ///< the point of the body nearest to it at rest is observed [m],
  double apart = 0;             ///< which is so far away [m]
  std::string column{};         ///< x, y or z of its displacement, or a column of series.csv
  std::vector<double> times{};  ///< of a series [s], ascending
  std::vector<double> measured{};
  double uncertainty = 1;                                            ///< standard deviation of each
  double from = 0, until = std::numeric_limits<double>::infinity();  ///< window of a ring-down [s]
  int mode = 0;                                                      ///< from 1; 0: a ring-down
};

/// All that was measured, with the runs that it takes.
struct Observations {
  std::vector<RunSpec> runs{};
  std::vector<Observation> observations{};
};

/// Where observations take their scene from, if they do not name another.
struct SceneSource {
  std::string identity{};  ///< a path, or "" of a scene without a file
  std::function<Scene(const std::vector<std::string>& settings)> load{};
};

/// Reads a TOML file of [[observation]], or a CSV file of one series of `scene`. `settings` precede those of
/// observations. Throws InputError naming file, line and key.
Observations read_observations(const std::filesystem::path& file, const SceneSource& scene,
                               const std::vector<std::string>& settings);
/// The same of a TOML text, whose relative paths begin at the working directory.
Observations read_observations_text(const std::string& toml, const SceneSource& scene,
                                    const std::vector<std::string>& settings);

/// The scene source of a file.
SceneSource source_of(const std::filesystem::path& file);

/// Checks against the scenes, with the parameters' start values, that everything observed is there and can be
/// in the units of a scene: columns, points, times, sizes. Completes what follows from the scene. Throws
/// InputError.
void check_observations(Observations& data, const std::vector<std::string>& starts);

}  // namespace mss::fit
