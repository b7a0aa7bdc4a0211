#include "core/springs/block_matrix.hpp"

#include <algorithm>

namespace mss {

BlockMatrix::BlockMatrix(const Body& body) : body_(body) {
  find_neighbours();
  numbers_.resize(9 * column_.size());
}

BlockMatrix::BlockMatrix(const Body& body, const HeldSites& held) : BlockMatrix(body) { build_pattern(held); }

/// Particles are neighbours if they share a cell, a square of a sheet or a link of a rope. Offsets ascend as
/// sites do, so blocks of a row are sorted.
void BlockMatrix::find_neighbours() {
  const Lattice& lattice = body_.lattice();
  std::vector<bool> meets(body_.particle_count() * neighbours, false);
  body_.for_each_piece([&](std::ptrdiff_t site) {
    for (const int c : body_.corners())
      for (const int d : body_.corners())
        meets[particle(site + lattice.corner(c)) * neighbours + std::size_t(offset(c, d))] = true;
  });
  block_.assign(meets.size(), -1);
  block_start_.assign(1, 0);
  for (std::size_t p = 0; p < body_.particle_count(); ++p) {
    for (std::size_t o = 0; o < neighbours; ++o) {
      if (!meets[p * neighbours + o]) continue;
      const auto i = std::ptrdiff_t(o) % 3 - 1, j = std::ptrdiff_t(o) / 3 % 3 - 1,
                 k = std::ptrdiff_t(o) / 9 - 1;
      block_[p * neighbours + o] = int(column_.size());
      column_.push_back(body_.particle(body_.sites()[p] + i + lattice.row * j + lattice.plane * k));
    }
    block_start_.push_back(int(column_.size()));
  }
}

void BlockMatrix::build_pattern(const HeldSites& held) {
  std::vector<int> unknown_of(3 * body_.particle_count(), -1);
  for (std::size_t p = 0; p < body_.particle_count(); ++p)
    for (int axis = 0; axis < 3; ++axis)
      if (const std::ptrdiff_t site = body_.sites()[p]; !held.holds(site, axis)) {
        unknown_of[3 * p + std::size_t(axis)] = int(unknowns_.size());
        unknowns_.push_back({site, axis});
      }
  std::vector<int> start{0}, inner;
  for (const FreeDof& row : unknowns_) {
    const std::size_t p = particle(row.site);
    for (int b = block_start_[p]; b < block_start_[p + 1]; ++b)
      for (int axis = 0; axis < 3; ++axis) {
        const int column = unknown_of[3 * std::size_t(column_[std::size_t(b)]) + std::size_t(axis)];
        if (column < 0) continue;
        inner.push_back(column);
        source_.push_back(9 * b + row.axis + 3 * axis);
      }
    start.push_back(int(inner.size()));
  }
  const auto size = Eigen::Index(unknowns_.size());
  const std::vector<double> zeros(inner.size(), 0.0);
  pattern_ = Eigen::Map<const SparseMatrix>(size, size, Eigen::Index(inner.size()), start.data(),
                                            inner.data(), zeros.data());
}

void BlockMatrix::begin(double mass) {
  std::fill(numbers_.begin(), numbers_.end(), 0.0);
  for (std::size_t p = 0; p < body_.particle_count(); ++p) {
    const int diagonal = block_[p * neighbours + neighbours / 2];
    at(diagonal).diagonal().array() = mass * body_.mass(body_.sites()[p]);
  }
}

void BlockMatrix::add(const BlockMatrix& other) {
  for (std::size_t i = 0; i < numbers_.size(); ++i) numbers_[i] += other.numbers_[i];
}

void BlockMatrix::multiply(System<double>& system, double mass, const Field<double>& p,
                           Field<double>& out) const {
  out.array() = 0;
  for_each_particle(system, [&](std::ptrdiff_t site) {
    const std::size_t row = particle(site);
    Vec3 sum = mass * body_.mass(site) * p.at(site);
    for (int b = block_start_[row]; b < block_start_[row + 1]; ++b)
      sum += at(b) * p.at(body_.sites()[std::size_t(column_[std::size_t(b)])]);
    out.set(site, sum);
  });
}

void BlockMatrix::write(SparseMatrix& matrix) const {
  for (std::size_t i = 0; i < source_.size(); ++i) matrix.valuePtr()[i] = numbers_[std::size_t(source_[i])];
}

}  // namespace mss
