#pragma once

#include <memory>

#include "core/block_matrix.hpp"
#include "core/body.hpp"
#include "core/contact.hpp"
#include "core/environment.hpp"
#include "core/sleepers.hpp"
#include "core/spectral_bound.hpp"
#include "core/system.hpp"
#include "core/team.hpp"

namespace mss {

/// Energy stored in a deformed body [J].
struct StoredEnergy {
  double elastic = 0;  ///< of springs and the guard against folding, or of finite elements
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

  /// Upper bounds on the frequency and damping of every mode about the rest state, of the body alone.
  virtual SpectralBound body_bound() const = 0;
  /// The same where it may touch the environment's planes.
  SpectralBound spectral_bound() const;

  /// Potential of gravity, from z = 0, of loads and of penalty planes at positions x [J].
  double outer_potential(const Field<Real>& x) const;

  /// Threads that forces are computed with.
  int threads() const { return team_.size(); }
  /// What computes them, as an instruction set.
  virtual const char* kernel_name() const = 0;

  std::ptrdiff_t size() const override { return body_.lattice().size; }
  const std::vector<std::ptrdiff_t>& particles() const override { return body_.sites(); }
  double mass(std::ptrdiff_t site) const override { return body_.mass(site); }
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override;
  void clear_prescribed(Field<Real>& field) const override { held_.clear(field); }
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  bool collides() const override { return !colliding_.empty(); }
  bool collide(const State<Real>& before, double dt, State<Real>& state) override;
  bool sleeps() const override { return sleepers_ != nullptr; }
  bool settle(State<Real>& state) override;
  bool all_asleep() const override { return sleepers_ && sleepers_->all_asleep(); }
  /// Of the body's planes, those that sleep.
  double share_asleep() const { return sleepers_ ? sleepers_->share_asleep() : 0; }
  /// Call it after changing velocities.
  void wake_moving(const State<Real>& state);
  /// Call it after changing positions, or what acts on the body.
  void wake_all();
  /// Of every penalty plane, the smallest gap of a particle.
  std::vector<double> kinks(const Field<Real>& x) const override;
  const std::vector<Unknown>& unknowns() override { return blocks().unknowns(); }
  SparseMatrix tangent_pattern() override { return blocks().pattern(); }
  void tangent(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
               SparseMatrix& matrix) final;
  void tangent_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                        std::vector<Eigen::Matrix3d>& blocks) final;
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override {
    team_.for_each(count, task);
  }

 protected:
  const HeldSites& held() const { return held_; }
  /// For systems whose accelerations of planes asleep are zero. Nothing sleeps where the bound is 0.
  void let_sleep(const SleepRule& rule);
  /// nullptr where nothing sleeps.
  const Sleepers<Real>* sleepers() const { return sleepers_.get(); }
  Team& team() { return team_; }
  /// Made by the first method that needs a matrix.
  BlockMatrix& blocks();
  void add_gravity(Field<Real>& f) const;

  /// Whether there are penalty planes. Without, what follows adds nothing and costs nothing.
  bool has_penalties() const { return !penalties().empty(); }
  void add_penalty_force(const Field<Real>& x, const Field<Real>& v, Field<Real>& f);
  void add_penalty_acceleration(const Field<Real>& x, const Field<Real>& v, Field<Real>& a);
  /// Stops what sticks to planes of the law `impulse`. Without it, methods that evaluate forces within a step
  /// would see the body sink for half of it, and its neighbours would never come to rest.
  void stop_sticking(const Field<Real>& x, const Field<Real>& v, Field<Real>& a);
  void add_penalty_product(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                           const Field<Real>& p, Field<Real>& out);

  /// Adds the tangent of what fills the body, without its masses.
  virtual void add_tangent(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                           BlockMatrix& blocks) const = 0;
  /// Adds its blocks on the diagonal, one per particle.
  virtual void add_tangent_diagonal(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                    const BlockMatrix& blocks,
                                    std::vector<Eigen::Matrix3d>& diagonal) const = 0;

 private:
  /// Made by the first who asks: only a complete system knows its body_bound(). Ask before threads do.
  const std::vector<Penalty>& penalties() const;
  template <class Task>
  void for_each_particle(Task&& task);
  template <class Task>
  void for_each_particle_awake(Task&& task);
  bool collide_particle(std::ptrdiff_t site, const State<Real>& before, double dt, State<Real>& state) const;
  /// Sums over penalty planes, of forces over mass and of tangents.
  Vec3 penalty_at(std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v) const;
  Eigen::Matrix3d penalty_tangent_at(std::ptrdiff_t site, const Field<Real>& x, const Field<Real>& v,
                                     const TangentSum& sum) const;

  const Body& body_;
  Environment environment_;
  HeldSites held_;
  LoadedSites loads_;
  std::vector<Plane> colliding_;  ///< those that act at the end of steps
  mutable std::vector<Penalty> penalties_;
  Team team_;
  std::unique_ptr<Sleepers<Real>> sleepers_;
  std::unique_ptr<BlockMatrix> blocks_;
};

}  // namespace mss
