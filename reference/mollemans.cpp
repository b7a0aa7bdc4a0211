#include "reference/mollemans.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <array>
#include <cmath>

#include "core/base/error.hpp"
#include "core/springs/element_tangents.hpp"

namespace mss {

using Eigen::Matrix3d;

namespace {

using Gradient = Eigen::Matrix<double, 3, 4>;

/// Corners of five tetrahedra, four at every other corner of the cell and one between them, and of their
/// mirror image. Vertices are ordered so that volumes are positive.
constexpr std::array<std::array<int, 4>, 10> tetrahedra{{{0, 1, 2, 4},
                                                         {3, 2, 1, 7},
                                                         {5, 1, 4, 7},
                                                         {6, 4, 2, 7},
                                                         {1, 2, 4, 7},
                                                         {1, 0, 5, 3},
                                                         {2, 0, 3, 6},
                                                         {4, 0, 6, 5},
                                                         {7, 3, 5, 6},
                                                         {0, 3, 6, 5}}};

/// One tetrahedron of a cell: its volume, how that changes with its vertices, and where eq. 1-1 pushes them.
struct Tetrahedron {
  double volume;
  Gradient gradient;   ///< dV/dp_j
  Gradient arm;        ///< p_j - b
  Gradient direction;  ///< u_j

  Tetrahedron(const CellCorners& x, const std::array<int, 4>& vertex) {
    Gradient p;
    for (int j = 0; j < 4; ++j) p.col(j) = x.col(vertex[std::size_t(j)]);
    const Vec3 a = p.col(1) - p.col(0), b = p.col(2) - p.col(0), c = p.col(3) - p.col(0);
    gradient.col(1) = b.cross(c) / 6;
    gradient.col(2) = c.cross(a) / 6;
    gradient.col(3) = a.cross(b) / 6;
    gradient.col(0) = -(gradient.col(1) + gradient.col(2) + gradient.col(3));
    volume = a.dot(gradient.col(1));
    arm = p.colwise() - p.rowwise().mean();
    for (int j = 0; j < 4; ++j) direction.col(j) = arm.col(j).stableNormalized();
  }
};

CellCorners unit_cell() {
  CellCorners x;
  for (int c = 0; c < 8; ++c) x.col(c) = Vec3(c & 1, (c >> 1) & 1, (c >> 2) & 1);
  return x;
}

/// Volume of a tetrahedron of the unit cell: a sixth at corners, a third in between.
double rest_volume(std::size_t t) { return t % 5 == 4 ? 1.0 / 3 : 1.0 / 6; }

/// Half of kappa. The mean stress of forces F on the corners p of a cell is sum F p^T / V0; those of all ten
/// tetrahedra have the symmetry of the cube, so a third of its trace is minus a pressure.
double calibrated_kappa(double k_vol, double cell_size) {
  double sum = 0;
  for (const auto& corners : tetrahedra) {
    const Tetrahedron tet(unit_cell(), corners);
    for (int j = 0; j < 4; ++j)
      sum += tet.volume *
             tet.direction.col(j).dot(unit_cell().col(corners[std::size_t(j)]) - Vec3::Constant(0.5));
  }
  return 3 * k_vol / (sum * cell_size);
}

/// Penalties depend on the body's stiffness, which is more than the springs'.
Environment without_planes(Environment environment) {
  environment.planes.clear();
  environment.obstacles.clear();
  return environment;
}

const Body& full(const Body& body) {
  if (!body.config().is_full())
    throw InputError(
        "the model \"mollemans\" is for full cells of one part, and this body's have fill factors or more "
        "parts; choose \"springs\"");
  return body;
}

Body without_volume_force(const Body& body) {
  BodyConfig config = body.config();
  config.springs.volume = 0;
  return Body(config);
}

/// -dF_j/dp_i = kappa (u_j (dV/dp_i)^T + (V - V0) (I - u_j u_j^T) (delta_ij - 1/4) / |p_j - b|).
CellMatrix cell_tangent(double kappa, double cell_volume, const CellCorners& x, Tangent kind) {
  CellMatrix k = CellMatrix::Zero();
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const Tetrahedron tet(x, tetrahedra[t]);
    const double excess = tet.volume - rest_volume(t) * cell_volume;
    const double along = tet.direction.cwiseProduct(tet.gradient).sum() / tet.gradient.squaredNorm();
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        Matrix3d block = std::max(0.0, kappa * along) * tet.gradient.col(j) * tet.gradient.col(i).transpose();
        if (kind == Tangent::exact) {
          const Vec3 u = tet.direction.col(j);
          block = kappa * u * tet.gradient.col(i).transpose() +
                  kappa * excess * ((i == j ? 1 : 0) - 0.25) / tet.arm.col(j).norm() *
                      (Matrix3d::Identity() - u * u.transpose());
        }
        k.block<3, 3>(3L * tetrahedra[t][std::size_t(j)], 3L * tetrahedra[t][std::size_t(i)]) += block;
      }
  }
  return k;
}

/// A cell's matrix at rest bounds what its volume force adds to the springs' frequencies, as in FemElement.
SpectralBound bound_of(const Body& body) {
  SpectralBound bound = spectral_bound(without_volume_force(body));
  const double size = body.config().cell_size;
  const double kappa = calibrated_kappa(body.config().springs.volume, size);
  const CellMatrix k = cell_tangent(kappa, body.cell_volume(), size * unit_cell(), Tangent::exact);
  const double corner_mass = body.config().density * body.cell_volume() / 8;
  bound.omega = std::sqrt(bound.omega * bound.omega +
                          Eigen::JacobiSVD<CellMatrix>(k).singularValues()[0] / corner_mass);
  return bound;
}

}  // namespace

MollemansSystem::MollemansSystem(const Body& body, const Environment& environment, int threads)
    : BodySystem<double>(full(body), environment, bound_of(body), threads > 0 ? threads : 1),
      kappa_(calibrated_kappa(body.config().springs.volume, body.config().cell_size)),
      bare_(without_volume_force(body)),
      springs_(bare_, without_planes(environment), {.threads = this->threads()}),
      cells_(body),
      tangents_(*this) {}

CellCorners MollemansSystem::cell_force(const CellCorners& x) const {
  CellCorners force = CellCorners::Zero();
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const Tetrahedron tet(x, tetrahedra[t]);
    const double excess = tet.volume - rest_volume(t) * body().cell_volume();
    for (int j = 0; j < 4; ++j)
      force.col(tetrahedra[t][std::size_t(j)]) -= kappa_ * excess * tet.direction.col(j);
  }
  return force;
}

std::optional<std::vector<Matrix3d>> MollemansSystem::cell_virials(const Field<double>& x,
                                                                   const Field<double>& v) const {
  std::optional<std::vector<Matrix3d>> virials = springs_.cell_virials(x, v);
  for (std::size_t cell = 0; cell < cells_.cells().size(); ++cell) {
    const CellCorners corners = corners_at(body(), x, cells_.cells()[cell]);
    (*virials)[cell] += virial_about_middle(cell_force(corners), corners);
  }
  return virials;
}

void MollemansSystem::force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) {
  springs_.force(t, x, v, f);
  cells_.add(
      *this, [&](std::ptrdiff_t site) { return cell_force(corners_at(body(), x, site)); }, f);
  add_penalty_force(t, x, v, f);
}

CellMatrix MollemansSystem::MollemansTangents::cell(const Field<double>& x, std::ptrdiff_t site,
                                                    const TangentCoefficients& sum) const {
  return sum.stiffness *
         cell_tangent(system_.kappa_, body().cell_volume(), corners_at(body(), x, site), sum.kind);
}

void MollemansSystem::MollemansTangents::add(double, const Field<double>& x, const Field<double>& v,
                                             const TangentCoefficients& sum, BlockMatrix& blocks) {
  add_tangent(system_.bare_, x, v, sum, blocks);
  for (const std::ptrdiff_t site : system_.cells_.cells()) {
    const CellMatrix k = cell(x, site, sum);
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 8; ++d) blocks.add(site, c, d, block_of(k, c, d));
  }
}

void MollemansSystem::MollemansTangents::multiply(double t, const Field<double>& x, const Field<double>& v,
                                                  const TangentCoefficients& sum, const Field<double>& p,
                                                  Field<double>& out) {
  system_.springs_.tangents()->product(t, x, v, sum, p, out);
  system_.cells_.add(
      system_,
      [&](std::ptrdiff_t site) -> CellCorners {
        const CellCorners along = corners_at(body(), p, site);
        const Eigen::Matrix<double, 24, 1> product =
            sum.stiffness *
            cell_tangent(system_.kappa_, body().cell_volume(), corners_at(body(), x, site), sum.kind) *
            Eigen::Map<const Eigen::Matrix<double, 24, 1>>(along.data());
        return Eigen::Map<const CellCorners>(product.data());
      },
      out);
}

void MollemansSystem::MollemansTangents::add_diagonal(double, const Field<double>& x, const Field<double>& v,
                                                      const TangentCoefficients& sum,
                                                      std::vector<Matrix3d>& diagonal) {
  std::vector<Matrix3d> springs;
  system_.springs_.tangents()->diagonal(
      0, x, v, {.damping = sum.damping, .stiffness = sum.stiffness, .kind = sum.kind}, springs);
  for (std::size_t p = 0; p < diagonal.size(); ++p) diagonal[p] += springs[p];
  for (const std::ptrdiff_t site : system_.cells_.cells()) {
    const CellMatrix k = cell(x, site, sum);
    for (int c = 0; c < 8; ++c)
      diagonal[std::size_t(body().particle(site + body().lattice().corner(c)))] += block_of(k, c, c);
  }
}

}  // namespace mss
