#include "integrators/analysis/amplification.hpp"

#include <Eigen/Eigenvalues>

#include "integrators/analysis/scaled_tangent.hpp"
#include "integrators/analysis/spectra.hpp"

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
  FirstOrderForm(const ScaledTangent& tangent, double omega)
      : stiffness_(tangent.matrix(0, 1)), damping_(tangent.matrix(1, 0)), omega_(omega) {}

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
  SparseMatrix stiffness_, damping_;
  double omega_;
};

/// x -> R(dt A) x by Horner's rule, or x after drifts and kicks.
class Step {
 public:
  Step(const FirstOrderForm& form, const IntegratorInfo& method, double dt, Work& work)
      : form_(form), method_(method), dt_omega_(dt * form.omega()), work_(work), power_(rows()) {}

  Index rows() const { return 2 * form_.unknowns(); }
  void apply(const double* x_in, double* y_out) const {
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
    step.apply(unit.data(), matrix.col(i).data());
    unit[i] = 0;
  }
  return matrix;
}

}  // namespace

AmplifiedMotions most_amplified(SolidSystem<double>& system, const State<double>& state,
                                const IntegratorInfo& method, double dt, Work& work) {
  constexpr Index most_dense = 200, wanted = 10, space = 60, most_restarts = 2000;
  constexpr double tolerance = 1e-7;
  const FirstOrderForm form(ScaledTangent(system, state), system.spectral_bound().omega);
  if (form.unknowns() == 0) return {};
  Step step(form, method, dt, work);
  if (step.rows() <= most_dense) {
    const Eigen::EigenSolver<MatrixXd> all(dense(step));
    return motions_of(form, all.eigenvectors());
  }
  const LinearMap map{step.rows(), [&](const double* in, double* out) { step.apply(in, out); }};
  const auto found = arnoldi(
      map, {.wanted = wanted, .space = space, .most_restarts = most_restarts, .tolerance = tolerance});
  if (found.status != Status::ok) return {.status = found.status};
  return motions_of(form, found.vectors);
}

}  // namespace mss
