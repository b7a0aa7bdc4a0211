#pragma once

#include <optional>

#include "core/body_system.hpp"

namespace mss {

/// A hand that pulls at one particle: a spring and a damper from it to a point in space,
///   f = k (anchor - x) - c v.
/// Its energy is not the body's: what it adds to the total is work done from outside.
struct Tether {
  std::ptrdiff_t site = 0;
  Vec3 anchor = Vec3::Zero();  ///< [m]
  double stiffness = 0;        ///< k [N/m]
  double damping = 0;          ///< c [kg/s]

  Vec3 force(const Vec3& x, const Vec3& v) const { return stiffness * (anchor - x) - damping * v; }  ///< [N]
};

/// A tether too weak to upset a step chosen with dt = "safe". With w the bound on frequencies and m the
/// particle's mass it has k = 0.05 m w^2 and c = 0.2 sqrt(k m), which raise w^2 dt^2 + 2 c dt of the stiffest
/// mode from at most 3.6 of the 4 allowed by no more than 0.33: 3.24 * 0.05 of stiffness and 2 * 0.0447 * 1.8
/// of damping.
Tether gentle_tether(const Body& body, const SpectralBound& bound, std::ptrdiff_t site);

/// Another system, with a tether on one of its particles while there is one. Without, it costs nothing.
template <class Real>
class TetheredSystem final : public System<Real> {
 public:
  /// The other system must outlive this one.
  explicit TetheredSystem(System<Real>& other) : other_(other) {}

  /// Ties, moves or lets go. Integrators that keep a history must be reset when that happens, and what sleeps
  /// in the other system woken; nothing falls asleep while it is tied.
  void tie(const std::optional<Tether>& tether) { tether_ = tether; }

  std::ptrdiff_t size() const override { return other_.size(); }
  const std::vector<std::ptrdiff_t>& particles() const override { return other_.particles(); }
  double mass(std::ptrdiff_t site) const override { return other_.mass(site); }
  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override { other_.constrain(t, x, v); }
  void clear_prescribed(Field<Real>& field) const override { other_.clear_prescribed(field); }
  bool collides() const override { return other_.collides(); }
  bool collide(const State<Real>& before, double dt, State<Real>& state) override {
    return other_.collide(before, dt, state);
  }
  bool sleeps() const override { return other_.sleeps(); }
  bool settle(State<Real>& state) override { return !tether_ && other_.settle(state); }
  bool all_asleep() const override { return other_.all_asleep(); }
  std::vector<double> kinks(const Field<Real>& x) const override { return other_.kinks(x); }
  const std::vector<Unknown>& unknowns() override { return other_.unknowns(); }
  SparseMatrix tangent_pattern() override { return other_.tangent_pattern(); }
  void tangent(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
               SparseMatrix& matrix) override;
  void tangent_product(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                       const Field<Real>& p, Field<Real>& out) override;
  void tangent_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                        std::vector<Eigen::Matrix3d>& blocks) override;
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override {
    other_.parallel(count, task);
  }
  void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const override {
    other_.apply(update, a, dt, state);
  }
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;

 private:
  /// What the tether adds to the diagonal of a tangent.
  double diagonal(const TangentSum& sum) const {
    return sum.stiffness * tether_->stiffness + sum.damping * tether_->damping;
  }

  System<Real>& other_;
  std::optional<Tether> tether_;
  Field<Real> force_;  ///< of the other system, where a plane may hold what is pulled
};

}  // namespace mss
