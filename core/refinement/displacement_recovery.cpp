#include "core/refinement/displacement_recovery.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "core/base/error.hpp"
#include "core/body/fill_shares.hpp"
#include "core/forces/cell_geometry.hpp"

namespace mss {

namespace {

using Matrix = Eigen::Matrix3d;
constexpr std::size_t gauss_points = 8;

/// From corner a to corner b of a cell at rest, in cells.
Vec3 corner_difference(int a, int b) { return (corner_sides(b) - corner_sides(a)) / 2; }

/// Of a Gauss point, from the middle of a cell of edges 1.
Vec3 gauss_offset(std::size_t g) { return corner_sides(int(g)) / (2 * std::sqrt(3.0)); }

/// Gradients at Gauss points of what corners and edges have between them, in a cell of edges 1.
struct Gradients {
  Gradients();
  std::array<std::array<Vec3, 8>, gauss_points> of_corner;
  std::array<std::array<std::array<Vec3, 4>, 3>, gauss_points> of_edge;  ///< by axis
};

/// Lower corners of the edges along an axis.
std::array<int, 4> edges_along(int axis) {
  std::array<int, 4> corners{};
  std::size_t count = 0;
  for (int c = 0; c < 8; ++c)
    if (corner_bit(c, axis) == 0) corners[count++] = c;
  return corners;
}

Gradients::Gradients() {
  for (std::size_t g = 0; g < gauss_points; ++g) {
    const Vec3 s = Vec3::Constant(0.5) + gauss_offset(g);
    // Linear along an axis from the other side, and its slope.
    const auto weight = [&](int c, int axis) { return corner_bit(c, axis) != 0 ? s[axis] : 1 - s[axis]; };
    const auto slope = [&](int c, int axis) { return double(corner_sign(c, axis)); };
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int c = 0; c < 8; ++c)
        of_corner[g][std::size_t(c)][axis] = slope(c, axis) * weight(c, u) * weight(c, v);
      const double bubble = s[axis] * (s[axis] - 1) / 2;
      std::size_t edge = 0;
      for (const int c : edges_along(axis)) {
        Vec3& gradient = of_edge[g][std::size_t(axis)][edge++];
        gradient[axis] = (s[axis] - 0.5) * weight(c, u) * weight(c, v);
        gradient[u] = bubble * slope(c, u) * weight(c, v);
        gradient[v] = bubble * weight(c, u) * slope(c, v);
      }
    }
  }
}

Matrix symmetric(const Matrix& m) { return (m + m.transpose()) / 2; }

/// a : C : b of symmetric tensors, without what C12 multiplies, the product of their traces.
double stiffness_product(const CubicStiffness& c, const Matrix& a, const Matrix& b) {
  const double shear = a(0, 1) * b(0, 1) + a(1, 2) * b(1, 2) + a(2, 0) * b(2, 0);
  return (c.c11 - c.c12) * a.diagonal().dot(b.diagonal()) + 4 * c.c44 * shear;
}

}  // namespace

DisplacementRecovery::DisplacementRecovery(const Body& body) : body_(body) {
  const BodyConfig& config = body.config();
  if (config.sharing != Sharing::weighted)
    throw InputError(
        "an estimate of the error needs springs that cells share by weight (sharing = \"weighted\")");
  if (config.topology == Topology::one_diagonal)
    throw InputError("an estimate of the error needs cells with both diagonals of a face, or none");
  cell_at_.assign(std::size_t(body.lattice().size), -1);
  std::unordered_map<const CellContent*, std::size_t> kind_of_content;
  body.for_each_cell([&](std::ptrdiff_t site) {
    cell_at_[std::size_t(site)] = int(cells_.size());
    cells_.push_back(site);
    const auto [entry, is_new] = kind_of_content.try_emplace(&body.content_at(site), kinds_.size());
    if (is_new) kinds_.push_back(kind_of(body.content_at(site)));
    kind_.push_back(entry->second);
  });
}

DisplacementRecovery::Kind DisplacementRecovery::kind_of(const CellContent& content) const {
  const BodyConfig& config = body_.config();
  constexpr std::array<double, 4> cells_that_share{0, 4, 2, 1};  // by how many axes a spring spans
  Kind kind;
  std::array<std::array<double, 8>, 8> stiffness{};  // of all parts, between corners a < b
  for (const auto& [number, fill] : content) {
    SpringConstants k = body_.parts()[std::size_t(number)].springs;
    if (config.topology == Topology::edges_body) k.face = 0;
    const double share = fill.share();
    const CubicStiffness c = cubic_stiffness(k, config.cell_size);
    if (!(c.c11 > c.c12 && c.c11 + 2 * c.c12 > 0 && c.c44 > 0))
      throw InputError("an estimate of the error needs springs that resist every deformation");
    for (int a = 0; a < 8; ++a)
      for (int b = a + 1; b < 8; ++b) {
        const int axes = std::popcount(unsigned(a ^ b));
        const double full = (axes == 1 ? k.edge : axes == 2 ? k.face : k.body) / cells_that_share[axes];
        stiffness[a][b] += full * blend(filled_at(fill, a, b), config.springs_floor(), share);
      }
    kind.volume += share * k.volume;
    kind.fill += share;
    for (std::size_t g = 0; g < gauss_points; ++g) {
      const double filled = double(fill.octant[g]);
      kind.elastic[g].c11 += filled * c.c11;
      kind.elastic[g].c12 += filled * c.c12;
      kind.elastic[g].c44 += filled * c.c44;
    }
    kind.parts.push_back(number);
  }
  for (int a = 0; a < 8; ++a)
    for (int b = a + 1; b < 8; ++b)
      if (stiffness[a][b] != 0) kind.springs.push_back({a, b, stiffness[a][b]});
  std::sort(kind.parts.begin(), kind.parts.end());
  return kind;
}

int DisplacementRecovery::neighbour(std::size_t cell, int axis, int step) const {
  const Lattice& lattice = body_.lattice();
  const std::ptrdiff_t site = cells_[cell];
  const int place = lattice.coordinates(site)[std::size_t(axis)] + step;
  if (place < 0 || place >= lattice.cells[std::size_t(axis)]) return -1;
  const int other = cell_at_[std::size_t(site + step * lattice.corner(1 << axis))];
  const bool alike = other >= 0 && kinds_[kind_[std::size_t(other)]].parts == kinds_[kind_[cell]].parts;
  return alike ? other : -1;
}

DisplacementRecovery::SecondDifferences DisplacementRecovery::second_differences(
    std::size_t cell, const Field<double>& field) const {
  SecondDifferences all;
  const std::array<Vec3, 8> corners = corners_of(body_, field, cells_[cell]);
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t along = std::size_t{1} << axis;
    const std::array<int, 4> lower = edges_along(axis);
    std::array<Vec3, 4>& sums = all[std::size_t(axis)];
    sums.fill(Vec3::Zero());
    int ends = 0;
    for (const int step : {-1, 1}) {
      const int other = neighbour(cell, axis, step);
      if (other < 0) continue;
      const std::array<Vec3, 8> next = corners_of(body_, field, cells_[std::size_t(other)]);
      for (std::size_t e = 0; e < 4; ++e) {
        const auto edge = [&](const std::array<Vec3, 8>& of) -> Vec3 {
          return of[std::size_t(lower[e]) + along] - of[std::size_t(lower[e])];
        };
        sums[e] += step * (edge(next) - edge(corners));
      }
      ++ends;
    }
    if (ends == 2)
      for (Vec3& sum : sums) sum /= 2;
  }
  return all;
}

std::vector<double> DisplacementRecovery::volume_strains(const StrainField& field) const {
  const double h = body_.config().cell_size;
  std::vector<double> all;
  all.reserve(cells_.size());
  for (const std::ptrdiff_t site : cells_) {
    const Matrix f = mean_edges(corners_of(body_, field.positions, site)) / h;
    all.push_back(field.displacement == nullptr
                      ? (f.squaredNorm() - 3) / 2
                      : f.cwiseProduct(mean_edges(corners_of(body_, *field.displacement, site)) / h).sum());
  }
  return all;
}

Vec3 DisplacementRecovery::slope(std::size_t cell, const std::vector<double>& of_cells) const {
  Vec3 slope = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    int ends = 0;
    for (const int step : {-1, 1}) {
      const int other = neighbour(cell, axis, step);
      if (other < 0) continue;
      slope[axis] += step * (of_cells[std::size_t(other)] - of_cells[cell]);
      ++ends;
    }
    if (ends == 2) slope[axis] /= 2;
  }
  return slope;
}

void DisplacementRecovery::find_strains(std::size_t cell, const StrainField& field,
                                        const std::vector<double>& volumes, CellStrains& strains) const {
  static const Gradients gradients;
  const double h = body_.config().cell_size;
  const bool change = field.displacement != nullptr;
  const std::array<Vec3, 8> x = corners_of(body_, field.positions, cells_[cell]);
  const std::array<Vec3, 8> z = change ? corners_of(body_, *field.displacement, cells_[cell]) : x;
  const Matrix one = Matrix::Identity();
  // Green's strain and its derivative, of a deformation gradient and its change.
  const auto strain = [&](const Matrix& f, const Matrix& by) -> Matrix {
    return change ? symmetric(f.transpose() * by) : Matrix((f.transpose() * f - one) / 2);
  };
  strains.volume = volumes[cell];
  strains.volume_slope = slope(cell, volumes);
  std::size_t s = 0;
  for (const auto& [a, b, stiffness] : kinds_[kind_[cell]].springs) {
    const double squared = h * h * corner_difference(a, b).squaredNorm();
    const Vec3 d = x[std::size_t(b)] - x[std::size_t(a)];
    strains.springs[s++] =
        change ? d.dot(z[std::size_t(b)] - z[std::size_t(a)]) / squared : (d.squaredNorm() / squared - 1) / 2;
  }
  const SecondDifferences bent = second_differences(cell, field.positions);
  const SecondDifferences bends = change ? second_differences(cell, *field.displacement) : bent;
  for (std::size_t g = 0; g < gauss_points; ++g) {
    const auto gradient = [&](const std::array<Vec3, 8>& corners) {
      Matrix sum = Matrix::Zero();
      for (std::size_t c = 0; c < 8; ++c) sum += corners[c] * gradients.of_corner[g][c].transpose();
      return Matrix(sum / h);
    };
    const auto gradient_of_rest = [&](const SecondDifferences& differences) {
      Matrix sum = Matrix::Zero();
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t e = 0; e < 4; ++e)
          sum += differences[axis][e] * gradients.of_edge[g][axis][e].transpose();
      return Matrix(sum / h);
    };
    const Matrix f = gradient(x), rest = gradient_of_rest(bent);
    if (!change) {
      strains.trilinear[g] = strain(f, f);
      strains.rest[g] = symmetric(f.transpose() * rest);
      continue;
    }
    const Matrix by = gradient(z);
    strains.trilinear[g] = strain(f, by);
    strains.rest[g] = symmetric(f.transpose() * gradient_of_rest(bends) + by.transpose() * rest);
  }
}

double DisplacementRecovery::Products::error_of_all() const {
  return std::accumulate(error.begin(), error.end(), 0.0);
}

DisplacementRecovery::Products DisplacementRecovery::products(const StrainField& a,
                                                              const StrainField& b) const {
  const double h = body_.config().cell_size, volume = body_.cell_volume();
  const bool same = &a.positions == &b.positions && a.displacement == b.displacement;
  Products products;
  products.error.reserve(cells_.size());
  const std::vector<double> volumes_a = volume_strains(a), volumes_b = same ? volumes_a : volume_strains(b);
  CellStrains of_a, of_b;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const Kind& kind = kinds_[kind_[cell]];
    find_strains(cell, a, volumes_a, of_a);
    if (!same) find_strains(cell, b, volumes_b, of_b);
    const CellStrains& other = same ? of_a : of_b;
    double stored = volume * kind.volume * of_a.volume * other.volume;
    for (std::size_t s = 0; s < kind.springs.size(); ++s) {
      const auto& [from, to, stiffness] = kind.springs[s];
      stored +=
          stiffness * h * h * corner_difference(from, to).squaredNorm() * of_a.springs[s] * other.springs[s];
    }
    double continuum = 0;
    for (std::size_t g = 0; g < gauss_points; ++g) {
      const CubicStiffness& c = kind.elastic[g];
      const double q_a = of_a.volume_slope.dot(gauss_offset(g)),
                   q_b = other.volume_slope.dot(gauss_offset(g)),
                   t_a = of_a.trilinear[g].trace() - of_a.volume,
                   t_b = other.trilinear[g].trace() - other.volume;
      continuum += stiffness_product(c, of_a.trilinear[g], other.trilinear[g]) -
                   stiffness_product(c, of_a.rest[g], other.rest[g]) +
                   c.c12 * (of_a.volume * other.volume - q_a * q_b + q_a * t_b + t_a * q_b);
    }
    products.error.push_back(stored - volume / gauss_points * continuum);
    products.stored += stored;
  }
  return products;
}

double DisplacementRecovery::share_alone() const {
  std::size_t alone = 0;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    for (int axis = 0; axis < 3; ++axis)
      if (neighbour(cell, axis, -1) < 0 && neighbour(cell, axis, 1) < 0) {
        ++alone;
        break;
      }
  return double(alone) / double(cells_.size());
}

bool DisplacementRecovery::has_partial_cells() const {
  constexpr double full = 1 - 1e-5;
  return std::any_of(kinds_.begin(), kinds_.end(), [](const Kind& kind) { return kind.fill < full; });
}

}  // namespace mss
