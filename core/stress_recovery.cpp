#include "core/stress_recovery.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "core/element_tangents.hpp"
#include "core/error.hpp"
#include "core/fill_shares.hpp"

namespace mss {

namespace {

using Matrix = Eigen::Matrix3d;

/// From corner a to corner b of a cell at rest, in cells.
Vec3 corner_difference(int a, int b) { return (corner_sides(b) - corner_sides(a)) / 2; }

/// a : C^-1 : b of symmetric tensors, for a cubic C.
double compliance_product(const CubicStiffness& c, const Matrix& a, const Matrix& b) {
  const double apart = 1 / (c.c11 - c.c12);  // on diagonals: C^-1 = apart I - together 1 1^T
  const double together = apart * c.c12 / (c.c11 + 2 * c.c12);
  const double shear = a(0, 1) * b(0, 1) + a(1, 2) * b(1, 2) + a(2, 0) * b(2, 0);
  return apart * a.diagonal().dot(b.diagonal()) - together * a.trace() * b.trace() + shear / c.c44;
}

}  // namespace

StressRecovery::StressRecovery(const Body& body) : body_(body) {
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

StressRecovery::Kind StressRecovery::kind_of(const CellContent& content) const {
  const BodyConfig& config = body_.config();
  constexpr std::array<double, 4> cells_that_share{0, 4, 2, 1};  // by how many axes a spring spans
  Kind kind;
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
        const double stiffness = (axes == 1 ? k.edge : axes == 2 ? k.face : k.body) / cells_that_share[axes];
        const double filled = blend(filled_at(fill, a, b), config.springs_floor(), share);
        if (stiffness * filled != 0) kind.springs.push_back({a, b, stiffness * filled});
      }
    kind.volume += share * k.volume;
    kind.fill += share;
    kind.elastic.c11 += share * c.c11;
    kind.elastic.c12 += share * c.c12;
    kind.elastic.c44 += share * c.c44;
    kind.parts.push_back(number);
  }
  for (double* c : {&kind.elastic.c11, &kind.elastic.c12, &kind.elastic.c44}) *c /= kind.fill;
  std::sort(kind.parts.begin(), kind.parts.end());
  return kind;
}

CellStress StressRecovery::stress(const Field<double>& x) const {
  const double h = body_.config().cell_size;
  CellStress all;
  all.reserve(cells_.size());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const Kind& kind = kinds_[kind_[cell]];
    const std::array<Vec3, 8> corners = corners_of(body_, x, cells_[cell]);
    Matrix sum = Matrix::Zero();
    for (const auto& [a, b, stiffness] : kind.springs) {
      const Vec3 rest = h * corner_difference(a, b);
      const double length = (corners[std::size_t(b)] - corners[std::size_t(a)]).norm();
      sum += stiffness * (1 - rest.norm() / length) * rest * rest.transpose();
    }
    const Matrix gradient = mean_edges(corners) / h;
    const double j = gradient.determinant();
    sum += h * h * h * kind.volume * j * (j - 1) * (gradient.transpose() * gradient).inverse();
    all.emplace_back(sum / (h * h * h * kind.fill));
  }
  return all;
}

CellStress StressRecovery::stress_change(const Field<double>& x, const Field<double>& displacement) const {
  const double h = body_.config().cell_size;
  CellStress all;
  all.reserve(cells_.size());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const Kind& kind = kinds_[kind_[cell]];
    const std::array<Vec3, 8> corners = corners_of(body_, x, cells_[cell]);
    const std::array<Vec3, 8> moves = corners_of(body_, displacement, cells_[cell]);
    Matrix sum = Matrix::Zero();
    for (const auto& [a, b, stiffness] : kind.springs) {
      const Vec3 rest = h * corner_difference(a, b);
      const Vec3 d = corners[std::size_t(b)] - corners[std::size_t(a)];
      const double stretch = d.dot(moves[std::size_t(b)] - moves[std::size_t(a)]) / d.squaredNorm();
      sum += stiffness * rest.norm() / d.norm() * stretch * rest * rest.transpose();
    }
    const Matrix gradient = mean_edges(corners) / h, rate = mean_edges(moves) / h * gradient.inverse();
    const Matrix inverse = gradient.inverse();
    const double j = gradient.determinant();
    sum += h * h * h * kind.volume * j * inverse *
           ((2 * j - 1) * rate.trace() * Matrix::Identity() - (j - 1) * (rate + rate.transpose())) *
           inverse.transpose();
    all.emplace_back(sum / (h * h * h * kind.fill));
  }
  return all;
}

int StressRecovery::neighbour(std::size_t cell, int axis, int step) const {
  const Lattice& lattice = body_.lattice();
  const std::ptrdiff_t site = cells_[cell], in_plane = site % lattice.plane;
  const std::array<std::ptrdiff_t, 3> at{in_plane % lattice.row, in_plane / lattice.row,
                                         site / lattice.plane};
  const std::ptrdiff_t place = at[std::size_t(axis)] + step;
  if (place < 0 || place >= lattice.cells[std::size_t(axis)]) return -1;
  const int other = cell_at_[std::size_t(site + step * lattice.corner(1 << axis))];
  const bool alike = other >= 0 && kinds_[kind_[std::size_t(other)]].parts == kinds_[kind_[cell]].parts;
  return alike ? other : -1;
}

CellStressGradient StressRecovery::gradient(const CellStress& stress) const {
  CellStressGradient all(cells_.size());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    for (int axis = 0; axis < 3; ++axis) {
      Matrix& sum = all[cell][std::size_t(axis)] = Matrix::Zero();
      double weights = 0;
      for (const int step : {-1, 1}) {
        const int other = neighbour(cell, axis, step);
        if (other < 0) continue;
        const double weight = kinds_[kind_[std::size_t(other)]].fill;
        sum += weight * step * (stress[std::size_t(other)] - stress[cell]);
        weights += weight;
      }
      if (weights > 0) sum /= weights * body_.config().cell_size;
    }
  return all;
}

std::vector<double> StressRecovery::error_products(const CellStressGradient& a,
                                                   const CellStressGradient& b) const {
  const double h = body_.config().cell_size, moment = h * h * h * h * h / 12;
  std::vector<double> products(cells_.size());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const Kind& kind = kinds_[kind_[cell]];
    for (std::size_t axis = 0; axis < 3; ++axis)
      products[cell] += kind.fill * moment * compliance_product(kind.elastic, a[cell][axis], b[cell][axis]);
  }
  return products;
}

std::vector<SpringStrain> StressRecovery::spring_strains(const Field<double>& x) const {
  const double h = body_.config().cell_size;
  std::vector<SpringStrain> all;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const std::array<Vec3, 8> corners = corners_of(body_, x, cells_[cell]);
    const Matrix gradient = mean_edges(corners) / h;
    for (const auto& [a, b, stiffness] : kinds_[kind_[cell]].springs) {
      const Vec3 rest = h * corner_difference(a, b);
      const auto strain = [&](const Vec3& d) { return (d.squaredNorm() / rest.squaredNorm() - 1) / 2; };
      all.push_back({strain(corners[std::size_t(b)] - corners[std::size_t(a)]), strain(gradient * rest)});
    }
  }
  return all;
}

std::vector<SpringStrain> StressRecovery::spring_strain_change(const Field<double>& x,
                                                               const Field<double>& displacement) const {
  const double h = body_.config().cell_size;
  std::vector<SpringStrain> all;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    const std::array<Vec3, 8> corners = corners_of(body_, x, cells_[cell]);
    const std::array<Vec3, 8> moves = corners_of(body_, displacement, cells_[cell]);
    const Matrix gradient = mean_edges(corners) / h, change = mean_edges(moves) / h;
    for (const auto& [a, b, stiffness] : kinds_[kind_[cell]].springs) {
      const Vec3 rest = h * corner_difference(a, b), mean = gradient * rest;
      const Vec3 own = corners[std::size_t(b)] - corners[std::size_t(a)];
      all.push_back({own.dot(moves[std::size_t(b)] - moves[std::size_t(a)]) / rest.squaredNorm(),
                     mean.dot(change * rest) / rest.squaredNorm()});
    }
  }
  return all;
}

std::vector<double> StressRecovery::uneven_products(const std::vector<SpringStrain>& a,
                                                    const std::vector<SpringStrain>& b) const {
  const double h = body_.config().cell_size;
  std::vector<double> products(cells_.size());
  std::size_t s = 0;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    for (const auto& spring : kinds_[kind_[cell]].springs) {
      const double squared = h * h * corner_difference(spring.a, spring.b).squaredNorm();
      products[cell] += spring.stiffness * squared * (a[s].own * b[s].own - a[s].mean * b[s].mean);
      ++s;
    }
  return products;
}

double StressRecovery::share_alone() const {
  std::size_t alone = 0;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    for (int axis = 0; axis < 3; ++axis)
      if (neighbour(cell, axis, -1) < 0 && neighbour(cell, axis, 1) < 0) {
        ++alone;
        break;
      }
  return double(alone) / double(cells_.size());
}

bool StressRecovery::has_partial_cells() const {
  constexpr double full = 1 - 1e-5;
  return std::any_of(kinds_.begin(), kinds_.end(), [](const Kind& kind) { return kind.fill < full; });
}

std::vector<std::size_t> doerfler_marking(const std::vector<double>& indicators, double share) {
  std::vector<std::size_t> ids(indicators.size());
  std::iota(ids.begin(), ids.end(), 0);
  std::stable_sort(ids.begin(), ids.end(),
                   [&](std::size_t a, std::size_t b) { return indicators[a] > indicators[b]; });
  const double enough = share * std::accumulate(indicators.begin(), indicators.end(), 0.0);
  double sum = 0;
  std::size_t count = 0;
  while (count < ids.size() && sum < enough) sum += indicators[ids[count++]];
  ids.resize(count);
  return ids;
}

}  // namespace mss
