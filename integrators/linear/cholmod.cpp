// Direct solver: CHOLMOD's supernodal Cholesky factorisation, ordered by nested dissection, analysed once.
// Chen, Davis, Hager and Rajamanickam, ACM TOMS 35 (2008) 22.
#include "integrators/linear/cholmod.hpp"

#include <fmt/format.h>
#include <suitesparse/cholmod.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <vector>

#include "integrators/linear/linear_solver.hpp"
#include "integrators/linear/one_thread.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

/// Symmetric rows are columns too, so CHOLMOD reads the matrix in place.
cholmod_sparse view(const SparseMatrix& matrix) {
  cholmod_sparse s{};
  s.nrow = s.ncol = std::size_t(matrix.rows());
  s.nzmax = std::size_t(matrix.nonZeros());
  s.p = const_cast<int*>(matrix.outerIndexPtr());
  s.i = const_cast<int*>(matrix.innerIndexPtr());
  s.x = const_cast<double*>(matrix.valuePtr());
  s.stype = -1;
  s.itype = CHOLMOD_INT;
  s.xtype = CHOLMOD_REAL;
  s.dtype = CHOLMOD_DOUBLE;
  s.sorted = s.packed = 1;
  return s;
}

cholmod_dense view(double* numbers, Eigen::Index rows, Eigen::Index columns) {
  cholmod_dense d{};
  d.nrow = d.d = std::size_t(rows);
  d.ncol = std::size_t(columns);
  d.nzmax = d.nrow * d.ncol;
  d.x = numbers;
  d.xtype = CHOLMOD_REAL;
  d.dtype = CHOLMOD_DOUBLE;
  return d;
}

}  // namespace

struct Cholesky::Workspace {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;
  std::vector<int> starts, columns;  ///< of the pattern analysed

  Workspace() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NESDIS;
    common.quick_return_if_not_posdef = 1;
  }
  /// Whether its pattern is not the last one's.
  bool has_changed(const SparseMatrix& matrix) {
    const std::span<const int> now(matrix.outerIndexPtr(), std::size_t(matrix.rows()) + 1),
        of_rows(matrix.innerIndexPtr(), std::size_t(matrix.nonZeros()));
    if (std::ranges::equal(now, starts) && std::ranges::equal(of_rows, columns)) return false;
    starts.assign(now.begin(), now.end());
    columns.assign(of_rows.begin(), of_rows.end());
    return true;
  }

  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  ~Workspace() {
    cholmod_free_factor(&factor, &common);
    for (cholmod_dense** d : {&x, &y, &e}) cholmod_free_dense(d, &common);
    cholmod_finish(&common);
  }
};

Cholesky::Cholesky() : workspace_(std::make_unique<Workspace>()) {}
Cholesky::~Cholesky() = default;

Status Cholesky::factor(const SparseMatrix& matrix) {
  if (matrix.rows() == 0) return Status::ok;  // every coordinate is prescribed
  const OneThread one_thread;
  Workspace& w = *workspace_;
  cholmod_sparse a = view(matrix);
  if (w.has_changed(matrix)) {
    cholmod_free_factor(&w.factor, &w.common);
    w.factor = cholmod_analyze(&a, &w.common);
  }
  if (!w.factor) throw std::bad_alloc();
  cholmod_factorize(&a, w.factor, &w.common);
  if (w.common.status < CHOLMOD_OK) throw std::bad_alloc();  // out of memory, or too large for int
  return w.common.status == CHOLMOD_NOT_POSDEF ? Status::not_positive_definite : Status::ok;
}

const double* Cholesky::solve(const double* rhs, Eigen::Index rows, Eigen::Index columns) {
  const OneThread one_thread;
  Workspace& w = *workspace_;
  cholmod_dense b = view(const_cast<double*>(rhs), rows, columns);
  if (!cholmod_solve2(CHOLMOD_A, w.factor, &b, nullptr, &w.x, nullptr, &w.y, &w.e, &w.common))
    throw std::bad_alloc();
  return static_cast<const double*>(w.x->x);
}

namespace {

class CholmodSolver final : public LinearSolver {
 public:
  Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                 const TangentCoefficients& sum, Work& work) override {
    if (!tangents_) matrix_ = tangents_of(system).pattern();
    tangents_ = &tangents_of(system);
    tangents_->values(t, x, v, sum, matrix_);
    ++work.jacobians;
    ++work.factorisations;
    return cholesky_.factor(matrix_);
  }

  Status solve(const Field<double>& rhs, Field<double>& solution, Work& work) override {
    gather(tangents_->unknowns(), rhs, rhs_);
    cholesky_.solve(rhs_, solution_);
    scatter(tangents_->unknowns(), solution_, solution);
    ++work.linear_solves;
    return Status::ok;
  }

 private:
  Tangents<double>* tangents_ = nullptr;
  SparseMatrix matrix_;
  Cholesky cholesky_;
  Eigen::VectorXd rhs_, solution_;
};

}  // namespace

std::string cholmod_version() {
  int v[3];
  ::cholmod_version(v);
  const std::string blas = openblas_get_config();  // begins "OpenBLAS 0.3.21 "
  return fmt::format("{}.{}.{} of SuiteSparse {}.{}.{}, {}", v[0], v[1], v[2], SUITESPARSE_MAIN_VERSION,
                     SUITESPARSE_SUB_VERSION, SUITESPARSE_SUBSUB_VERSION, blas.substr(0, blas.find(' ', 9)));
}

std::string blas_kernels() { return openblas_get_corename(); }

LinearSolverInfo cholmod() {
  return {.name = "cholmod",
          .summary = "CHOLMOD: supernodal sparse Cholesky, nested dissection",
          .make = [](double) { return std::make_unique<CholmodSolver>(); }};
}

}  // namespace mss
