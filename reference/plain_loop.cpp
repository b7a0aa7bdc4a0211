#include "reference/plain_loop.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <cmath>

namespace mss::reference {

template <class Real>
PlainLoop<Real>::PlainLoop(const Algorithm1& model, int threads)
    : threads_(threads),
      gravity_(model.gravity().cast<Real>()),
      has_volume_force_(model.has_volume_force()),
      cell_volume_(Real(model.cell_volume())),
      cells_(model.cells()) {
  for (const auto& p : model.particles()) {
    x_.push_back(p.x.cast<Real>());
    v_.push_back(p.v.cast<Real>());
    mass_.push_back(Real(p.mass));
  }
  f_.assign(std::size_t(threads), std::vector<Vector>(x_.size()));
  for (const auto& s : model.springs())
    springs_.push_back(
        {std::uint32_t(s.p1), std::uint32_t(s.p2), Real(s.stiffness), Real(s.rest_length), Real(s.damping)});
}

template <class Real>
void PlainLoop<Real>::step(double dt) {
  if (threads_ == 1) {
    add_forces(0, 1);
    move_particles(Real(dt), 0, 1);
    return;
  }
#pragma omp parallel num_threads(threads_)
  {
    const auto rank = std::size_t(omp_get_thread_num()), ranks = std::size_t(omp_get_num_threads());
    add_forces(rank, ranks);
#pragma omp barrier
    move_particles(Real(dt), rank, ranks);
  }
}

template <class Real>
void PlainLoop<Real>::add_forces(std::size_t rank, std::size_t ranks) {
  std::vector<Vector>& f = f_[rank];
  for (Vector& force : f) force.setZero();
  for (std::size_t i = springs_.size() * rank / ranks; i < springs_.size() * (rank + 1) / ranks; ++i) {
    const Spring& s = springs_[i];
    const Vector d = x_[s.b] - x_[s.a];
    const Real inverse = 1 / std::sqrt(d.squaredNorm());
    const Real damping = s.damping * inverse * d.dot(v_[s.b] - v_[s.a]);
    const Vector force = (s.stiffness + inverse * (damping - s.stiffness * s.rest_length)) * d;
    f[s.a] += force;
    f[s.b] -= force;
  }
  if (!has_volume_force_) return;
  for (std::size_t i = cells_.size() * rank / ranks; i < cells_.size() * (rank + 1) / ranks; ++i)
    add_volume_force(cells_[i], f);
}

template <class Real>
void PlainLoop<Real>::add_volume_force(const Algorithm1::Cell& cell, std::vector<Vector>& f) const {
  const auto p = [&](int i) -> const Vector& { return x_[cell.p[std::size_t(i - 1)]]; };
  const Vector a = p(8) - p(1), b = p(7) - p(2), c = p(6) - p(3), d = p(5) - p(4);
  constexpr Real quarter = Real(0.25);
  const Vector x = quarter * (a - b - c + d), y = quarter * (a + b - c - d), z = quarter * (a + b + c + d);
  const Vector yz = y.cross(z), zx = z.cross(x), xy = x.cross(y);
  const Real g = -Real(cell.volume_stiffness) * (x.dot(yz) - cell_volume_) / (4 * cell_volume_);
  const auto push = [&](int upper, int lower, const Vector& force) {
    f[cell.p[std::size_t(upper - 1)]] += force;
    f[cell.p[std::size_t(lower - 1)]] -= force;
  };
  push(8, 1, g * (yz + zx + xy));
  push(7, 2, g * (-yz + zx + xy));
  push(6, 3, g * (-yz - zx + xy));
  push(5, 4, g * (yz - zx + xy));
}

template <class Real>
void PlainLoop<Real>::move_particles(Real dt, std::size_t rank, std::size_t ranks) {
  for (std::size_t i = x_.size() * rank / ranks; i < x_.size() * (rank + 1) / ranks; ++i) {
    Vector force = mass_[i] * gravity_ + f_[0][i];
    for (std::size_t r = 1; r < ranks; ++r) force += f_[r][i];
    v_[i] += dt / mass_[i] * force;
    x_[i] += dt * v_[i];
  }
}

template class PlainLoop<float>;
template class PlainLoop<double>;

}  // namespace mss::reference
