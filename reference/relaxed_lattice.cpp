#include "reference/relaxed_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "reference/algorithm1.hpp"

namespace mss::reference {

namespace {

using Eigen::Matrix3d;

/// FIRE (Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201): motion that is turned along the forces while it
/// goes down, and stopped where it goes up.
class Relaxation {
 public:
  Relaxation(Algorithm1& lattice, std::vector<std::size_t> free, double longest_step)
      : lattice_(lattice), free_(std::move(free)), longest_step_(longest_step), dt_(longest_step / 5) {}

  /// Whether the largest force falls to `small` within the steps.
  bool run(double small, int steps) {
    for (int i = 0; i < steps; ++i) {
      lattice_.compute_forces();
      double largest = 0;
      for (const std::size_t p : free_) largest = std::max(largest, particle(p).f.norm());
      if (largest < small) return true;
      turn();
      for (const std::size_t p : free_) {
        particle(p).v += dt_ / particle(p).mass * particle(p).f;
        particle(p).x += dt_ * particle(p).v;
      }
    }
    return false;
  }

 private:
  Algorithm1::Particle& particle(std::size_t p) { return lattice_.particles()[p]; }

  void turn() {
    double power = 0, speed = 0, force = 0;
    for (const std::size_t p : free_) {
      power += particle(p).f.dot(particle(p).v);
      speed += particle(p).v.squaredNorm();
      force += particle(p).f.squaredNorm();
    }
    if (power <= 0) {
      for (const std::size_t p : free_) particle(p).v.setZero();
      dt_ /= 2;
      mixing_ = first_mixing;
      downhill_ = 0;
      return;
    }
    const double along = mixing_ * std::sqrt(speed / force);
    for (const std::size_t p : free_) particle(p).v = (1 - mixing_) * particle(p).v + along * particle(p).f;
    if (++downhill_ <= 5) return;
    dt_ = std::min(1.1 * dt_, longest_step_);
    mixing_ *= 0.99;
  }

  static constexpr double first_mixing = 0.1;
  Algorithm1& lattice_;
  std::vector<std::size_t> free_;
  double longest_step_, dt_, mixing_ = first_mixing;
  int downhill_ = 0;
};

}  // namespace

RelaxedLattice relax_lattice(const SpringConstants& springs, double cell_size, int cells, const Matrix3d& F,
                             double disturbance) {
  constexpr double density = 1000;
  const double edge = cells * cell_size;
  Algorithm1 lattice({.voxels = VoxelGrid::box(cells, cells, cells),
                      .cell_size = cell_size,
                      .density = density,
                      .springs = springs},
                     Vec3::Zero(), 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-disturbance * cell_size, disturbance * cell_size);
  std::vector<std::size_t> free;
  std::vector<Vec3> by_gradient;
  for (std::size_t p = 0; p < lattice.particles().size(); ++p) {
    Vec3& x = lattice.particles()[p].x;
    const bool is_inside = x.minCoeff() > cell_size / 2 && x.maxCoeff() < edge - cell_size / 2;
    x = F * x;
    by_gradient.push_back(x);
    if (!is_inside) continue;
    x += Vec3(uniform(random), uniform(random), uniform(random));
    free.push_back(p);
  }
  const double stiffness =
      springs.edge + 2 * springs.face + springs.body + std::abs(springs.volume) * cell_size;
  const double mass = density * cell_size * cell_size * cell_size;
  RelaxedLattice relaxed;
  Relaxation relaxation(lattice, free, 0.3 * std::sqrt(mass / stiffness));
  relaxed.at_rest = relaxation.run(1e-11 * stiffness * cell_size, 20000);
  relaxed.energy = lattice.potential_energy() / (edge * edge * edge);
  for (const std::size_t p : free)
    relaxed.moved = std::max(relaxed.moved, (lattice.particles()[p].x - by_gradient[p]).norm() / cell_size);
  return relaxed;
}

Matrix3d relaxed_stress(const SpringConstants& springs, double cell_size, int cells, const Matrix3d& F,
                        double disturbance) {
  constexpr double step = 1e-4;
  const auto energy = [&](const Matrix3d& at) {
    return relax_lattice(springs, cell_size, cells, at, disturbance).energy;
  };
  Matrix3d stress;
  for (int entry = 0; entry < 9; ++entry) {
    const auto moved = [&](double by) {
      Matrix3d at = F;
      at.data()[entry] += by * step;
      return energy(at);
    };
    // Of fourth order.
    stress.data()[entry] = (8 * (moved(1) - moved(-1)) - (moved(2) - moved(-2))) / (12 * step);
  }
  return stress;
}

}  // namespace mss::reference
