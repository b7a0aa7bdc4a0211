#include "integrators/amplification.hpp"

#include <Spectra/GenEigsSolver.h>

#include <Eigen/Eigenvalues>

#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// K and C scaled to unit masses, and A in a unit of time that gives its two rows the same scale.
class FirstOrderForm {
 public:
  FirstOrderForm(BodySystem<double>& system, const State<double>& state)
      : stiffness_(scaled(system, state, {.stiffness = 1, .kind = Tangent::elastic})),
        damping_(scaled(system, state, {.damping = 1, .kind = Tangent::elastic})),
        omega_(system.spectral_bound().omega) {}

  Index unknowns() const { return stiffness_.rows(); }
  double omega() const { return omega_; }

  /// y = A x / omega, x and y of (omega q, q').
  void apply(const VectorXd& x, VectorXd& y) const {
    const Index n = unknowns();
    y.head(n) = x.tail(n);
    y.tail(n).noalias() = stiffness_ * x.head(n) / (-omega_ * omega_);
    y.tail(n).noalias() -= damping_ * x.tail(n) / omega_;
  }

  /// Of a motion of any norm.
  RayleighQuotients quotients(const VectorXcd& q) const {
    const double length = q.squaredNorm();
    return {.stiffness = q.dot(stiffness_ * q).real() / length,
            .damping = q.dot(damping_ * q).real() / length};
  }

 private:
  static SparseMatrix scaled(BodySystem<double>& system, const State<double>& state, const TangentSum& sum) {
    const VectorXd scale = root_masses(system).cwiseInverse();
    SparseMatrix matrix = tangents_of(system).pattern();
    tangents_of(system).values(state.t, state.x, state.v, sum, matrix);
    return scale.asDiagonal() * matrix * scale.asDiagonal();
  }

  SparseMatrix stiffness_, damping_;
  double omega_;
};

/// x -> R(dt A) x, by Horner's rule.
class Step {
 public:
  using Scalar = double;
  Step(const FirstOrderForm& form, const std::vector<double>& polynomial, double dt, Work& work)
      : form_(form), polynomial_(polynomial), dt_omega_(dt * form.omega()), work_(work), power_(rows()) {}

  Index rows() const { return 2 * form_.unknowns(); }
  Index cols() const { return rows(); }
  void perform_op(const double* x_in, double* y_out) const {
    const Eigen::Map<const VectorXd> x(x_in, rows());
    sum_ = polynomial_.back() * x;
    for (std::size_t i = polynomial_.size() - 1; i-- > 0;) {
      form_.apply(sum_, power_);
      sum_ = polynomial_[i] * x + dt_omega_ * power_;
      work_.products += 2;
    }
    Eigen::Map<VectorXd>(y_out, rows()) = sum_;
  }

 private:
  const FirstOrderForm& form_;
  const std::vector<double>& polynomial_;
  double dt_omega_;
  Work& work_;
  mutable VectorXd sum_, power_;
};

/// Of the eigenvectors in the columns.
AmplifiedMotions motions_of(const FirstOrderForm& form, const MatrixXcd& vectors) {
  AmplifiedMotions result;
  for (Index i = 0; i < vectors.cols(); ++i) {
    const RayleighQuotients motion = form.quotients(vectors.col(i).head(form.unknowns()));
    if (!is_rigid(motion, form.omega())) result.motions.push_back(motion);
  }
  return result;
}

MatrixXd dense(const Step& step) {
  MatrixXd matrix(step.rows(), step.rows());
  VectorXd unit = VectorXd::Zero(step.rows());
  for (Index i = 0; i < step.rows(); ++i) {
    unit[i] = 1;
    step.perform_op(unit.data(), matrix.col(i).data());
    unit[i] = 0;
  }
  return matrix;
}

}  // namespace

AmplifiedMotions most_amplified(BodySystem<double>& system, const State<double>& state,
                                const std::vector<double>& polynomial, double dt, Work& work) {
  constexpr Index most_dense = 200, wanted = 10, space = 60, most_restarts = 2000;
  constexpr double tolerance = 1e-7;
  const FirstOrderForm form(system, state);
  if (form.unknowns() == 0) return {};
  Step step(form, polynomial, dt, work);
  if (step.rows() <= most_dense) {
    const Eigen::EigenSolver<MatrixXd> all(dense(step));
    return motions_of(form, all.eigenvectors());
  }
  Spectra::GenEigsSolver<Step> arnoldi(step, wanted, space);
  arnoldi.init();
  arnoldi.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
  if (arnoldi.info() != Spectra::CompInfo::Successful) return {.status = Status::linear_stalled};
  return motions_of(form, arnoldi.eigenvectors());
}

}  // namespace mss
