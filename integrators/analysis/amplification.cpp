#include "integrators/analysis/amplification.hpp"

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
  FirstOrderForm(SolidSystem<double>& system, const State<double>& state)
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
  /// A drift and a kick of x, by these times over omega.
  void drift(double time, VectorXd& x) const { x.head(unknowns()) += time * x.tail(unknowns()); }
  void kick(double time, VectorXd& x, VectorXd& y) const {
    apply(x, y);
    x.tail(unknowns()) += time * y.tail(unknowns());
  }

  /// Of a motion of any norm.
  RayleighQuotients quotients(const VectorXcd& q) const {
    const double length = q.squaredNorm();
    return {.stiffness = q.dot(stiffness_ * q).real() / length,
            .damping = q.dot(damping_ * q).real() / length};
  }

 private:
  static SparseMatrix scaled(SolidSystem<double>& system, const State<double>& state,
                             const TangentCoefficients& sum) {
    const VectorXd scale = root_masses(system).cwiseInverse();
    SparseMatrix matrix = tangents_of(system).pattern();
    tangents_of(system).values(state.t, state.x, state.v, sum, matrix);
    return scale.asDiagonal() * matrix * scale.asDiagonal();
  }

  SparseMatrix stiffness_, damping_;
  double omega_;
};

/// x -> R(dt A) x by Horner's rule, or x after drifts and kicks.
class Step {
 public:
  using Scalar = double;
  Step(const FirstOrderForm& form, const IntegratorInfo& method, double dt, Work& work)
      : form_(form), method_(method), dt_omega_(dt * form.omega()), work_(work), power_(rows()) {}

  Index rows() const { return 2 * form_.unknowns(); }
  Index cols() const { return rows(); }
  void perform_op(const double* x_in, double* y_out) const {
    const Eigen::Map<const VectorXd> x(x_in, rows());
    if (method_.splitting.empty())
      apply_polynomial(x);
    else
      drift_and_kick(x);
    Eigen::Map<VectorXd>(y_out, rows()) = sum_;
  }

 private:
  void apply_polynomial(const Eigen::Map<const VectorXd>& x) const {
    const std::vector<double>& polynomial = method_.polynomial;
    sum_ = polynomial.back() * x;
    for (std::size_t i = polynomial.size() - 1; i-- > 0;) {
      form_.apply(sum_, power_);
      sum_ = polynomial[i] * x + dt_omega_ * power_;
      work_.products += 2;
    }
  }
  void drift_and_kick(const Eigen::Map<const VectorXd>& x) const {
    sum_ = x;
    for (const DriftKick& part : method_.splitting) {
      form_.drift(dt_omega_ * part.drift, sum_);
      if (part.kick == 0) continue;
      form_.kick(dt_omega_ * part.kick, sum_, power_);
      work_.products += 2;
    }
  }

  const FirstOrderForm& form_;
  const IntegratorInfo& method_;
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

AmplifiedMotions most_amplified(SolidSystem<double>& system, const State<double>& state,
                                const IntegratorInfo& method, double dt, Work& work) {
  constexpr Index most_dense = 200, wanted = 10, space = 60, most_restarts = 2000;
  constexpr double tolerance = 1e-7;
  const FirstOrderForm form(system, state);
  if (form.unknowns() == 0) return {};
  Step step(form, method, dt, work);
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
