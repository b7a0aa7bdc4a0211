#pragma once

#include <memory>

#include "core/block_matrix.hpp"
#include "core/body.hpp"
#include "core/environment.hpp"
#include "core/spectral_bound.hpp"
#include "core/system.hpp"
#include "core/team.hpp"

namespace mss {

/// Energy stored in a deformed body [J].
struct StoredEnergy {
  double elastic = 0;  ///< of springs, or of finite elements
  double volume = 0;   ///< eq. 3-1 summed over cells
};

/// A body in its environment, whatever fills its cells: springs (SpringSystem), finite elements (FemSystem).
template <class Real>
class BodySystem : public System<Real> {
 public:
  /// The body must outlive the system. `threads` compute forces.
  BodySystem(const Body& body, const Environment& environment, int threads);

  const Body& body() const { return body_; }
  const Environment& environment() const { return environment_; }
  const LoadedSites& loads() const { return loads_; }

  /// The body as it is while nothing acts on it: its holds have not moved anything.
  State<Real> undeformed_state() const;
  /// The same at t = 0, where holds put it.
  State<Real> rest_state() const;

  /// Energy stored at positions x; NaN or infinite where x is.
  virtual StoredEnergy stored_energy(const Field<Real>& x) const = 0;

  /// Upper bounds on the frequency and damping of every mode about the rest state.
  virtual SpectralBound spectral_bound() const = 0;

  /// Threads that forces are computed with.
  int threads() const { return team_.size(); }
  /// What computes them, as an instruction set.
  virtual const char* kernel_name() const = 0;

  std::ptrdiff_t size() const override { return body_.lattice().size; }
  const std::vector<std::ptrdiff_t>& particles() const override { return body_.sites(); }
  double mass(std::ptrdiff_t site) const override { return body_.mass(site); }
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override;
  void clear_prescribed(Field<Real>& field) const override { held_.clear(field); }
  const std::vector<Unknown>& unknowns() override { return blocks().unknowns(); }
  SparseMatrix tangent_pattern() override { return blocks().pattern(); }
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override {
    team_.for_each(count, task);
  }

 protected:
  const HeldSites& held() const { return held_; }
  Team& team() { return team_; }
  /// Made by the first method that needs a matrix.
  BlockMatrix& blocks();
  void add_gravity(Field<Real>& f) const;

 private:
  const Body& body_;
  Environment environment_;
  HeldSites held_;
  LoadedSites loads_;
  Team team_;
  std::unique_ptr<BlockMatrix> blocks_;
};

}  // namespace mss
