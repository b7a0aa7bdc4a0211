#include "integrators/linear/rest_level.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace mss {

namespace {

/// Bodies of no more cells along their longest side are not coarsened.
constexpr int coarsest_cells = 3;

/// Lattices of no more are cheap: they are cycled more than once, nearly solved, because the coarsest ones
/// know a ragged body badly.
constexpr int small_cells = 5, cycles_of_small = 3;

constexpr float smoothed_share = 0.25F;  ///< of the spectrum's top is left to the coarser lattices

/// Of the directions in which fine particles around a coarse one are held, those weigh enough to hold it.
constexpr float least_held = 0.1F;

/// Of a particle's stiffness: what is added counts from there on, and up to there, as single precision holds
/// little more beside it.
constexpr float least_added = 1e-4F, most_added = 1e3F;

constexpr int cell_row = int(spring_slots.size()), mass_row = cell_row + 1, weight_rows = mass_row + 1;

/// Of the six numbers of a block: row and column.
constexpr std::array<std::array<int, 2>, 6> block_entries{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};

std::array<int, 3> direction(const SpringSlot& slot) {
  std::array<int, 3> e{};
  for (int axis = 0; axis < 3; ++axis)
    e[std::size_t(axis)] = corner_bit(slot.b, axis) - corner_bit(slot.a, axis);
  return e;
}

Eigen::Matrix3f block_at(const PaddedArrays& blocks, std::ptrdiff_t site) {
  Eigen::Matrix3f block;
  for (int i = 0; i < 6; ++i) {
    const auto [row, column] = block_entries[std::size_t(i)];
    block(row, column) = block(column, row) = blocks[i][site];
  }
  return block;
}

void set_block(PaddedArrays& blocks, std::ptrdiff_t site, const Eigen::Matrix3f& block) {
  for (int i = 0; i < 6; ++i)
    blocks[i][site] = block(block_entries[std::size_t(i)][0], block_entries[std::size_t(i)][1]);
}

SiteConstraint without_constraint(std::ptrdiff_t site) {
  return {site, Eigen::Matrix3f::Zero(), Eigen::Matrix3f::Zero()};
}

int longest(const Body& body) {
  const auto size = body.config().voxels.size();
  return *std::max_element(size.begin(), size.end());
}

/// Calls visit(parent, weight) with the coarse particles that the fine one at a site is interpolated from.
/// `corner`: of the fine lattice in the coarse one [coarse cells].
template <class Visit>
void for_each_parent_of(const Lattice& fine, const Lattice& coarse, const std::array<int, 3>& corner,
                        std::ptrdiff_t site, Visit&& visit) {
  const std::array<int, 3> at = fine.coordinates(site);
  for (int c = 0; c < 8; ++c) {
    float weight = 1;
    std::array<int, 3> parent = corner;
    bool same = true;
    for (int axis = 0; axis < 3; ++axis) {
      const int i = at[std::size_t(axis)], bit = corner_bit(c, axis);
      if (i % 2 == 0 && bit == 1) same = false;
      if (i % 2 == 1) weight /= 2;
      parent[std::size_t(axis)] += (i + bit) / 2;
    }
    if (same) visit(coarse.site(parent[0], parent[1], parent[2]), weight);
  }
}

}  // namespace

PaddedArrays::PaddedArrays(const Lattice& lattice, int count) : count_(count) {
  constexpr std::ptrdiff_t line = 16, page = 1024;
  const auto whole = [](std::ptrdiff_t n) { return (n + line - 1) / line * line; };
  before_ = whole(lattice.plane + lattice.row + 1);
  stride_ = lattice.sites + 2 * before_;
  // Equal low bits of addresses would evict each other from the first-level cache.
  if (stride_ >= page) stride_ = (stride_ + page - 1) / page * page + 3 * line;
  data_ = AlignedArray<float>(count * stride_);
}

RestParticles coarsened(const Body& fine, const RestParticles& of_fine, const Body& coarse,
                        const std::array<int, 3>& corner) {
  RestParticles particles;
  particles.own.assign(std::size_t(coarse.lattice().sites), 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<char>& unknown = particles.unknown[axis];
    unknown.assign(std::size_t(coarse.lattice().sites), 0);
    for (const std::ptrdiff_t site : coarse.sites()) unknown[std::size_t(site)] = 1;
    for (const std::ptrdiff_t site : fine.sites()) {
      const bool follows = !of_fine.follows.empty() && of_fine.follows[std::size_t(site)] != 0;
      if (!follows && of_fine.unknown[axis][std::size_t(site)] == 0)
        for_each_parent_of(fine.lattice(), coarse.lattice(), corner, site,
                           [&](std::ptrdiff_t parent, float) { unknown[std::size_t(parent)] = 0; });
    }
  }
  return particles;
}

RestLevel::RestLevel(const Body& body, RestParticles particles, std::unique_ptr<RestLevel> coarse,
                     const std::array<int, 3>& corner)
    : body_(body),
      particles_(std::move(particles)),
      weights_(body.lattice(), weight_rows),
      inverse_(body.lattice(), 6),
      blocks_(body.lattice(), 6),
      r_(body.lattice(), 3),
      z_(body.lattice(), 3),
      d_(body.lattice(), 3),
      d_next_(body.lattice(), 3),
      pressure_(body.lattice(), 1),
      coarse_(std::move(coarse)),
      corner_(corner) {
  const Lattice& lattice = body.lattice();
  stencil_.row = lattice.row;
  stencil_.plane = lattice.plane;
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    stencil_.spring[s] = weights_[int(s)];
    stencil_.offset[s] = lattice.corner(spring_slots[s].b) - lattice.corner(spring_slots[s].a);
  }
  stencil_.cell = weights_[cell_row];
  stencil_.mass = weights_[mass_row];
  for (int i = 0; i < 6; ++i) stencil_.inverse[i] = inverse_[i];
  if (coarse_) {
    connect_to_larger();
    return;
  }
  if (longest(body) <= coarsest_cells) {
    for (int axis = 0; axis < 3; ++axis)
      for (const std::ptrdiff_t site : body.sites())
        if (particles_.unknown[std::size_t(axis)][std::size_t(site)] != 0) rows_.emplace_back(site, axis);
    return;
  }
  coarse_body_ = std::make_unique<Body>(coarsened(body.config()));
  coarse_ = std::make_unique<RestLevel>(*coarse_body_, coarsened(body, particles_, *coarse_body_, corner_));
  connect(coarse_->lattice());
}

/// Lattices that are refined end where cells of the coarse one do.
void RestLevel::connect_to_larger() {
  const auto [nx, ny, nz] = lattice().cells;
  const Lattice larger(nx / 2, ny / 2, nz / 2);
  to_larger_.emplace(ToLarger{{larger, coarse_->lattice(), corner_}, {larger, 3}, {}});
  connect(larger);
  for (const std::ptrdiff_t site : body_.sites())
    for (int axis = 0; axis < 3; ++axis) {
      if (follows(site) || particles_.unknown[std::size_t(axis)][std::size_t(site)] != 0) continue;
      bool moved = false;
      for_each_parent(site, [&](std::ptrdiff_t parent, float) {
        moved = moved || coarse_->particles_.unknown[std::size_t(axis)][std::size_t(parent)] != 0 ||
                coarse_->follows(parent);
      });
      if (moved) to_larger_->pinned.emplace_back(site, axis);
    }
}

void RestLevel::connect(const Lattice& coarse) {
  for (std::size_t i = 0; i < 3; ++i) {
    transfer_.fine_cells[i] = lattice().cells[i];
    transfer_.coarse_cells[i] = coarse.cells[i];
  }
  transfer_.fine_row = lattice().row;
  transfer_.fine_plane = lattice().plane;
  transfer_.coarse_row = coarse.row;
  transfer_.coarse_plane = coarse.plane;
  scratch_.resize(std::size_t(lattice().sites));
}

template <class Visit>
void RestLevel::for_each_parent(std::ptrdiff_t site, Visit&& visit) const {
  for_each_parent_of(lattice(), coarse_->lattice(), corner_, site, visit);
}

RestLevel::~RestLevel() = default;

Status RestLevel::prepare(const TangentCoefficients& sum) {
  set_weights(sum);
  set_blocks();
  for (const std::ptrdiff_t site : body_.sites())
    set_block(inverse_, site, inverse_block(without_constraint(site)));
  constraints_.clear();
  largest_ = 2 + 6 * largest_cell_share();
  return coarse_ ? coarse_->prepare(sum) : invert();
}

void RestLevel::set_weights(const TangentCoefficients& sum) {
  weights_.clear();
  const double h = body_.config().cell_size;
  std::map<std::uint32_t, std::array<float, weight_rows>> by_kind;
  const auto numbers_of = [&](std::ptrdiff_t site) -> const std::array<float, weight_rows>& {
    const auto [at, is_new] = by_kind.try_emplace(body_.kind(site));
    if (!is_new) return at->second;
    const SiteElements elements = body_.elements_at(site);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const auto e = direction(spring_slots[s]);
      const int squared = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
      at->second[s] =
          float((sum.stiffness * elements.stiffness[s] + sum.damping * elements.damping[s]) / squared);
    }
    at->second[cell_row] = float(sum.stiffness * std::max(elements.volume, 0.0) * h / 16);
    return at->second;
  };
  for (std::ptrdiff_t site = 0; site < lattice().sites; ++site) {
    if (body_.kind(site) == 0) continue;
    const auto& numbers = numbers_of(site);
    for (std::size_t s = 0; s < spring_slots.size(); ++s)
      if (numbers[s] != 0) weights_[int(s)][site + lattice().corner(spring_slots[s].a)] = numbers[s];
    weights_[cell_row][site] = numbers[cell_row];
  }
  for (const std::ptrdiff_t site : body_.sites())
    weights_[mass_row][site] = float(sum.mass * body_.mass(site));
}

void RestLevel::set_blocks() {
  blocks_.clear();
  const std::ptrdiff_t sites = lattice().sites;
  for (int i = 0; i < 6; ++i) {
    float* to = blocks_[i];
    const auto [row, column] = block_entries[std::size_t(i)];
    if (row == column) std::copy_n(weights_[mass_row], sites, to);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const auto e = direction(spring_slots[s]);
      const auto sign = float(e[std::size_t(row)] * e[std::size_t(column)]);
      if (sign == 0) continue;
      const float *ahead = weights_[int(s)], *behind = ahead - stencil_.offset[s];
      for (std::ptrdiff_t site = 0; site < sites; ++site) to[site] += sign * (ahead[site] + behind[site]);
    }
    for (int c = 0; c < 8; ++c) {
      const auto sign = float(corner_sign(c, row) * corner_sign(c, column));
      const float* cell = weights_[cell_row] - lattice().corner(c);
      for (std::ptrdiff_t site = 0; site < sites; ++site) to[site] += sign * cell[site];
    }
  }
}

/// 1 along axes that nothing prescribes, else 0.
Eigen::Vector3f RestLevel::unknown_axes(std::ptrdiff_t site) const {
  const auto& [x, y, z] = particles_.unknown;
  return {float(x[std::size_t(site)]), float(y[std::size_t(site)]), float(z[std::size_t(site)])};
}

/// The inverse of a block within the directions that nothing holds or prescribes.
Eigen::Matrix3f RestLevel::inverse_block(const SiteConstraint& constraint) const {
  const std::ptrdiff_t site = constraint.site;
  const Eigen::Vector3f unknown = unknown_axes(site);
  const Eigen::Matrix3f free = Eigen::Matrix3f::Identity() - constraint.held,
                        p = unknown.asDiagonal() * free * unknown.asDiagonal(),
                        block = block_at(blocks_, site) + constraint.added;
  const float scale = block.trace() / 3;
  if (!(scale > 0)) return Eigen::Matrix3f::Zero();
  const Eigen::Matrix3f whole = p * (block / scale) * p + (Eigen::Matrix3f::Identity() - p);
  return p * whole.inverse() * p / scale;
}

/// A bound on the largest eigenvalue of D^-1 D_cells over all particles: of a 3 x 3 matrix M with real
/// eigenvalues it is at most t/3 + sqrt(2/3 (tr M^2 - t^2/3)), t = tr M (Wolkowicz and Styan, 1980).
float RestLevel::largest_cell_share() const {
  float largest = 0;
  for (const std::ptrdiff_t site : body_.sites()) {
    Eigen::Matrix3f cells = Eigen::Matrix3f::Zero();
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3f s(float(corner_sign(c, 0)), float(corner_sign(c, 1)), float(corner_sign(c, 2)));
      cells += stencil_.cell[site - lattice().corner(c)] * s * s.transpose();
    }
    const Eigen::Matrix3f ratio = block_at(inverse_, site) * cells;
    const float t = ratio.trace(), squared = (ratio.array() * ratio.transpose().array()).sum();
    largest = std::max(largest, t / 3 + std::sqrt(std::max(0.0F, (squared - t * t / 3) * 2 / 3)));
  }
  return largest;
}

/// The coarsest matrix's inverse.
Status RestLevel::invert() {
  const auto n = Eigen::Index(rows_.size());
  for (auto& rows : row_of_) rows.assign(std::size_t(lattice().sites), -1);
  if (n == 0) return Status::ok;
  for (Eigen::Index row = 0; row < n; ++row) {
    const auto [site, axis] = rows_[std::size_t(row)];
    row_of_[std::size_t(axis)][std::size_t(site)] = row;
  }
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  const auto add = [&](std::ptrdiff_t a, int i, std::ptrdiff_t b, int j, double value) {
    const Eigen::Index row = row_of_[std::size_t(i)][std::size_t(a)],
                       column = row_of_[std::size_t(j)][std::size_t(b)];
    if (row >= 0 && column >= 0) matrix(row, column) += value;
  };
  for (std::ptrdiff_t site = 0; site < lattice().sites; ++site) {
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const double w = double(stencil_.spring[s][site]);
      if (w == 0) continue;
      const auto e = direction(spring_slots[s]);
      const std::ptrdiff_t other = site + stencil_.offset[s];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double value = w * e[std::size_t(i)] * e[std::size_t(j)];
          add(site, i, site, j, value);
          add(other, i, other, j, value);
          add(site, i, other, j, -value);
          add(other, i, site, j, -value);
        }
    }
    const double q = double(stencil_.cell[site]);
    if (q != 0)
      for (int c = 0; c < 24; ++c)
        for (int d = 0; d < 24; ++d)
          add(site + lattice().corner(c / 3), c % 3, site + lattice().corner(d / 3), d % 3,
              q * corner_sign(c / 3, c % 3) * corner_sign(d / 3, d % 3));
    for (int i = 0; i < 3; ++i) add(site, i, site, i, double(stencil_.mass[site]));
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  if (factor.info() != Eigen::Success) return Status::not_positive_definite;
  matrix = factor.solve(Eigen::MatrixXd::Identity(n, n));
  padded_rows_ = (n + 15) / 16 * 16;
  inverse_matrix_ = AlignedArray<float>(padded_rows_ * padded_rows_);
  rhs_ = solution_ = AlignedArray<float>(padded_rows_);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      inverse_matrix_[padded_rows_ * j + i] = float((matrix(i, j) + matrix(j, i)) / 2);
  return Status::ok;
}

void RestLevel::solve_directly(const Parallel& parallel) {
  z_.clear();
  if (rows_.empty()) return;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    rhs_[std::ptrdiff_t(i)] = r_[rows_[i].second][rows_[i].first];
  constexpr std::ptrdiff_t rows = 256;
  parallel((padded_rows_ + rows - 1) / rows, [&](std::ptrdiff_t i) {
    fastest_copy<RestKernels>().multiply(inverse_matrix_.data(), padded_rows_, rhs_.data(), solution_.data(),
                                         i * rows, std::min((i + 1) * rows, padded_rows_));
  });
  if (columns_.cols() > 0) {
    Eigen::Map<Eigen::VectorXf> solution(solution_.data(), padded_rows_);
    const Eigen::VectorXf excess = schur_.solve(normals_.transpose() * solution);
    solution -= columns_ * excess;
  }
  for (std::size_t i = 0; i < rows_.size(); ++i)
    z_[rows_[i].second][rows_[i].first] = solution_[std::ptrdiff_t(i)];
}

void RestLevel::constrain(const std::vector<SiteConstraint>& constraints,
                          std::span<const std::vector<SiteConstraint>> of_coarser) {
  for (const SiteConstraint& old : constraints_)
    set_block(inverse_, old.site, inverse_block(without_constraint(old.site)));
  constraints_ = constraints;
  for (SiteConstraint& constraint : constraints_) {
    const float most = most_added * block_at(blocks_, constraint.site).trace(),
                trace = constraint.added.trace();
    if (trace > most) constraint.added *= most / trace;
    set_block(inverse_, constraint.site, inverse_block(constraint));
  }
  if (!coarse_) return factor_constraints();
  std::map<std::ptrdiff_t, SiteConstraint> around;
  for (const SiteConstraint& one : constraints_)
    for_each_parent(one.site, [&](std::ptrdiff_t parent, float weight) {
      SiteConstraint& sum = around.try_emplace(parent, without_constraint(parent)).first->second;
      sum.held += weight * one.held;
      sum.added += weight * one.added;
    });
  for (auto& [site, sum] : around)
    sum.held =
        coarse_->is_own(site) ? Eigen::Matrix3f::Zero().eval() : coarse_->leading_directions(site, sum.held);
  const std::vector<SiteConstraint> none;
  for (const auto& [site, held, added] : of_coarser.empty() ? none : of_coarser.front()) {
    SiteConstraint& sum = around.try_emplace(site, without_constraint(site)).first->second;
    sum.held = held;
    sum.added += added;
  }
  std::vector<SiteConstraint> coarse;
  for (const auto& [site, sum] : around) coarse.push_back(sum);
  coarse_->constrain(coarse, of_coarser.empty() ? of_coarser : of_coarser.subspan(1));
}

/// The projection onto eigenvectors whose eigenvalues are not small beside the largest, of what nothing
/// prescribes.
Eigen::Matrix3f RestLevel::leading_directions(std::ptrdiff_t site, const Eigen::Matrix3f& sum) const {
  const Eigen::Vector3f unknown = unknown_axes(site);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen(unknown.asDiagonal() * sum *
                                                             unknown.asDiagonal());
  Eigen::Matrix3f directions = Eigen::Matrix3f::Zero();
  for (int i = 0; i < 3; ++i)
    if (eigen.eigenvalues()[i] > least_held * eigen.eigenvalues()[2] && eigen.eigenvalues()[2] > 0)
      directions += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).transpose();
  return directions;
}

/// What corrects solutions of the coarsest matrix for constraints: A^-1 - A^-1 N S^-1 N^T A^-1, with S = N^T
/// A^-1 N and compliances on its diagonal.
void RestLevel::factor_constraints() {
  struct Direction {
    std::ptrdiff_t site;
    Eigen::Vector3f along;
    float compliance;
  };
  std::vector<Direction> all;
  for (const auto& [site, held, added] : constraints_) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> of_held(held), of_added(added);
    for (int i = 0; i < 3; ++i) {
      if (of_held.eigenvalues()[i] > 0.5F) all.push_back({site, of_held.eigenvectors().col(i), 0});
      const float stiffness = of_added.eigenvalues()[i];
      if (stiffness > least_added * blocks_[0][site])
        all.push_back({site, of_added.eigenvectors().col(i), 1 / stiffness});
    }
  }
  const auto count = Eigen::Index(all.size());
  normals_.setZero(padded_rows_, count);
  columns_.setZero(padded_rows_, count);
  const Eigen::Map<const Eigen::MatrixXf> inverse(inverse_matrix_.data(), padded_rows_, padded_rows_);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const auto& [site, along, compliance] = all[std::size_t(i)];
      const std::ptrdiff_t row = row_of_[std::size_t(axis)][std::size_t(site)];
      if (row < 0 || along[axis] == 0) continue;
      normals_(row, i) = along[axis];
      columns_.col(i) += along[axis] * inverse.col(row);
    }
  if (count == 0) return;
  Eigen::MatrixXf schur = normals_.transpose() * columns_;
  for (Eigen::Index i = 0; i < count; ++i) schur(i, i) += all[std::size_t(i)].compliance;
  schur_.compute(schur);
}

/// r -= A d for d in d_; with `update` d = keep d + add D^-1 r and z += d too.
void RestLevel::smooth(const Parallel& parallel, float keep, float add, bool update) {
  const RestKernels& kernels = fastest_copy<RestKernels>();
  const float* const d[3] = {d_[0], d_[1], d_[2]};
  for_ranges(parallel, lattice(), [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    kernels.pressure(stencil_, d, pressure_[0], first, last);
  });
  for (const auto& [site, held, added] : constraints_) {
    const Eigen::Vector3f force = added * Eigen::Vector3f(d_[0][site], d_[1][site], d_[2][site]);
    for (int c = 0; c < 3; ++c) r_[c][site] -= force[c];
  }
  RestSmoothing step{.d = {d_[0], d_[1], d_[2]},
                     .pressure = pressure_[0],
                     .r = {r_[0], r_[1], r_[2]},
                     .direction = {},
                     .z = {z_[0], z_[1], z_[2]},
                     .keep = keep,
                     .add = add};
  if (update)
    for (int c = 0; c < 3; ++c) step.direction[c] = d_next_[c];
  for_ranges(parallel, lattice(),
             [&](std::ptrdiff_t first, std::ptrdiff_t last) { kernels.smooth(stencil_, step, first, last); });
  if (update) std::swap(d_, d_next_);
}

void RestLevel::subtract_product(const Parallel& parallel) {
  std::swap(d_, z_);
  smooth(parallel, 0, 0, false);
  std::swap(d_, z_);
}

/// What is left to the coarser lattice.
void RestLevel::restrict_residual(const Parallel& parallel) {
  const RestKernels& kernels = fastest_copy<RestKernels>();
  for (const auto& [site, held, added] : constraints_) {
    const Eigen::Vector3f r(r_[0][site], r_[1][site], r_[2][site]), left = r - held * r;
    for (int c = 0; c < 3; ++c) r_[c][site] = left[c];
  }
  const auto restrict_plane = [&](PaddedArrays& to, int c, std::ptrdiff_t plane) {
    kernels.restrict_plane(transfer_, r_[c], to[c], int(plane), scratch_.data() + lattice().plane * plane);
  };
  if (!to_larger_) {
    for_planes(parallel, coarse_->lattice(), [&](std::ptrdiff_t plane) {
      for (int c = 0; c < 3; ++c) restrict_plane(coarse_->r_, c, plane);
    });
    return;
  }
  const LatticeWindow& window = to_larger_->window;
  PaddedArrays& values = to_larger_->values;
  for (const auto& [site, axis] : to_larger_->pinned) r_[axis][site] = 0;
  for_planes(parallel, window.small(), [&](std::ptrdiff_t plane) {
    for (int c = 0; c < 3; ++c) {
      restrict_plane(values, c, plane);
      window.for_each_row(plane, [&](std::ptrdiff_t first, std::ptrdiff_t in_coarse) {
        const float* from = values[c] + first;
        float* to = coarse_->r_[c] + in_coarse;
        for (std::ptrdiff_t i = 0; i < window.small().row; ++i) to[i] += from[i];
      });
    }
  });
}

/// Its correction, d, is added to z.
void RestLevel::interpolate_correction(const Parallel& parallel) {
  const PaddedArrays* correction = &coarse_->z_;
  if (to_larger_) {
    const LatticeWindow& window = to_larger_->window;
    PaddedArrays& values = to_larger_->values;
    for_planes(parallel, window.small(), [&](std::ptrdiff_t plane) {
      for (int c = 0; c < 3; ++c)
        window.for_each_row(plane, [&](std::ptrdiff_t first, std::ptrdiff_t in_coarse) {
          std::copy_n(coarse_->z_[c] + in_coarse, window.small().row, values[c] + first);
        });
    });
    correction = &values;
  }
  for_planes(parallel, lattice(), [&](std::ptrdiff_t plane) {
    for (int c = 0; c < 3; ++c)
      fastest_copy<RestKernels>().interpolate_plane(transfer_, (*correction)[c], d_[c], z_[c], int(plane),
                                                    scratch_.data() + lattice().plane * plane);
  });
  for (const auto& [site, held, added] : constraints_) {
    const Eigen::Vector3f d(d_[0][site], d_[1][site], d_[2][site]), gone = held * d;
    for (int c = 0; c < 3; ++c) {
      d_[c][site] -= gone[c];
      z_[c][site] -= gone[c];
    }
  }
  if (!to_larger_) return;
  for (const auto& [site, axis] : to_larger_->pinned) {
    z_[axis][site] -= d_[axis][site];
    d_[axis][site] = 0;
  }
}

/// The coarser lattice's correction, d, is added to z.
void RestLevel::correct(const Parallel& parallel, Cycle kind) {
  restrict_residual(parallel);
  coarse_->cycle(parallel, kind);
  interpolate_correction(parallel);
}

void RestLevel::cycle(const Parallel& parallel, Cycle kind) {
  if (!coarse_) return solve_directly(parallel);
  const float upper = largest_, lower = smoothed_share * largest_;
  const float middle = (upper + lower) / 2, radius = (upper - lower) / 2, rho = radius / middle;
  const float next = 1 / (2 * middle / radius - rho), keep = next * rho, add = 2 * next / radius;
  const float* const r[3] = {r_[0], r_[1], r_[2]};
  float* const z[3] = {z_[0], z_[1], z_[2]};
  const bool is_small = longest(body_) <= small_cells && !to_larger_;  // otherwise r is not all that is left
  const int cycles = kind == Cycle::v && is_small ? cycles_of_small : 1;
  for (int i = 0; i < cycles; ++i) {
    if (i > 0) smooth(parallel, 0, 0, false);
    float* const d[3] = {d_[0], d_[1], d_[2]};
    for_ranges(parallel, lattice(), [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      fastest_copy<RestKernels>().start(stencil_, r, 1 / middle, i > 0, d, z, first, last);
    });
    if (kind == Cycle::additive) return correct(parallel, kind);
    smooth(parallel, keep, add, true);
    smooth(parallel, 0, 0, false);
    correct(parallel, kind);
    smooth(parallel, 0, 1 / middle, true);
    smooth(parallel, keep, add, true);
  }
}

}  // namespace mss
