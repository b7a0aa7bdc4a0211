#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <map>
#include <vector>

#include "integrators/linear/constant_matrix.hpp"
#include "integrators/nonlinear/bounded_system.hpp"

namespace mss {

/// Solutions with a constant matrix A while some directions of some particles are held: from z = A^-1 r to
/// the z whose held directions have given values and whose A z differs from r by forces along these alone,
///   z + A^-1 N y,   S y = values - N^T z,   S = N^T A^-1 N,
/// with a column of N for every held direction. Columns of A^-1 are computed once for every particle that was
/// ever held; what is stored of them are the rows of such particles.
class HeldDirections {
 public:
  /// Both must outlive it.
  HeldDirections(System<double>& system, ConstantSolver& solver) : system_(system), solver_(solver) {}

  /// To be called after the solver has prepared another matrix.
  void forget_matrix();
  /// What is held from now on.
  void hold(const std::vector<HeldParticle>& particles);
  /// As above; `values`, of size 0: zero.
  void correct(const Field<double>& values, Field<double>& z);
  /// Keeps the columns: which half of S they fill depends on the order in which particles came. See
  /// core/base/record.hpp.
  void remember(Record& record);

 private:
  struct Direction {
    std::ptrdiff_t site;
    Eigen::Index particle;  ///< of those ever held
    Vec3 along;
  };
  Eigen::Index particle(std::ptrdiff_t site);

  System<double>& system_;
  ConstantSolver& solver_;
  std::map<std::ptrdiff_t, Eigen::Index> particles_;
  std::vector<std::ptrdiff_t> sites_;       ///< of them
  std::array<Eigen::MatrixXd, 3> columns_;  ///< by axis: rows and columns of A^-1 of these particles
  std::vector<Direction> directions_;
  Eigen::LLT<Eigen::MatrixXd> schur_;
  Field<double> unit_, column_;
};

}  // namespace mss
