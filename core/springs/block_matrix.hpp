#pragma once

#include <vector>

#include "core/body/body.hpp"
#include "core/environment/environment.hpp"
#include "core/system/system.hpp"

namespace mss {

/// A sparse matrix made of 3 x 3 blocks, one for every pair of particles that share a cell; rows and columns
/// are the unknowns, held coordinates are left out. Stores for every pair the position of its block.
class BlockMatrix {
 public:
  BlockMatrix(const Body& body, const HeldSites& held);
  /// Without unknowns and pattern, for sums, products and diagonal blocks alone.
  explicit BlockMatrix(const Body& body);

  /// By particle, then axis.
  const std::vector<FreeDof>& unknowns() const { return unknowns_; }

  /// With an entry for every number that may not be zero; all are zero.
  const SparseMatrix& pattern() const { return pattern_; }

  /// Begins with `mass` times the mass matrix.
  void begin(double mass);

  /// Adds to the block of two corners of the cell whose lower corner is at a site.
  void add(std::ptrdiff_t site, int row_corner, int column_corner, const Eigen::Matrix3d& block) {
    const std::size_t p = particle(site + body_.lattice().corner(row_corner));
    at(block_[p * neighbours + std::size_t(offset(row_corner, column_corner))]) += block;
  }

  /// Adds to the block of the particle at a site and itself.
  void add_diagonal(std::ptrdiff_t site, const Eigen::Matrix3d& block) {
    at(block_[particle(site) * neighbours + neighbours / 2]) += block;
  }

  /// Adds another of the same body.
  void add(const BlockMatrix& other);

  /// The block of a particle and itself.
  Eigen::Matrix3d diagonal(std::size_t particle) const {
    return at(block_[particle * neighbours + neighbours / 2]);
  }

  /// out = (matrix + mass M) p for all coordinates, held ones included; overwritten. On the system's threads.
  void multiply(System<double>& system, double mass, const Field<double>& p, Field<double>& out) const;

  /// Writes the sums into a matrix of that pattern.
  void write(SparseMatrix& matrix) const;

 private:
  static constexpr std::size_t neighbours = 27;

  /// From one corner of a cell to another, as a number from 0 to 26; 13 is the corner itself.
  static int offset(int from, int to) {
    const auto along = [&](int axis) { return corner_bit(to, axis) - corner_bit(from, axis) + 1; };
    return along(0) + 3 * along(1) + 9 * along(2);
  }
  Eigen::Map<Eigen::Matrix3d> at(int block) {
    return Eigen::Map<Eigen::Matrix3d>(numbers_.data() + 9 * std::size_t(block));
  }
  Eigen::Map<const Eigen::Matrix3d> at(int block) const {
    return Eigen::Map<const Eigen::Matrix3d>(numbers_.data() + 9 * std::size_t(block));
  }
  std::size_t particle(std::ptrdiff_t site) const { return std::size_t(body_.particle(site)); }
  void find_neighbours();
  void build_pattern(const HeldSites& held);

  const Body& body_;
  std::vector<int> block_;        ///< per particle and offset in {-1, 0, 1}^3: index of that block; -1: none
  std::vector<int> column_;       ///< per block: particle of its columns
  std::vector<int> block_start_;  ///< per particle: its first block, and one more
  std::vector<FreeDof> unknowns_;
  SparseMatrix pattern_;
  std::vector<int> source_;      ///< per value of the matrix: its index among the numbers of all blocks
  std::vector<double> numbers_;  ///< of all blocks, nine each, column by column
};

}  // namespace mss
