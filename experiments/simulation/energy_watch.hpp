#pragma once

#include <optional>

#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss {

/// Energy that nothing supplied.
struct EnergyGain {
  double t = 0;        ///< of the row where it was largest [s]
  double gained = 0;   ///< total energy above what the run began with and strikes added [J]
  double at_play = 0;  ///< until then, the largest sum of kinetic, stored and lost potential energy [J]

  void remember(Record& record) { record.keep(t, gained, at_play); }
};

/// Watches the energy balance of a run at its rows. Gravity, loads and penalty planes are in the potential,
/// strikes are counted, everything else can only take energy. What moving holds and obstacles do is not known
/// at rows: the balance begins where none moves, and where all of the body is in front of planes, which lift
/// what begins behind. Not watched: searches for equilibria, models without an energy
/// (`mollemans`), methods whose motion is that of no material (shape_matching).
template <class Real>
class EnergyWatch {
 public:
  explicit EnergyWatch(const Scene& scene);

  /// Takes the measures of the run's present state; `is_lifted`: planes still push out what began behind
  /// them. All ranks must call it.
  void add(SceneRun<Real>& run, const Measures& row, bool is_lifted);

  /// Of all rows the largest gain above what is tolerated; empty: there was none.
  const std::optional<EnergyGain>& gain() const { return gain_; }
  void remember(Record& record) { record.keep(start_, at_play_, gain_); }

 private:
  struct Start {
    double total, potential, struck, noise;

    void remember(Record& record) { record.keep(total, potential, struck, noise); }
  };
  bool is_driven(double t) const;
  double centred_total(SceneRun<Real>& run, const Measures& row) const;

  const Scene& scene_;
  const IntegratorInfo& method_;
  bool watches_;
  std::optional<Start> start_;
  double at_play_ = 0;
  std::optional<EnergyGain> gain_;
};

}  // namespace mss
