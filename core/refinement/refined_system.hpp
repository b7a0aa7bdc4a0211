#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/environment/plane_contact.hpp"
#include "core/refinement/hanging_transfer.hpp"
#include "core/refinement/refined_body.hpp"
#include "core/springs/solid_system.hpp"
#include "core/springs/spring_system.hpp"

namespace mss {

struct LocalStepPlan;
template <class Real>
class LocalSteps;

/// Throws InputError if a hanging particle is held and not all of its masters are: it would not be where the
/// hold has it.
void check_holds(const RefinedBody& body, const HeldSites& held);

/// A body of springs with cells of several sizes in its environment: of each level a SpringSystem, whose
/// sweep adds up its forces, and between them what RefinedBody says of hanging particles. These have the
/// motion of their masters; what fields say of them is not read. Planes act on particles that move: no other
/// can be behind a plane.
template <class Real>
class RefinedSystem final : public SolidSystem<Real> {
 public:
  /// The body must outlive the system. Throws InputError for a hold of a hanging particle without its
  /// masters, and for what acts on a mesh's surface.
  RefinedSystem(const RefinedBody& body, const Environment& environment, const Execution& execution = {});

  const RefinedBody& body() const { return body_; }

  std::ptrdiff_t size() const override { return body_.size(); }
  const std::vector<std::ptrdiff_t>& particles() const override { return body_.sites(); }
  double mass(std::ptrdiff_t site) const override { return body_.mass(site); }
  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override;
  void clear_prescribed(Field<Real>& field) const override;
  Tangents<Real>* tangents() override { return &tangents_; }
  StepEvents<Real>* events() override { return &events_; }
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;
  /// By the threads of the level with most particles.
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override;
  double threads_working() const override;
  const PlaneBounds* bounds() const override { return bounds_of_planes_.get(); }
  PlaneImpulses* plane_impulses() const override { return impulses_.get(); }

  const std::vector<Level>& levels() const override { return body_.levels(); }
  const RefinedBody* refined_body() const override { return &body_; }
  Vec3 gravity() const override { return of_level_.gravity; }
  StoredEnergy stored_energy(const Field<Real>& x) const override;
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<Real>& x,
                                                           const Field<Real>& v) const override;
  double outer_potential(double t, const Field<Real>& x) const override;
  void add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const override;
  SpectralBound spectral_bound() const override { return bound_; }
  SpectralBound local_bound() const override;
  std::unique_ptr<System<Real>> with_local_steps(double dt) override;
  LocalStepPlan local_step_plan() const;
  int threads() const override;
  const char* kernel_name() const override;
  void remember(Record& record) override;
  /// The sweep of its levels.
  const SweepKernel<Real>& kernel() const;

 private:
  SpringSystem<Real>& most_threaded() const;
  friend class LocalSteps<Real>;
  class Events final : public StepEvents<Real> {
   public:
    explicit Events(RefinedSystem& system) : system_(system) {}
    bool collides() const override { return system_.contact_.has_collisions(); }
    double fall_step() const override { return system_.contact_.fall_step(); }
    bool presses() const override { return system_.contact_.has_penalties(); }
    double resolved_step() const override { return system_.contact_.resolved_step(); }
    bool collide(const State<Real>& before, double dt, State<Real>& state) override;
    bool sleeps() const override { return false; }
    bool settle(State<Real>&) override { return false; }
    bool all_asleep() const override { return false; }
    std::vector<double> event_functions(double t, const Field<Real>& x) const override {
      return system_.contact_.smallest_gaps(system_.particles(), x, t);
    }

   private:
    RefinedSystem& system_;
  };

  /// A level's system and its part of the fields.
  struct LevelState {
    LevelState(const Body& body, const Environment& environment, const Execution& execution)
        : system(body, environment, execution),
          state{0, Field<Real>(body.lattice().size), Field<Real>(body.lattice().size)},
          a(body.lattice().size) {}

    SpringSystem<Real> system;
    State<Real> state;
    Field<Real> a;  ///< accelerations or forces
    Field<Real> p;  ///< directions of a product; without a size until there is one
  };
  /// T^T A T of the levels' tangents A, and the masses.
  class RefinedTangents final : public Tangents<Real> {
   public:
    explicit RefinedTangents(RefinedSystem& system) : system_(system) {}
    const std::vector<FreeDof>& unknowns() override;
    SparseMatrix pattern() override;
    void values(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                SparseMatrix& matrix) override;
    void product(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                 const Field<Real>& p, Field<Real>& out) override;
    void diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                  std::vector<Eigen::Matrix3d>& blocks) override;

   private:
    /// A number of a level's matrix that is part of one of the whole's.
    struct Share {
      int source, target;
      double weight;
    };
    struct LevelMatrix {
      SparseMatrix matrix;
      std::vector<Share> shares;
    };
    using Weights = std::vector<std::pair<int, double>>;  ///< by unknown

    std::vector<Weights> expand(std::size_t level) const;
    void build();
    void add_hanging(std::size_t level, const TangentCoefficients& sum,
                     std::vector<Eigen::Matrix3d>& blocks) const;

    RefinedSystem& system_;
    std::vector<FreeDof> unknowns_;
    std::vector<LevelMatrix> levels_;  ///< built at the first use: they are large
    SparseMatrix pattern_;
  };

  struct Loaded {
    std::size_t level;
    std::ptrdiff_t site;
    Vec3 force, acceleration;
  };

  void find_loads(const std::vector<Load>& loads);
  void load_state(const Field<Real>& x, const Field<Real>& v);
  void place_hanging();
  void accelerate(double t);
  void step_levels(const KickDrift& update, double dt, long steps, State<Real>& state,
                   const std::function<void(double)>& accelerate);
  void stop_sticking(double t);
  /// Of what is held or rests on a plane.
  void finish_accelerations(double t);
  void store_accelerations(Field<Real>& a);
  /// Calls visit(system, positions) with what is each level's of positions x.
  template <class Visit>
  void for_each_level(const Field<Real>& x, Visit&& visit) const;

  const RefinedBody& body_;
  Environment of_level_;  ///< what acts on a level alone
  int requested_threads_;
  HangingTransfer<Real> transfer_;
  HeldSites held_;
  PlaneContact contact_;
  std::unique_ptr<PlaneBounds> bounds_of_planes_;
  std::unique_ptr<PlaneImpulses> impulses_;  ///< nullptr: no plane acts by impulses
  SpectralBound bound_;
  bool forces_take_velocities_ = false;
  std::vector<std::unique_ptr<LevelState>> levels_;
  std::vector<Loaded> loaded_;  ///< particles that move
  RefinedTangents tangents_;
  Events events_;
};

/// Of a body that may have cells of several sizes; where all have one, without what refinement needs, which
/// more solvers take. The body must outlive it.
template <class Real>
std::unique_ptr<SolidSystem<Real>> make_solid_system(const RefinedBody& body, const Environment& environment,
                                                     const Execution& execution) {
  if (body.levels().size() == 1)
    return std::make_unique<SpringSystem<Real>>(body.levels().front().body, environment, execution);
  return std::make_unique<RefinedSystem<Real>>(body, environment, execution);
}

}  // namespace mss
