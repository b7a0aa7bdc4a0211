#include "core/body/spectral_bound.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/forces/fold_guard.hpp"

namespace mss {

namespace {

using Block = Eigen::Matrix3d;

Vec3 corner_vector(int c) { return Vec3(corner_bit(c, 0), corner_bit(c, 1), corner_bit(c, 2)); }

double largest_eigenvalue(const Block& block) {
  return Eigen::SelfAdjointEigenSolver<Block>(block, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

/// Element kinds of the eight sites whose springs and cells can end at a site: they determine its blocks.
using Neighbourhood = std::array<std::uint32_t, 8>;

struct Blocks {
  Block stiffness = Block::Zero();
  Block damping = Block::Zero();
};

/// A site's blocks, summed over the springs and cells at it. kinds[c] belongs to the site that has
/// this one as its cell's corner c.
Blocks blocks_at(const Body& body, const Neighbourhood& kinds, bool guarding) {
  Blocks blocks;
  const double h = body.config().cell_size, at_once = 1 + body.config().relaxation.ratio;
  for (int corner = 0; corner < 8; ++corner) {
    const SiteElements e = body.kinds().elements(kinds[std::size_t(corner)]);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const auto [a, b, kind] = spring_slots[s];
      if (a != corner && b != corner) continue;
      const Vec3 u = (corner_vector(b) - corner_vector(a)).normalized();
      blocks.stiffness += 2 * at_once * e.stiffness[s] * u * u.transpose();
      blocks.damping += 2 * e.damping[s] * u * u.transpose();
    }
    const Vec3 gradient = h * h / 4 * (2 * corner_vector(corner) - Vec3::Ones());
    blocks.stiffness += 8 * std::max(0.0, e.volume) / body.cell_volume() * gradient * gradient.transpose();
    if (guarding) blocks.stiffness += 12 * guarded_corner_stiffness(e.fold_guard, h) * Block::Identity();
  }
  return blocks;
}

SpectralBound bound_of(const Body& body, bool guarding) {
  const Lattice& lattice = body.lattice();
  std::set<std::pair<Neighbourhood, double>> seen;
  double omega_squared = 0, damping = 0;
  for (const std::ptrdiff_t site : body.sites()) {
    Neighbourhood kinds{};
    for (int corner = 0; corner < 8; ++corner) {
      const std::ptrdiff_t lower = site - lattice.corner(corner);
      kinds[std::size_t(corner)] = lower >= 0 ? body.kind(lower) : 0;
    }
    const double mass = body.mass(site);
    if (!seen.insert({kinds, mass}).second) continue;
    const Blocks blocks = blocks_at(body, kinds, guarding);
    omega_squared = std::max(omega_squared, largest_eigenvalue(blocks.stiffness) / mass);
    damping = std::max(damping, largest_eigenvalue(blocks.damping) / mass);
  }
  const Communicator& ranks = body.ranks();
  return {std::sqrt(ranks.largest(omega_squared)), ranks.largest(damping)};
}

}  // namespace

SpectralBound spectral_bound(const Body& body) { return bound_of(body, false); }

SpectralBound guarded_spectral_bound(const Body& body) { return bound_of(body, true); }

SpectralBound with_guard(const SpectralBound& bound, const std::vector<Level>& levels) {
  double most = 0;
  for (const auto& [body, first] : levels)
    most = std::max(
        most, std::pow(guarded_spectral_bound(body).omega, 2) - std::pow(spectral_bound(body).omega, 2));
  return {.omega = std::sqrt(bound.omega * bound.omega + most), .damping = bound.damping};
}

}  // namespace mss
