// Exact solver of a box's constant matrices. With weighted sharing and lumped masses they are sums of
// products of three matrices, one along each axis: W = diag(1/2, 1 ... 1, 1/2), and A, which joins
// neighbours. With m the mass of an inner particle,
//   m WWW + w_edge (KWW + WKW + WWK) + w_face ((4WW - AA)W + ...) + w_body (8 WWW - AAA),
// K = 2W - A the stiffness of a chain. K phi = mu W phi diagonalises W, K and A at once, so a solve is a
// small dense product along each axis, a division, and the products back. Holding a whole face leaves out the
// first or last row of W and A, which changes the vectors and nothing else. Lynch, Rice and Thomas, Direct
// solution of partial difference equations by tensor product methods, Numerische Mathematik 6 (1964) 185.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <tuple>
#include <vector>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/linear/constant_matrix.hpp"
#include "integrators/linear/matrix_free.hpp"
#include "integrators/linear/unknowns.hpp"
#include "integrators/linear/vector_kernels.hpp"

namespace mss {

namespace {

/// Which ends of an axis are held.
struct Ends {
  bool low = false, high = false;
};

/// Eigenvectors of one axis, normalised in W, as rows of particles; zero at held ones and from the last mode
/// on. They are cosines where the first particle is free and sines where it is held; what is at the other end
/// decides how many half or quarter waves fit.
struct AxisBasis {
  int n = 0;  ///< particles
  int modes = 0;
  int columns = 0;
  AlignedArray<double> vectors;     ///< [particle][mode]
  AlignedArray<double> transposed;  ///< [mode][particle]
  std::vector<double> mu;           ///< eigenvalues

  AxisBasis(int cells, Ends held);
};

AxisBasis::AxisBasis(int cells, Ends held)
    : n(cells + 1),
      modes(n - (held.low ? 1 : 0) - (held.high ? 1 : 0)),
      columns((n + transform_padding - 1) / transform_padding * transform_padding),
      vectors(std::ptrdiff_t(n) * columns),
      transposed(std::ptrdiff_t(n) * columns),
      mu(std::size_t(n), 0.0) {
  for (int mode = 0; mode < modes; ++mode) {
    // The angle from a particle to the next is half_waves pi / (2 cells).
    const int half_waves = held.low != held.high ? 2 * mode + 1 : 2 * (mode + (held.low ? 1 : 0));
    const double half_angle = std::numbers::pi * half_waves / (4.0 * cells);
    mu[std::size_t(mode)] = 4 * std::sin(half_angle) * std::sin(half_angle);
    const double size = std::sqrt((half_waves == 0 || half_waves == 2 * cells ? 1.0 : 2.0) / cells);
    for (int i = 0; i < n; ++i) {
      if ((i == 0 && held.low) || (i == cells && held.high)) continue;
      const double angle = std::numbers::pi * double(half_waves * i % (4 * cells)) / (2.0 * cells);
      const double value = size * (held.low ? std::sin(angle) : std::cos(angle));
      vectors[std::ptrdiff_t(i) * columns + mode] = value;
      transposed[std::ptrdiff_t(mode) * columns + i] = value;
    }
  }
}

/// What is held of one coordinate, if it is whole faces.
struct HeldFaces {
  std::array<Ends, 3> axis;
  bool operator()(int a, int i, int cells) const {
    return (i == 0 && axis[std::size_t(a)].low) || (i == cells && axis[std::size_t(a)].high);
  }
};

template <class Visit>
void for_each_place(const Lattice& lattice, Visit&& visit) {
  for (int k = 0; k <= lattice.cells[2]; ++k)
    for (int j = 0; j <= lattice.cells[1]; ++j)
      for (int i = 0; i <= lattice.cells[0]; ++i) visit(std::array<int, 3>{i, j, k}, lattice.site(i, j, k));
}

/// The faces of which every particle is held.
HeldFaces held_faces(const Lattice& lattice, const double* mask) {
  HeldFaces faces;
  faces.axis.fill({true, true});
  for_each_place(lattice, [&](const std::array<int, 3>& at, std::ptrdiff_t site) {
    if (mask[site] == 0) return;
    for (std::size_t a = 0; a < 3; ++a) {
      if (at[a] == 0) faces.axis[a].low = false;
      if (at[a] == lattice.cells[a]) faces.axis[a].high = false;
    }
  });
  return faces;
}

/// Whether nothing but these faces is held.
bool are_all(const HeldFaces& faces, const Lattice& lattice, const double* mask) {
  bool all = true;
  for_each_place(lattice, [&](const std::array<int, 3>& at, std::ptrdiff_t site) {
    bool held = false;
    for (int a = 0; a < 3; ++a) held = held || faces(a, at[std::size_t(a)], lattice.cells[std::size_t(a)]);
    all = all && (mask[site] == 0) == held;
  });
  return all;
}

class SeparableSolver final : public ConstantSolver {
 public:
  SeparableSolver(const Body& body, const Field<double>& mask);
  Status prepare(const ConstantMatrix& matrix) override;
  void solve(System<double>& system, const Field<double>& rhs, Field<double>& solution) override {
    system.parallel(3,
                    [&](std::ptrdiff_t axis) { solve(rhs.axis(int(axis)), solution.axis(int(axis)), axis); });
  }

 private:
  /// Of one coordinate: axes' eigenvectors, 1 over eigenvalues in the order of the last transform forwards,
  /// [z][y][x], and room for two arrays.
  struct Coordinate {
    std::vector<AxisBasis> axes;
    AlignedArray<double> inverse;
    std::array<AlignedArray<double>, 2> room;
  };
  bool invert(const ConstantMatrix& matrix, Coordinate& coordinate) const;
  void solve(const double* rhs, double* solution, std::ptrdiff_t axis);

  Lattice lattice_;
  double cell_mass_;
  std::vector<Coordinate> coordinates_;
};

SeparableSolver::SeparableSolver(const Body& body, const Field<double>& mask)
    : lattice_(body.lattice()), cell_mass_(body.config().density * body.cell_volume()) {
  const std::ptrdiff_t size = lattice_.used() * lattice_.planes() + transform_padding;
  for (int c = 0; c < 3; ++c) {
    const HeldFaces faces = held_faces(lattice_, mask.axis(c));
    Coordinate coordinate;
    for (std::size_t a = 0; a < 3; ++a) coordinate.axes.emplace_back(lattice_.cells[a], faces.axis[a]);
    for (AlignedArray<double>* array : {&coordinate.inverse, &coordinate.room[0], &coordinate.room[1]})
      *array = AlignedArray<double>(size);
    coordinates_.push_back(std::move(coordinate));
  }
}

Status SeparableSolver::prepare(const ConstantMatrix& matrix) {
  bool definite = true;
  for (Coordinate& coordinate : coordinates_) definite = invert(matrix, coordinate) && definite;
  return definite ? Status::ok : Status::not_positive_definite;
}

/// False if an eigenvalue is not positive, or is zero but for rounding.
bool SeparableSolver::invert(const ConstantMatrix& matrix, Coordinate& coordinate) const {
  const double mass = matrix.mass * cell_mass_, edge = matrix.spring[0] + 4 * matrix.cell_edge;
  const double stiffest = mass + 12 * edge + 16 * matrix.spring[1] + 16 * matrix.spring[2];
  const auto& [x, y, z] = std::tie(coordinate.axes[0], coordinate.axes[1], coordinate.axes[2]);
  bool definite = true;
  coordinate.inverse.fill(0);
  for (int k = 0; k < z.modes; ++k)
    for (int j = 0; j < y.modes; ++j)
      for (int i = 0; i < x.modes; ++i) {
        const double p = x.mu[std::size_t(i)], q = y.mu[std::size_t(j)], r = z.mu[std::size_t(k)];
        const double sum = p + q + r, pairs = p * q + q * r + r * p;
        const double value = mass + edge * sum + matrix.spring[1] * (4 * sum - pairs) +
                             matrix.spring[2] * (4 * sum - 2 * pairs + p * q * r);
        if (!(value > 1e-14 * stiffest)) definite = false;
        coordinate.inverse[i + std::ptrdiff_t(x.n) * (j + std::ptrdiff_t(y.n) * k)] = 1 / value;
      }
  return definite;
}

/// Forwards along z, y, x, each time leaving that axis fastest; then back. The first reads the planes of a
/// field, the last writes them.
void SeparableSolver::solve(const double* rhs, double* solution, std::ptrdiff_t axis) {
  Coordinate& coordinate = coordinates_[std::size_t(axis)];
  const auto& [x, y, z] = std::tie(coordinate.axes[0], coordinate.axes[1], coordinate.axes[2]);
  double *first = coordinate.room[0].data(), *second = coordinate.room[1].data();
  const VectorKernels& kernels = fastest_copy<VectorKernels>();
  const auto along = [&](const AxisBasis& basis, const double* vectors, const double* in,
                         std::ptrdiff_t count, std::ptrdiff_t stride, double* out,
                         const double* scale = nullptr) {
    kernels.transform({.n = basis.n,
                       .columns = basis.columns,
                       .basis = vectors,
                       .in = in,
                       .stride = stride,
                       .count = count,
                       .out = out,
                       .scale = scale});
  };
  const std::ptrdiff_t xy = std::ptrdiff_t(x.n) * y.n, xz = std::ptrdiff_t(x.n) * z.n,
                       yz = std::ptrdiff_t(y.n) * z.n;
  along(z, z.vectors.data(), rhs, xy, lattice_.plane, first);
  along(y, y.vectors.data(), first, xz, xz, second);
  along(x, x.vectors.data(), second, yz, yz, first, coordinate.inverse.data());
  along(z, z.transposed.data(), first, xy, xy, second);
  along(y, y.transposed.data(), second, xz, xz, first);
  for (int k = 0; k < z.n; ++k)
    along(x, x.transposed.data(), first + std::ptrdiff_t(y.n) * k, y.n, yz, solution + lattice_.plane * k);
}

}  // namespace

std::string why_not_separable(const Body& body, const Field<double>& mask) {
  const BodyConfig& config = body.config();
  if (!config.is_solid())
    return fmt::format("is for cells of three dimensions, and this body is {}", config.noun());
  const std::size_t box = config.voxels.boxed();
  if (body.cell_count() != box)
    return fmt::format("is for boxes, and {} of the {} cells of this body's are empty",
                       box - body.cell_count(), box);
  if (!config.is_full())
    return "is for full cells of one part, and this body's have fill factors or more parts";
  if (config.sharing != Sharing::weighted)
    return "is for sharing = \"weighted\", and this body's is \"uniform\"";
  if (config.topology == Topology::one_diagonal)
    return "is for both diagonals of a face or none, and this body's topology is \"one_diagonal\"";
  if (!config.weights.empty()) return "is for the masses of cells alone, and this body has weights";
  for (int c = 0; c < 3; ++c)
    if (const HeldFaces faces = held_faces(body.lattice(), mask.axis(c));
        !are_all(faces, body.lattice(), mask.axis(c)))
      return fmt::format("is for boxes held by whole faces, and the hold of {} takes a part of one",
                         "xyz"[c]);
  return "";
}

std::unique_ptr<ConstantSolver> separable_solver(const Body& body, System<double>& system) {
  const Field<double> mask = mask_of_unknowns(system);
  if (const std::string reason = why_not_separable(body, mask); !reason.empty())
    throw InputError(fmt::format("separable {}; cholmod takes any body", reason));
  return std::make_unique<SeparableSolver>(body, mask);
}

namespace {

/// Conjugate gradients for the tangent itself, preconditioned by a constant matrix that bounds it.
class Separable final : public MatrixFree {
 public:
  using MatrixFree::MatrixFree;

 protected:
  Status prepare_preconditioner(System<double>& system, double, const Field<double>&, const Field<double>&,
                                const TangentCoefficients& sum, Work&) override {
    system_ = &system;
    const SpringSystem<double>* springs = system.springs();
    if (!springs)
      throw InputError(
          "the linear solver 'separable' is for boxes of springs, which this model is not; choose "
          "'matrix_free' or 'cholmod'");
    if (!solver_) solver_ = separable_solver(springs->body(), system);
    return solver_->prepare(bounding_matrix(springs->body(), sum.mass, sum.damping, sum.stiffness));
  }

  Products precondition(const std::function<void(Range)>& update, const Field<double>& r, Field<double>& z,
                        double enough) override {
    return precondition_whole(update, r, z, enough, [&](double) { solver_->solve(*system_, r, z); });
  }

 private:
  System<double>* system_ = nullptr;
  std::unique_ptr<ConstantSolver> solver_;
};

}  // namespace

LinearSolverInfo separable() {
  return {
      .name = "separable",
      .summary =
          "conjugate gradients, an exact solution of a constant matrix as preconditioner; boxes of springs",
      .one_lattice = true,
      .make = [](double tolerance) { return std::make_unique<Separable>(tolerance); }};
}

}  // namespace mss
