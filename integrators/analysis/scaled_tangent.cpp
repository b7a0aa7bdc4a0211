#include "integrators/analysis/scaled_tangent.hpp"

#include "integrators/linear/unknowns.hpp"

namespace mss {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// y += factor A x for `width` columns from the first on: one pass over the matrix serves all.
template <int width>
void add_columns(double factor, const SparseMatrix& a, const MatrixXd& x, Index first, MatrixXd& y) {
  const Eigen::Matrix<double, Eigen::Dynamic, width, width == 1 ? Eigen::ColMajor : Eigen::RowMajor> rows =
      factor * x.middleCols<width>(first);
  for (Index i = 0; i < a.rows(); ++i) {
    Eigen::Matrix<double, 1, width> sum = Eigen::Matrix<double, 1, width>::Zero();
    for (SparseMatrix::InnerIterator entry(a, i); entry; ++entry)
      sum += entry.value() * rows.row(entry.col());
    y.block<1, width>(i, first) += sum;
  }
}

void add_product(double factor, const SparseMatrix& a, const MatrixXd& x, MatrixXd& y) {
  Index first = 0;
  for (; first + 8 <= x.cols(); first += 8) add_columns<8>(factor, a, x, first, y);
  for (; first + 4 <= x.cols(); first += 4) add_columns<4>(factor, a, x, first, y);
  for (; first < x.cols(); ++first) add_columns<1>(factor, a, x, first, y);
}

}  // namespace

ScaledTangent::ScaledTangent(SolidSystem<double>& system, const State<double>& state)
    : system_(system), state_(state), roots_(root_masses(system)), in_(system.size()), out_(system.size()) {}

Field<double> ScaledTangent::to_field(const VectorXd& unknowns) const {
  Field<double> field(system_.size());
  scatter(tangents_of(system_).unknowns(), unknowns, field);
  return field;
}

SparseMatrix ScaledTangent::matrix(double damping, double stiffness) const {
  SparseMatrix matrix = tangents_of(system_).pattern();
  tangents_of(system_).values(state_.t, state_.x, state_.v,
                              {.damping = damping, .stiffness = stiffness, .kind = Tangent::elastic}, matrix);
  const VectorXd scale = roots_.cwiseInverse();
  return scale.asDiagonal() * matrix * scale.asDiagonal();
}

void ScaledTangent::multiply(double damping, double stiffness, const MatrixXd& x, MatrixXd& y, Work& work) {
  work.products += x.cols();
  if (system_.springs())
    return sweep({.damping = damping, .stiffness = stiffness, .kind = Tangent::elastic}, x, y);
  if (stiffness_.rows() == 0) stiffness_ = matrix(0, 1);
  if (damping != 0 && damping_.rows() == 0) damping_ = matrix(1, 0);
  y = MatrixXd::Zero(x.rows(), x.cols());
  add_product(stiffness, stiffness_, x, y);
  if (damping != 0) add_product(damping, damping_, x, y);
}

void ScaledTangent::sweep(const TangentCoefficients& sum, const MatrixXd& x, MatrixXd& y) {
  Tangents<double>& tangents = tangents_of(system_);
  y.resize(x.rows(), x.cols());
  for (Index i = 0; i < x.cols(); ++i) {
    column_ = x.col(i).cwiseQuotient(roots_);
    scatter(tangents.unknowns(), column_, in_);
    tangents.product(state_.t, state_.x, state_.v, sum, in_, out_);
    gather(tangents.unknowns(), out_, column_);
    y.col(i) = column_.cwiseQuotient(roots_);
  }
}

}  // namespace mss
