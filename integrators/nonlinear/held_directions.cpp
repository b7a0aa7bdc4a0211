#include "integrators/nonlinear/held_directions.hpp"

#include <Eigen/Eigenvalues>

#include "core/base/record.hpp"

namespace mss {

void HeldDirections::forget_matrix() {
  particles_.clear();
  sites_.clear();
  directions_.clear();
}

/// A particle's number among those ever held; a new one gets its column.
Eigen::Index HeldDirections::particle(std::ptrdiff_t site) {
  const auto [at, is_new] = particles_.try_emplace(site, Eigen::Index(sites_.size()));
  if (!is_new) return at->second;
  if (unit_.size() == 0) unit_ = column_ = Field<double>(system_.size());
  unit_.set(site, Vec3::Ones());
  solver_.solve(system_, unit_, column_);
  unit_.set(site, Vec3::Zero());
  sites_.push_back(site);
  const auto size = Eigen::Index(sites_.size());
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd& columns = columns_[std::size_t(axis)];
    if (columns.rows() < size) columns.conservativeResize(2 * size, 2 * size);
    for (Eigen::Index i = 0; i < size; ++i)
      columns(i, size - 1) = columns(size - 1, i) = column_.axis(axis)[sites_[std::size_t(i)]];
  }
  return at->second;
}

void HeldDirections::hold(const std::vector<HeldParticle>& particles) {
  directions_.clear();
  for (const HeldParticle& held : particles) {
    const Eigen::Index number = particle(held.site);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> basis(held.directions);
    for (int i = 0; i < 3; ++i)
      if (basis.eigenvalues()[i] > 0.5)
        directions_.push_back({held.site, number, basis.eigenvectors().col(i)});
  }
  const auto size = Eigen::Index(directions_.size());
  Eigen::MatrixXd schur(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Direction &a = directions_[std::size_t(i)], &b = directions_[std::size_t(j)];
      double sum = 0;
      for (int axis = 0; axis < 3; ++axis)
        sum += a.along[axis] * b.along[axis] * columns_[std::size_t(axis)](a.particle, b.particle);
      schur(i, j) = sum;
    }
  if (size > 0) schur_.compute(schur);
}

void HeldDirections::remember(Record& record) {
  record.keep(particles_, sites_);
  const auto size = Eigen::Index(sites_.size());
  for (Eigen::MatrixXd& columns : columns_) {
    if (record.reads()) columns.resize(size, size);
    for (Eigen::Index column = 0; column < size; ++column)
      record.keep_values(std::span(columns.col(column).data(), std::size_t(size)));
  }
  if (size > 0 && unit_.size() == 0) unit_ = column_ = Field<double>(system_.size());
}

void HeldDirections::correct(const Field<double>& values, Field<double>& z) {
  if (directions_.empty()) return;
  Eigen::VectorXd y(Eigen::Index(directions_.size()));
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const auto& [site, number, along] = directions_[i];
    y[Eigen::Index(i)] = along.dot((values.size() == 0 ? Vec3(Vec3::Zero()) : values.at(site)) - z.at(site));
  }
  schur_.solveInPlace(y);
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const auto& [site, number, along] = directions_[i];
    unit_.set(site, unit_.at(site) + y[Eigen::Index(i)] * along);
  }
  solver_.solve(system_, unit_, column_);
  z.array() += column_.array();
  for (const Direction& direction : directions_) unit_.set(direction.site, Vec3::Zero());
}

}  // namespace mss
