#pragma once

#include <optional>

#include "core/body/spectral_bound.hpp"
#include "core/system/system_wrapper.hpp"

namespace mss {

/// The user's pull at one particle: a spring and a damper from it to a point in space,
///   f = k (anchor - x) - c v.
/// Its energy is not the body's: what it adds to the total is work done from outside.
struct Tether {
  std::ptrdiff_t site = 0;
  Vec3 anchor = Vec3::Zero();  ///< [m]
  double stiffness = 0;        ///< k [N/m]
  double damping = 0;          ///< c [kg/s]

  Vec3 force(const Vec3& x, const Vec3& v) const { return stiffness * (anchor - x) - damping * v; }  ///< [N]
};

/// A tether soft enough for a step chosen with dt = "safe". With w the bound on frequencies and m the
/// particle's mass it has k = 0.05 m w^2 and c = 0.2 sqrt(k m), which raise w^2 dt^2 + 2 c dt of the stiffest
/// mode from at most 3.6 of the 4 allowed by no more than 0.33: 3.24 * 0.05 of stiffness and 2 * 0.0447 * 1.8
/// of damping.
Tether stable_tether(double mass, const SpectralBound& bound, std::ptrdiff_t site);

/// Another system, with a tether on one of its particles while there is one. Without, it costs nothing.
template <class Real>
class TetheredSystem final : public SystemWrapper<Real> {
 public:
  /// The other system must outlive this one.
  explicit TetheredSystem(System<Real>& other)
      : SystemWrapper<Real>(other), tangents_(*this), events_(*this) {}

  /// Ties, moves or releases. Integrators that keep a history must be reset when that happens, and what
  /// sleeps in the other system woken; nothing falls asleep while a particle is tied.
  void tie(const std::optional<Tether>& tether) { tether_ = tether; }
  const std::optional<Tether>& tether() const { return tether_; }
  const System<Real>& untied() const { return this->other(); }

  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;
  Tangents<Real>* tangents() override { return this->other().tangents() ? &tangents_ : nullptr; }
  StepEvents<Real>* events() override { return this->other().events() ? &events_ : nullptr; }

 private:
  class TetheredTangents final : public Tangents<Real> {
   public:
    explicit TetheredTangents(TetheredSystem& system) : system_(system) {}
    const std::vector<FreeDof>& unknowns() override { return other().unknowns(); }
    SparseMatrix pattern() override { return other().pattern(); }
    bool has_fixed_pattern() const override { return other().has_fixed_pattern(); }
    void values(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                SparseMatrix& matrix) override;
    void product(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                 const Field<Real>& p, Field<Real>& out) override;
    void diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                  std::vector<Eigen::Matrix3d>& blocks) override;

   private:
    Tangents<Real>& other() const { return *system_.other().tangents(); }
    /// What the tether adds to the diagonal.
    double added(const TangentCoefficients& sum) const {
      return sum.stiffness * system_.tether_->stiffness + sum.damping * system_.tether_->damping;
    }
    TetheredSystem& system_;
  };

  class TetheredEvents final : public StepEvents<Real> {
   public:
    explicit TetheredEvents(TetheredSystem& system) : system_(system) {}
    bool collides() const override { return other().collides(); }
    double fall_step() const override { return other().fall_step(); }
    bool presses() const override { return other().presses(); }
    double resolved_step() const override { return other().resolved_step(); }
    bool collide(const State<Real>& before, double dt, State<Real>& state) override {
      return other().collide(before, dt, state);
    }
    bool sleeps() const override { return other().sleeps(); }
    bool settle(State<Real>& state) override { return !system_.tether_ && other().settle(state); }
    bool all_asleep() const override { return other().all_asleep(); }
    std::vector<double> event_functions(double t, const Field<Real>& x) const override {
      return other().event_functions(t, x);
    }

   private:
    StepEvents<Real>& other() const { return *system_.other().events(); }
    TetheredSystem& system_;
  };

  std::optional<Tether> tether_;
  TetheredTangents tangents_;
  TetheredEvents events_;
  Field<Real> force_;  ///< of the other system, where the tied particle may stick to a plane
};

}  // namespace mss
