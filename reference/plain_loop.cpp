#include "reference/plain_loop.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace mss::reference {

PlainLoop::PlainLoop(const Algorithm1& model)
    : gravity_(model.gravity()),
      volume_stiffness_(model.volume_stiffness()),
      cell_volume_(model.cell_volume()),
      cells_(model.cells()) {
  for (const auto& p : model.particles()) {
    x_.push_back(p.x);
    v_.push_back(p.v);
    mass_.push_back(p.mass);
  }
  f_.resize(x_.size());
  for (const auto& s : model.springs())
    springs_.push_back({std::uint32_t(s.p1), std::uint32_t(s.p2), s.stiffness, s.rest_length, s.damping});
}

void PlainLoop::step(double dt) {
  for (std::size_t i = 0; i < x_.size(); ++i) f_[i] = mass_[i] * gravity_;
  for (const Spring& s : springs_) {
    const Vec3 d = x_[s.b] - x_[s.a];
    const double inverse = 1 / std::sqrt(d.squaredNorm());
    const double damping = s.damping * inverse * d.dot(v_[s.b] - v_[s.a]);
    const Vec3 f = (s.stiffness + inverse * (damping - s.stiffness * s.rest_length)) * d;
    f_[s.a] += f;
    f_[s.b] -= f;
  }
  if (volume_stiffness_ != 0) add_volume_forces();
  for (std::size_t i = 0; i < x_.size(); ++i) {
    v_[i] += dt / mass_[i] * f_[i];
    x_[i] += dt * v_[i];
  }
}

void PlainLoop::add_volume_forces() {
  for (const Algorithm1::Cell& cell : cells_) {
    const auto p = [&](int i) -> const Vec3& { return x_[cell.p[std::size_t(i - 1)]]; };
    const Vec3 a = p(8) - p(1), b = p(7) - p(2), c = p(6) - p(3), d = p(5) - p(4);
    const Vec3 x = 0.25 * (a - b - c + d), y = 0.25 * (a + b - c - d), z = 0.25 * (a + b + c + d);
    const Vec3 yz = y.cross(z), zx = z.cross(x), xy = x.cross(y);
    const double g = -volume_stiffness_ * (x.dot(yz) - cell_volume_) / (4 * cell_volume_);
    const auto push = [&](int upper, int lower, const Vec3& force) {
      f_[cell.p[std::size_t(upper - 1)]] += force;
      f_[cell.p[std::size_t(lower - 1)]] -= force;
    };
    push(8, 1, g * (yz + zx + xy));
    push(7, 2, g * (-yz + zx + xy));
    push(6, 3, g * (-yz - zx + xy));
    push(5, 4, g * (yz - zx + xy));
  }
}

}  // namespace mss::reference
