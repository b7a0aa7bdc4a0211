#pragma once

#include <optional>

#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "integrators/reduction/reduced_system.hpp"

namespace mss {

/// How far a reduced body has been from the lattice that it stands for.
struct ReducedFit {
  double lost = 0;        ///< share of the start, or of what a strike gives, that is none of its shapes
  double excess = 0;      ///< largest energy of the lattice in the body's shape above that of the
                          ///< coordinates, over the largest of these
  double deflection = 0;  ///< of a held body: largest displacement over its longest side
  double twist = 0;       ///< largest rotation of a particle's neighbourhood about that side [rad]
  bool touched = false;   ///< a plane has pushed it

  void remember(Record& record) { record.keep(lost, excess, deflection, twist, touched); }
};

/// Watches a run of a reduced body at its rows, between which it sees nothing; of other bodies neither.
template <class Real>
class ReducedWatch {
 public:
  /// The run must outlive it.
  explicit ReducedWatch(SceneRun<Real>& run);

  void add(const Measures& row, const Reactions& reactions);
  std::optional<ReducedFit> found() const { return system_ ? std::optional<ReducedFit>(fit_) : std::nullopt; }
  void remember(Record& record) { record.keep(fit_, most_energy_, most_excess_); }

 private:
  double displacement() const;
  double twist() const;

  SceneRun<Real>& run_;
  ReducedSystem* system_ = nullptr;
  ReducedFit fit_;
  double most_energy_ = 0, most_excess_ = 0;  ///< [J]
};

/// Sentences about where a reduced body has left what its model is good for; `mss reduce` has the errors
/// beyond.
std::vector<std::string> warnings_of(const Scene& scene, const ReducedFit& fit);

}  // namespace mss
