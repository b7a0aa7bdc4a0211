#include "reference/large_strain.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>

namespace mss::reference {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The springs that a cell of the infinite lattice has for its own, in units of the cell size.
struct LatticeSpring {
  Vector3d along;
  double SpringConstants::*stiffness;
};

const std::array<LatticeSpring, 13>& lattice_springs() {
  constexpr auto e = &SpringConstants::edge, f = &SpringConstants::face, b = &SpringConstants::body;
  static const std::array<LatticeSpring, 13> all{{{{1, 0, 0}, e},
                                                  {{0, 1, 0}, e},
                                                  {{0, 0, 1}, e},
                                                  {{1, 1, 0}, f},
                                                  {{1, -1, 0}, f},
                                                  {{1, 0, 1}, f},
                                                  {{1, 0, -1}, f},
                                                  {{0, 1, 1}, f},
                                                  {{0, 1, -1}, f},
                                                  {{1, 1, 1}, b},
                                                  {{-1, 1, 1}, b},
                                                  {{1, -1, 1}, b},
                                                  {{1, 1, -1}, b}}};
  return all;
}

/// det(F) F^-T, also of a singular F.
Matrix3d cofactors(const Matrix3d& F) {
  Matrix3d cof;
  for (int i = 0; i < 3; ++i) cof.col(i) = F.col((i + 1) % 3).cross(F.col((i + 2) % 3));
  return cof;
}

double lame_mu(const ElasticConstants& m) { return m.young / (2 * (1 + m.poisson)); }
double lame_lambda(const ElasticConstants& m) {
  return m.young * m.poisson / ((1 + m.poisson) * (1 - 2 * m.poisson));
}

Matrix3d green_strain(const Matrix3d& F) { return (F.transpose() * F - Matrix3d::Identity()) / 2; }

}  // namespace

CauchyBorn::CauchyBorn(const SpringConstants& springs, double cell_size)
    : springs_(springs), cell_size_(cell_size) {}

double CauchyBorn::energy(const Matrix3d& F) const {
  double sum = 0;
  for (const auto& [along, stiffness] : lattice_springs()) {
    const double stretch = (F * along).norm() - along.norm();  // over h
    sum += springs_.*stiffness * stretch * stretch / 2;
  }
  const double swelling = F.determinant() - 1;
  return sum / cell_size_ + springs_.volume * swelling * swelling / 2;
}

Matrix3d CauchyBorn::stress(const Matrix3d& F) const {
  Matrix3d sum = Matrix3d::Zero();
  for (const auto& [along, stiffness] : lattice_springs()) {
    const Vector3d now = F * along;
    sum += springs_.*stiffness * (1 - along.norm() / now.norm()) * now * along.transpose();
  }
  return sum / cell_size_ + springs_.volume * (F.determinant() - 1) * cofactors(F);
}

NeoHookean::NeoHookean(const ElasticConstants& material)
    : mu_(lame_mu(material)), lambda_(lame_lambda(material)) {}

double NeoHookean::energy(const Matrix3d& F) const {
  const double log_volume = std::log(F.determinant());
  return mu_ / 2 * (F.squaredNorm() - 3) - mu_ * log_volume + lambda_ / 2 * log_volume * log_volume;
}

Matrix3d NeoHookean::stress(const Matrix3d& F) const {
  const double volume = F.determinant();
  return mu_ * F + (lambda_ * std::log(volume) - mu_) / volume * cofactors(F);
}

StVenantKirchhoff::StVenantKirchhoff(const ElasticConstants& material)
    : mu_(lame_mu(material)), lambda_(lame_lambda(material)) {}

double StVenantKirchhoff::energy(const Matrix3d& F) const {
  const Matrix3d strain = green_strain(F);
  return mu_ * strain.squaredNorm() + lambda_ / 2 * strain.trace() * strain.trace();
}

Matrix3d StVenantKirchhoff::stress(const Matrix3d& F) const {
  const Matrix3d strain = green_strain(F);
  return F * (2 * mu_ * strain + lambda_ * strain.trace() * Matrix3d::Identity());
}

UniaxialState uniaxial_state(const LargeStrainLaw& law, double stretch) {
  const auto gradient = [&](double lateral) -> Matrix3d {
    return Vector3d(stretch, lateral, lateral).asDiagonal();
  };
  const auto across = [&](double lateral) { return law.stress(gradient(lateral))(1, 1); };
  // The stress across changes sign once where the law is stable: from push to pull. Sought outwards from the
  // state at rest, so that a second root far away is not taken.
  double low = 1, high = 1;
  while (across(low) > 0 && low > 1.0 / 3) low *= 0.99;
  while (across(high) < 0 && high < 3) high *= 1.01;
  if (across(low) > 0 || across(high) < 0)
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  for (int bisection = 0; bisection < 60; ++bisection) {
    const double middle = (low + high) / 2;
    (across(middle) < 0 ? low : high) = middle;
  }
  const double lateral = (low + high) / 2;
  return {lateral, law.stress(gradient(lateral))(0, 0)};
}

}  // namespace mss::reference
