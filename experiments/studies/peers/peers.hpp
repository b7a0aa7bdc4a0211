#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/field.hpp"
#include "core/scene/scene.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/peer/result.hpp"
#include "experiments/peer/score.hpp"

namespace mss::studies::peers {

/// What a scene asks of programs.
enum class Question {
  bending,  ///< of a cantilever: where its tip comes to rest, and the period of its swing
  hanging,  ///< of a bar: where its lower end comes to rest
  flight,   ///< of a spinning body: its spin, momentum and volume
  landing,  ///< of a body that is dropped on a plane: its volume, and how far it is behind the plane
  slope     ///< of a block: how far it slides in a second
};

/// A scene for every program, and what is known of it.
struct PeerScene {
  std::string name;
  Question question;
  Scene scene{};
  Box end{};                       ///< of particles whose mean displacement is measured
  int axis = 2;                    ///< along which
  double displacement = no_value;  ///< that is right: at rest, or on a slope at the end [m]
  double period = no_value;        ///< that is right [s]
  double drag = 0;                 ///< that brings it to rest [1/s]
  double rest_seconds = 0;         ///< after which it rests

  bool rests() const { return question == Question::bending || question == Question::hanging; }
  bool has_planes() const { return question == Question::landing || question == Question::slope; }
};

/// Scenes, with their files in a folder that must outlive them.
std::vector<PeerScene> peer_scenes(bool quick, const std::filesystem::path& folder);

/// Who computes: this program, or an adapter of reference/peers.
enum class Adapter { own, jolt, mujoco, bullet, calculix };

/// What a family is tried with.
struct Setting {
  int steps = 1;       ///< a frame of 1/60 s; 0: the safe step
  int iterations = 0;  ///< 0: the default
};

/// A program with its element or method.
struct Family {
  std::string name;
  Adapter adapter;
  std::vector<Setting> settings;
  std::vector<std::string>
      options{};  ///< of the adapter; of this program "integrator" and "nonlinear solver"
  bool in_webassembly = false;
  bool boxes_only = false;  ///< has cells of a box
  bool has_planes = true;
  bool has_modulus = true;  ///< false: no rest of a material to compare with
};
std::vector<Family> peer_families(bool quick);

/// Programs of reference/peers, asked once each whether they are here.
class Adapters {
 public:
  /// Its version; throws MissingProgram.
  const std::string& version(Adapter adapter);

 private:
  struct Answer {
    std::string version, missing;
  };
  std::map<Adapter, Answer> answers_;
};

/// In place of a result, with the sentence that its row shows: what is not installed, or not possible.
struct NoResult {
  std::string why;
};

/// What a program makes of an exported folder; `drag` [1/s] brings it to rest. Throws NoResult.
peer::Result run_adapter(Adapters& adapters, const Family& family, const Setting& setting,
                         const peer::Exchange& exchange, const std::filesystem::path& exported, double drag);

/// The same by this program.
peer::Result run_family_here(const Family& family, const Setting& setting, const peer::Exchange& exchange,
                             const Progress& progress);

/// Where this program's method with its steps and iterations comes to rest: after every step its velocities
/// are multiplied by exp(-drag dt). Throws NoResult where it does not.
State<double> rest_here(const Family& family, const Setting& setting, const peer::Exchange& exchange,
                        double drag);

/// The time between the first two passages of a motion downwards through a level, as its rest; NaN if there
/// are no two. So the first period of a motion that dies away is not shortened by that.
double period_of(const std::vector<double>& times, const std::vector<double>& values, double level);

/// Settings of `mss peers`.
struct PeersConfig {
  std::vector<Family> families;
  bool quick = false;
};

struct PeersTables {
  std::vector<NamedTable> tables;  ///< cantilevers, bars, flight, landing, slope
  Status status = Status::ok;
};

/// A row per scene, family and setting. Processor time is that of stepping, per frame of 1/60 s; of programs
/// in WebAssembly `native_low` and `native_high` are what it might be natively.
PeersTables measure_peers(const PeersConfig& config, Progress& progress);

/// What WebAssembly costs: measured of Bullet, the same scene natively and in WebAssembly with the same
/// positions to all printed digits: 1.15 at 100 iterations of links, 1.33 at 10, 1.5 to 2.2 at 1. An earlier
/// prototype measured it once; it is not kept.
inline constexpr double least_price_of_webassembly = 1.15, most_price_of_webassembly = 2.2;

/// Error of the tip against time, periods, volume and spin.
Drawings draw_peers(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::peers
