#include "integrators/linear/rest_cycle.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <iterator>
#include <numeric>

#include "core/base/error.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

const SolidSystem<double>& solid_of(System<double>& system, const std::string& user) {
  const SolidSystem<double>* solid = system.solid();
  if (!solid)
    throw InputError(fmt::format(
        "nonlinear_solver \"{}\" needs a body of cells, which this model is not; \"newton\" takes any model",
        user));
  return *solid;
}

std::array<double*, 3> axes_of(Field<double>& field, std::ptrdiff_t first) {
  return {field.axis(0) + first, field.axis(1) + first, field.axis(2) + first};
}
std::array<const double*, 3> axes_of(const Field<double>& field, std::ptrdiff_t first) {
  return {field.axis(0) + first, field.axis(1) + first, field.axis(2) + first};
}

/// Cells of a refined body that have been split so often, and what is smaller merged to such.
struct CellsOfSize {
  const Body* body = nullptr;
  RefinementMap::Cell corner{};  ///< of its lattice, in its cells
  RestParticles particles{};
};

RestParticles no_particles(const Body& body) {
  const std::vector<char> none(std::size_t(body.lattice().sites), 0);
  return {.unknown = {none, none, none}, .own = none, .follows = none};
}

/// Where a lattice begins in that of cells twice as large [its cells].
std::array<int, 3> corner_in(const CellsOfSize& cells, const CellsOfSize& larger) {
  std::array<int, 3> corner{};
  for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] = cells.corner[axis] / 2 - larger.corner[axis];
  return corner;
}

/// Where a level of the body begins in the lattice in which smaller cells are merged.
std::array<int, 3> corner_of(const RefinedBody& refined, std::size_t level, const CellsOfSize& cells) {
  std::array<int, 3> corner = refined.cell(level, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] -= cells.corner[axis];
  return corner;
}

/// Marks what particles of a level are.
void mark_own(const RefinedBody& refined, std::size_t level, const Field<double>& unknown,
              CellsOfSize& cells) {
  const auto& [body, first] = refined.levels()[level];
  const LatticeWindow window(body.lattice(), cells.body->lattice(), corner_of(refined, level, cells));
  auto& [unknown_axes, own, follows] = cells.particles;
  for (const std::ptrdiff_t site : body.sites()) {
    const auto at = std::size_t(window(site));
    own[at] = refined.mass(first + site) > 0;
    follows[at] = !own[at];
    for (int axis = 0; axis < 3; ++axis)
      unknown_axes[std::size_t(axis)][at] = unknown.axis(axis)[first + site] != 0;
  }
}

/// Of the largest stiffness at a particle: what mass must be for rigid motions not to drown the rest in
/// single precision. Searches for an equilibrium have less.
constexpr double least_mass = 1e-6;

}  // namespace

RestCycle::TurnedLattice::TurnedLattice(const Level& of_body, RestLevel& of_cycle, std::size_t depth_of_level,
                                        const std::array<int, 3>& corner)
    : body(of_body.body),
      first(of_body.first),
      level(of_cycle),
      depth(depth_of_level),
      window(body.lattice(), level.lattice(), corner),
      positions(body.lattice(), 3),
      rotations(body.lattice(), 9),
      turning(body.lattice(), 7),
      vectors(window.is_whole() ? PaddedArrays() : PaddedArrays(body.lattice(), 3)) {}

Eigen::Matrix3d RestCycle::TurnedLattice::rotation(std::ptrdiff_t site) const {
  Eigen::Matrix3d q;
  for (int i = 0; i < 9; ++i) q(i / 3, i % 3) = double(rotations[i][site]);
  return q;
}

RestCycle::RestCycle(System<double>& system, const std::string& user, Cycle kind)
    : system_(system),
      solid_(solid_of(system, user)),
      parallel_([&system](std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
        system.parallel(count, task);
      }),
      kind_(kind) {
  if (const BodyConfig& body = solid_.levels().front().body.config(); !body.is_solid())
    throw InputError(fmt::format("{} turns cells of three dimensions, and this body is {}; choose \"newton\"",
                                 user, body.noun()));
  Field<double> unknown(system.size());
  for (const auto [site, axis] : unknowns_of(system)) unknown.axis(axis)[site] = 1;
  build(unknown);
  for (TurnedLattice& lattice : lattices_) find_edges(lattice, unknown);
  find_pieces(unknown);
  set_rotations();
}

void RestCycle::build(const Field<double>& unknown) {
  if (const RefinedBody* refined = solid_.refined_body()) return build_refined(*refined, unknown);
  const Level& level = solid_.levels().front();
  const auto sites = std::size_t(level.body.lattice().sites);
  RestParticles particles{.own = std::vector<char>(sites, 1)};
  for (int axis = 0; axis < 3; ++axis)
    particles.unknown[std::size_t(axis)].assign(unknown.axis(axis), unknown.axis(axis) + sites);
  finest_ = std::make_unique<RestLevel>(level.body, std::move(particles));
  lattices_.emplace_back(level, *finest_, 0, std::array<int, 3>{});
}

/// From the smallest cells on, as holds spread to larger ones; then lattices are put upon each other.
void RestCycle::build_refined(const RefinedBody& refined, const Field<double>& unknown) {
  const auto deepest = std::size_t(refined.map().depth());
  std::vector<CellsOfSize> sizes(deepest + 1);
  for (std::size_t depth = deepest + 1; depth-- > 0;) {
    CellsOfSize& cells = sizes[depth];
    MergedCells merged = merged_cells(refined, int(depth));
    cells.corner = merged.corner;
    cells.body = merged_.emplace_back(std::make_unique<const Body>(merged.config)).get();
    if (depth == deepest)
      cells.particles = no_particles(*cells.body);
    else
      cells.particles = coarsened(*sizes[depth + 1].body, sizes[depth + 1].particles, *cells.body,
                                  corner_in(sizes[depth + 1], cells));
    cells.particles.follows.assign(std::size_t(cells.body->lattice().sites), 0);
    for (std::size_t level = 0; level < refined.levels().size(); ++level)
      if (std::size_t(refined.depth(level)) == depth) mark_own(refined, level, unknown, cells);
  }
  lattices_.reserve(refined.levels().size());
  for (std::size_t depth = 0; depth <= deepest; ++depth) {
    CellsOfSize& cells = sizes[depth];
    const std::array<int, 3> corner = depth > 0 ? corner_in(cells, sizes[depth - 1]) : std::array<int, 3>{};
    finest_ =
        std::make_unique<RestLevel>(*cells.body, std::move(cells.particles), std::move(finest_), corner);
    bool whole = false;
    for (std::size_t level = 0; level < refined.levels().size(); ++level) {
      if (std::size_t(refined.depth(level)) != depth) continue;
      lattices_.emplace_back(refined.levels()[level], *finest_, deepest - depth,
                             corner_of(refined, level, cells));
      whole = lattices_.back().window.is_whole();
    }
    if (!whole) partly_filled_.push_back(finest_.get());
  }
}

/// Shares of a particle's edges; prescribed axes do not turn.
void RestCycle::find_edges(TurnedLattice& of, const Field<double>& unknown) const {
  const Lattice& lattice = of.body.lattice();
  of.body.for_each_cell([&](std::ptrdiff_t site) {
    for (int c = 0; c < 8; ++c)
      for (int axis = 0; axis < 3; ++axis)
        of.turning[2 * axis + corner_bit(c, axis)][site + lattice.corner(c)] = 1;
  });
  for (const std::ptrdiff_t site : of.body.sites()) {
    const bool moves = system_.mass(of.first + site) > 0;  // or it hangs on others
    const bool is_free = moves && unknown.at(of.first + site) == Vec3::Ones();
    for (int axis = 0; axis < 3; ++axis) {
      float &ahead = of.turning[2 * axis][site], &behind = of.turning[2 * axis + 1][site];
      const float share = is_free ? 1 / (ahead + behind) : 0;
      ahead *= share;
      behind *= share;
    }
    of.turning[6][site] = moves ? 1 : 0;
  }
}

void RestCycle::find_pieces(const Field<double>& unknown) {
  constexpr std::size_t portion = 1024;
  std::vector<std::ptrdiff_t> other(std::size_t(system_.size()));  // of the same piece, and no later
  std::iota(other.begin(), other.end(), 0);
  const auto first_of = [&](std::ptrdiff_t p) {
    while (other[std::size_t(p)] != p) p = other[std::size_t(p)] = other[std::size_t(other[std::size_t(p)])];
    return p;
  };
  const auto join = [&](std::ptrdiff_t a, std::ptrdiff_t b) {
    const std::ptrdiff_t one = first_of(a), two = first_of(b);
    other[std::size_t(std::max(one, two))] = std::min(one, two);
  };
  for (const auto& [body, first] : solid_.levels())
    body.for_each_spring([&, begin = first](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double,
                                            double) { join(begin + a, begin + b); });
  if (const RefinedBody* refined = solid_.refined_body())
    for (const HangingParticle& p : refined->hanging())
      for (std::size_t m = 0; m < p.count; ++m)
        join(refined->site_in_field(p.level, p.site), refined->site_in_field(p.level - 1, p.masters[m]));
  piece_of_.assign(other.size(), -1);
  std::vector<std::vector<std::ptrdiff_t>> sites;
  for (const std::ptrdiff_t site : system_.particles()) {
    const std::ptrdiff_t first = first_of(site);
    if (first == site) {
      piece_of_[std::size_t(site)] = int(pieces_.size());
      pieces_.emplace_back();
      sites.emplace_back();
    }
    const auto piece = std::size_t(piece_of_[std::size_t(site)] = piece_of_[std::size_t(first)]);
    sites[piece].push_back(site);
    pieces_[piece].mass += system_.mass(site);
    pieces_[piece].free *= unknown.at(site).array();
  }
  for (std::size_t piece = 0; piece < sites.size(); ++piece) {
    const std::size_t end = sites_.size() + sites[piece].size();
    for (std::size_t first = sites_.size(); first < end; first += portion)
      portions_.push_back({piece, first, std::min(first + portion, end)});
    sites_.insert(sites_.end(), sites[piece].begin(), sites[piece].end());
  }
  for (const std::ptrdiff_t site : sites_) masses_.push_back(system_.mass(site));
}

bool RestCycle::any_piece_keeps() const {
  return std::any_of(pieces_.begin(), pieces_.end(),
                     [](const Piece& piece) { return !piece.keeps(Vec3::Ones()).isZero(); });
}

RestCycle::~RestCycle() = default;

Status RestCycle::prepare(const TangentCoefficients& sum) {
  TangentCoefficients enough = sum;
  sum_ = sum;
  sum_.kind = Tangent::projected;
  double stiffest = 0;  // a particle in the middle of its springs, over its mass
  const Body& smallest = solid_.levels().back().body;
  for (const Part& part : smallest.parts()) {
    const SpringConstants& k = part.springs;
    stiffest = std::max(
        stiffest, (2 * k.edge + 4 * k.face + 8.0 / 3 * k.body) / (part.density * smallest.cell_volume()));
  }
  enough.mass = std::max(sum.mass, least_mass * sum.stiffness * stiffest);
  return finest_->prepare(enough);
}

/// None: everything stands as at rest.
void RestCycle::set_rotations() {
  for (TurnedLattice& lattice : lattices_) {
    const std::ptrdiff_t sites = lattice.body.lattice().sites;
    for (int i = 0; i < 9; ++i) std::fill_n(lattice.rotations[i], sites, 0.0F);
    for (const int i : {0, 4, 8}) std::copy_n(lattice.turning[6], sites, lattice.rotations[i]);
  }
}

void RestCycle::place(const Field<double>& x) {
  const RestKernels& kernels = fastest_copy<RestKernels>();
  for (TurnedLattice& of : lattices_) {
    const Lattice& lattice = of.body.lattice();
    const std::array<const double*, 3> from = axes_of(x, of.first);
    const Vec3 middle = x.at(of.first + of.body.sites()[of.body.sites().size() / 2]);
    float* const positions[3] = {of.positions[0], of.positions[1], of.positions[2]};
    const float* shares[6];
    float* rotations[9];
    for (int i = 0; i < 6; ++i) shares[i] = of.turning[i];
    for (int i = 0; i < 9; ++i) rotations[i] = of.rotations[i];
    for_ranges(parallel_, lattice, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      kernels.scale_positions(from.data(), middle.data(), 1 / of.body.config().cell_size, positions, first,
                              last);
    });
    RestStencil steps{};
    steps.row = lattice.row;
    steps.plane = lattice.plane;
    for_ranges(parallel_, lattice, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      kernels.rotations(steps, positions, shares, of.turning[6], rotations, first, last);
    });
  }
  if (!held_.empty()) hold_in_lattice();
}

void RestCycle::place_stiffly(const Field<double>& x) {
  std::vector<Vec3> at(pieces_.size(), Vec3::Zero()), at_rest = at;
  std::vector<Eigen::Matrix3d> turned(pieces_.size(), Eigen::Matrix3d::Zero());
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p) {
      at[piece] += masses_[p] / pieces_[piece].mass * x.at(sites_[p]);
      at_rest[piece] += masses_[p] / pieces_[piece].mass * solid_.rest_position(sites_[p]);
    }
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p)
      turned[piece] += masses_[p] * (x.at(sites_[p]) - at[piece]) *
                       (solid_.rest_position(sites_[p]) - at_rest[piece]).transpose();
  for (Eigen::Matrix3d& matrix : turned) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    matrix = u * svd.matrixV().transpose();
  }
  set_rotations();
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p) {
      TurnedLattice& lattice = lattice_of(sites_[p]);
      const std::ptrdiff_t site = sites_[p] - lattice.first;
      if (lattice.turning[0][site] + lattice.turning[1][site] == 0) continue;
      for (int i = 0; i < 9; ++i) lattice.rotations[i][site] = float(turned[piece](i / 3, i % 3));
    }
  if (!held_.empty()) hold_in_lattice();
}

void RestCycle::hold(std::vector<HeldParticle> held) {
  held_ = std::move(held);
  for (Piece& piece : pieces_) piece.unheld = Eigen::Array3d::Ones();
  for (const auto& [site, directions, friction] : held_) {
    Piece& piece = pieces_[std::size_t(piece_of_[std::size_t(site)])];
    piece.unheld = ((directions + friction).diagonal().array() > 0).select(0, piece.unheld);
  }
  hold_in_lattice();
}

RestCycle::TurnedLattice& RestCycle::lattice_of(std::ptrdiff_t site_in_field) {
  return *std::prev(std::upper_bound(
      lattices_.begin(), lattices_.end(), site_in_field,
      [](std::ptrdiff_t site, const TurnedLattice& lattice) { return site < lattice.first; }));
}

/// Held directions as they lie in the body at rest.
void RestCycle::hold_in_lattice() {
  std::vector<std::vector<SiteConstraint>> constraints(1 + lattices_.front().depth);
  for (const auto& [site_in_field, directions, friction] : held_) {
    const TurnedLattice& lattice = lattice_of(site_in_field);
    const std::ptrdiff_t site = site_in_field - lattice.first;
    const Eigen::Matrix3f q = lattice.rotation(site).cast<float>();
    constraints[lattice.depth].push_back({lattice.window(site), q.transpose() * directions.cast<float>() * q,
                                          q.transpose() * friction.cast<float>() * q});
  }
  finest_->constrain(constraints.front(), std::span(constraints).subspan(1));
}

/// Calls part(piece, site, mass) for every particle, on all threads.
template <class Part>
void RestCycle::for_each_of_pieces(Part&& part) const {
  parallel_(std::ptrdiff_t(portions_.size()), [&](std::ptrdiff_t i) {
    const auto& [piece, first, last] = portions_[std::size_t(i)];
    for (std::size_t p = first; p < last; ++p) part(piece, sites_[p], masses_[p]);
  });
}

/// The sum over a piece's particles of part(site, mass), over its mass, along what it keeps: the same for any
/// number of threads.
template <class Part>
std::vector<Vec3> RestCycle::means(Part&& part) const {
  std::vector<Vec3> sums(portions_.size()), of_pieces(pieces_.size(), Vec3::Zero());
  parallel_(std::ptrdiff_t(portions_.size()), [&](std::ptrdiff_t i) {
    const auto& [piece, first, last] = portions_[std::size_t(i)];
    Vec3 sum = Vec3::Zero();
    for (std::size_t p = first; p < last; ++p) sum += part(sites_[p], masses_[p]);
    sums[std::size_t(i)] = sum;
  });
  for (std::size_t i = 0; i < portions_.size(); ++i) of_pieces[portions_[i].piece] += sums[i];
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    of_pieces[i] = pieces_[i].keeps(of_pieces[i] / pieces_[i].mass);
  return of_pieces;
}

void RestCycle::add_where_free(const Vec3& change, Field<double>& v) {
  if (change.isZero() || !any_piece_keeps()) return;
  for_each_of_pieces([&](std::size_t piece, std::ptrdiff_t site, double) {
    v.set(site, v.at(site) + pieces_[piece].keeps(change));
  });
}

void RestCycle::bend_paths(const Field<double>& x, double seconds, Field<double>& v) {
  const auto is_free = [](const Piece& piece) { return piece.keeps(Vec3::Ones()) == Vec3::Ones(); };
  if (std::none_of(pieces_.begin(), pieces_.end(), is_free)) return;
  const std::vector<Vec3> centres = means(
                              [&](std::ptrdiff_t site, double mass) { return Vec3(mass * x.at(site)); }),
                          velocities = means(
                              [&](std::ptrdiff_t site, double mass) { return Vec3(mass * v.at(site)); });
  struct Spin {
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Vec3 momentum = Vec3::Zero();
  };
  std::vector<Spin> of_portions(portions_.size()), spins(pieces_.size());
  parallel_(std::ptrdiff_t(portions_.size()), [&](std::ptrdiff_t i) {
    const auto& [piece, first, last] = portions_[std::size_t(i)];
    Spin& spin = of_portions[std::size_t(i)];
    for (std::size_t p = first; p < last; ++p) {
      const Vec3 arm = x.at(sites_[p]) - centres[piece];
      spin.inertia += masses_[p] * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
      spin.momentum += masses_[p] * arm.cross(v.at(sites_[p]) - velocities[piece]);
    }
  });
  for (std::size_t i = 0; i < portions_.size(); ++i) {
    spins[portions_[i].piece].inertia += of_portions[i].inertia;
    spins[portions_[i].piece].momentum += of_portions[i].momentum;
  }
  std::vector<Eigen::Matrix3d> bends(pieces_.size(), Eigen::Matrix3d::Zero());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (!is_free(pieces_[i])) continue;
    const Vec3 turn = seconds * spins[i].inertia.completeOrthogonalDecomposition().solve(spins[i].momentum);
    const double angle = turn.norm();
    if (!(angle > 0)) continue;
    const Eigen::Matrix3d end = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    Eigen::Matrix3d straight;
    straight << 1, -turn[2], turn[1], turn[2], 1, -turn[0], -turn[1], turn[0], 1;
    bends[i] = (end - straight) / seconds;
  }
  for_each_of_pieces([&](std::size_t piece, std::ptrdiff_t site, double) {
    v.set(site, v.at(site) + bends[piece] * (x.at(site) - centres[piece]));
  });
}

/// out = Q^T r / norm
void RestCycle::turn_back(const TurnedLattice& lattice, const Field<double>& r, double norm,
                          PaddedArrays& out) const {
  const float* q[9];
  for (int i = 0; i < 9; ++i) q[i] = lattice.rotations[i];
  const std::array<const double*, 3> from = axes_of(r, lattice.first);
  float* const to[3] = {out[0], out[1], out[2]};
  for_ranges(parallel_, lattice.body.lattice(), [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    fastest_copy<RestKernels>().turn_back(q, from.data(), 1 / norm, to, first, last);
  });
}

/// The same, to where the cycle begins.
void RestCycle::turn_back(const Field<double>& r, double norm) {
  for (RestLevel* level : partly_filled_) level->r().clear();
  for (TurnedLattice& lattice : lattices_) {
    const LatticeWindow& window = lattice.window;
    turn_back(lattice, r, norm, window.is_whole() ? lattice.level.r() : lattice.vectors);
    if (window.is_whole()) continue;
    for_planes(parallel_, window.small(), [&](std::ptrdiff_t plane) {
      window.for_each_row(plane, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        for (int c = 0; c < 3; ++c)
          std::copy_n(lattice.vectors[c] + from, window.small().row, lattice.level.r()[c] + to);
      });
    });
  }
}

/// z = norm Q times what the cycle has found.
void RestCycle::turn(double norm, Field<double>& z) {
  for (TurnedLattice& lattice : lattices_) {
    const LatticeWindow& window = lattice.window;
    if (!window.is_whole())
      for_planes(parallel_, window.small(), [&](std::ptrdiff_t plane) {
        window.for_each_row(plane, [&](std::ptrdiff_t to, std::ptrdiff_t from) {
          for (int c = 0; c < 3; ++c)
            std::copy_n(lattice.level.z()[c] + from, window.small().row, lattice.vectors[c] + to);
        });
      });
    PaddedArrays& found = window.is_whole() ? lattice.level.z() : lattice.vectors;
    const float* q[9];
    for (int i = 0; i < 9; ++i) q[i] = lattice.rotations[i];
    const float* const from[3] = {found[0], found[1], found[2]};
    const std::array<double*, 3> to = axes_of(z, lattice.first);
    for_ranges(parallel_, lattice.body.lattice(), [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      fastest_copy<RestKernels>().turn(q, from, norm, to.data(), first, last);
    });
  }
}

/// Takes from r what `values` makes of the rest. By the system's tangent: where cells of two sizes meet no
/// lattice of the cycle has it.
void RestCycle::subtract_forces_of(const Field<double>& values, Field<double>& r) {
  Field<double> turned(values.size()), forces(values.size());
  const auto for_each_rotation = [&](auto&& visit) {
    for (const TurnedLattice& lattice : lattices_)
      for (const std::ptrdiff_t site : lattice.body.sites())
        visit(lattice.first + site, lattice.rotation(site));
  };
  for_each_rotation([&](std::ptrdiff_t site, const Eigen::Matrix3d& q) {
    turned.set(site, q.transpose() * values.at(site));
  });
  const State<double> rest = solid_.undeformed_state();
  tangents_of(system_).product(0, rest.x, rest.v, sum_, turned, forces);
  for_each_rotation(
      [&](std::ptrdiff_t site, const Eigen::Matrix3d& q) { r.set(site, r.at(site) - q * forces.at(site)); });
  system_.clear_prescribed(r);
}

void RestCycle::take_held(const Field<double>& values, Field<double>& z) const {
  for (const auto& [site, directions, friction] : held_) {
    const Vec3 value = z.at(site);
    z.set(site, value - directions * value);
  }
  if (values.size() > 0) z.array() += values.array();
}

void RestCycle::solve(const Field<double>& r, double norm, const Field<double>& values, Field<double>& z) {
  const bool keeps = any_piece_keeps(), gives_way = values.size() > 0, in_field = lattices_.size() > 1;
  std::vector<Vec3> momenta;
  if (keeps || (gives_way && in_field)) r_ = r;
  if (keeps) {
    momenta = means([&](std::ptrdiff_t site, double) { return r.at(site); });
    for_each_of_pieces([&](std::size_t piece, std::ptrdiff_t site, double mass) {
      r_.set(site, r.at(site) - mass * momenta[piece]);
    });
  }
  if (gives_way) norm = std::max(norm, values.array().abs().maxCoeff());
  if (!(norm > 0)) norm = 1;
  if (gives_way && in_field) subtract_forces_of(values, r_);
  turn_back(keeps || (gives_way && in_field) ? r_ : r, norm);
  if (gives_way && !in_field) {
    turn_back(lattices_.front(), values, norm, finest_->z());
    finest_->subtract_product(parallel_);
  }
  finest_->cycle(parallel_, kind_);
  turn(norm, z);
  if (!held_.empty()) take_held(values, z);
  if (!keeps) return;
  std::vector<Vec3> changes =
      means([&](std::ptrdiff_t site, double mass) { return Vec3(mass * z.at(site)); });
  for (std::size_t i = 0; i < changes.size(); ++i) changes[i] = momenta[i] - changes[i];
  for_each_of_pieces(
      [&](std::size_t piece, std::ptrdiff_t site, double) { z.set(site, z.at(site) + changes[piece]); });
}

}  // namespace mss
