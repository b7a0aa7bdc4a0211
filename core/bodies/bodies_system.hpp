#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/thread_team.hpp"
#include "core/bodies/contact_forces.hpp"
#include "core/environment/plane_bounds.hpp"
#include "core/environment/plane_contact.hpp"
#include "core/springs/body_system.hpp"
#include "core/springs/solid_system.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

template <class Real>
class BodiesTangents;

/// Threads of several bodies: of each, and of all together where each has one.
struct BodyThreads {
  int each = 1;
  int together = 1;
};
/// Where there are as many bodies as threads, each body is one thread's at a time; fewer share all threads,
/// one body after the other. `requested` 0: as many as pay.
BodyThreads threads_of(const std::vector<const Body*>& bodies, int requested);

/// What acts on one of several bodies alone: loads, strikes, and planes at the end of steps act on all.
/// `surface`: what planes touch of it; nullptr: its particles.
Environment environment_of_body(const Environment& environment, std::shared_ptr<const TriangleMesh> surface);

/// Several bodies in one environment, or one that may touch itself: of each body a system of its own, and
/// between them, and within them, contact (contact_forces.hpp). Fields have the bodies one after the other.
template <class Real>
class BodiesSystem final : public SolidSystem<Real> {
 public:
  using Bodies = std::vector<std::unique_ptr<BodySystem<Real>>>;
  /// A mesh for each body by which it touches others and itself; nullptr: the faces of its cells.
  using Surfaces = std::vector<std::shared_ptr<const TriangleMesh>>;

  /// Of at least one body, each made with its environment_of_body(). `threads` work for all together. Throws
  /// InputError where a sheet or a rope is to touch something, and for what acts on a mesh's surface.
  BodiesSystem(Bodies bodies, const Environment& environment, const Surfaces& surfaces, int threads);
  ~BodiesSystem() override;

  std::size_t body_count() const { return parts_.size(); }
  BodySystem<Real>& body(std::size_t index) { return *parts_[index]->system; }
  const BodySystem<Real>& body(std::size_t index) const { return *parts_[index]->system; }
  /// How bodies touch at a state; nothing where contact is not asked for.
  std::optional<ContactReport> contact_at(const State<Real>& state) const;
  /// The touches there.
  std::vector<ContactForces::Point> touches_at(const State<Real>& state) const;

  std::ptrdiff_t size() const override { return size_; }
  const std::vector<std::ptrdiff_t>& particles() const override { return sites_; }
  double mass(std::ptrdiff_t site) const override;
  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override { held_.apply(t, 0, size_, x, v); }
  void clear_prescribed(Field<Real>& field) const override { held_.clear(field); }
  Tangents<Real>* tangents() override;
  StepEvents<Real>* events() override { return &events_; }
  /// Of contact, and of materials that relax.
  StepMemory<Real>* memory() override { return remembers_ ? &memory_ : nullptr; }
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override;
  double threads_working() const override;
  const PlaneBounds* bounds() const override { return bounds_of_planes_.get(); }
  PlaneImpulses* plane_impulses() const override { return impulses_.get(); }

  const std::vector<Level>& levels() const override { return levels_; }
  Vec3 gravity() const override { return gravity_; }
  StoredEnergy stored_energy(const Field<Real>& x) const override;
  double dissipated_by_relaxation() const override;
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<Real>& x,
                                                           const Field<Real>& v) const override;
  /// That of contact is part of it.
  double outer_potential(double t, const Field<Real>& x) const override;
  void add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const override;
  SpectralBound spectral_bound() const override { return bound_; }
  int threads() const override;
  const char* kernel_name() const override { return parts_.front()->system->kernel_name(); }
  void wake_all() override;
  void remember(Record& record) override;

 private:
  friend class BodiesTangents<Real>;
  /// A body's system and its part of the fields.
  struct Part {
    explicit Part(std::unique_ptr<BodySystem<Real>> body_system);
    std::unique_ptr<BodySystem<Real>> system;
    State<Real> state;
    Field<Real> a;  ///< accelerations or forces
    Field<Real> p;  ///< directions of a product; without a size until there is one
  };
  class Events final : public StepEvents<Real> {
   public:
    explicit Events(BodiesSystem& system) : system_(system) {}
    bool collides() const override { return system_.contact_.has_collisions(); }
    double fall_step() const override { return system_.contact_.fall_step(); }
    bool presses() const override { return system_.contact_.has_penalties() || system_.forces_ != nullptr; }
    double resolved_step() const override { return system_.contact_.resolved_step(); }
    bool collide(const State<Real>& before, double dt, State<Real>& state) override;
    bool sleeps() const override { return false; }
    bool settle(State<Real>&) override { return false; }
    bool all_asleep() const override { return false; }
    std::vector<double> event_functions(double t, const Field<Real>& x) const override {
      return system_.contact_.smallest_gaps(system_.particles(), x, t);
    }

   private:
    BodiesSystem& system_;
  };
  class Memory final : public StepMemory<Real> {
   public:
    explicit Memory(BodiesSystem& system) : system_(system) {}
    void come_to(const State<Real>& state) override;
    void forget() override;
    bool limits_order() const override;
    bool matters() const override { return limits_order() || system_.forces_ != nullptr; }

   private:
    BodiesSystem& system_;
  };

  void check(const Environment& environment, const Surfaces& surfaces) const;
  void make_contact(const BodyContact& rules, const Surfaces& surfaces);
  void load_state(const Field<Real>& x, const Field<Real>& v);
  void load_positions(const Field<Real>& x) const;
  void accelerate(double t);
  void stop_sticking(double t);
  /// Calls visit(part, level) for each body, on all threads where each has one.
  template <class Visit>
  void for_each_part(Visit&& visit) const {
    const auto count = std::ptrdiff_t(parts_.size());
    const auto visit_one = [&](std::ptrdiff_t i) { visit(*parts_[std::size_t(i)], levels_[std::size_t(i)]); };
    if (count >= team_.size())
      team_.for_each(count, visit_one);
    else
      for (std::ptrdiff_t i = 0; i < count; ++i) visit_one(i);
  }
  std::vector<const Field<Real>*> positions() const;
  std::vector<Field<Real>*> accelerations() const;

  std::vector<std::unique_ptr<Part>> parts_;
  std::vector<Level> levels_;
  std::ptrdiff_t size_ = 0;
  std::vector<std::ptrdiff_t> sites_;
  Vec3 gravity_;
  HeldSites held_;
  LoadedSites loads_;
  SpectralBound of_bodies_;  ///< without planes and contact
  double cell_size_;         ///< the smallest [m]
  PlaneContact contact_;
  std::unique_ptr<PlaneBounds> bounds_of_planes_;
  std::unique_ptr<PlaneImpulses> impulses_;  ///< nullptr: no plane acts by impulses
  mutable ThreadTeam team_;
  std::unique_ptr<ContactForces> forces_;  ///< nullptr: nothing touches
  SpectralBound bound_;
  bool remembers_ = false;
  std::unique_ptr<BodiesTangents<Real>> tangents_;
  Events events_;
  Memory memory_;
};

}  // namespace mss
