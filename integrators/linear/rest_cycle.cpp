#include "integrators/linear/rest_cycle.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <numeric>

#include "core/base/error.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

const Body& body_of(System<double>& system, const std::string& user) {
  const BodySystem<double>* cells = system.cells();
  if (!cells)
    throw InputError(fmt::format(
        "nonlinear_solver \"{}\" needs a body of cells of one size, which this model is not; \"newton\" "
        "takes any model",
        user));
  return cells->body();
}

/// Where the first `count` arrays begin.
template <std::size_t count>
std::array<float*, count> beginnings(PaddedArrays& arrays) {
  std::array<float*, count> all;
  for (std::size_t i = 0; i < count; ++i) all[i] = arrays[int(i)];
  return all;
}

/// Where the coordinates of a field begin.
std::array<const double*, 3> axes_of(const Field<double>& field) {
  return {field.axis(0), field.axis(1), field.axis(2)};
}

/// Of the largest stiffness at a particle: what mass must be for rigid motions not to drown the rest in
/// single precision. Searches for an equilibrium have less.
constexpr double least_mass = 1e-6;

}  // namespace

RestCycle::RestCycle(System<double>& system, const std::string& user, Cycle kind)
    : system_(system),
      body_(body_of(system, user)),
      parallel_([&system](std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
        system.parallel(count, task);
      }),
      kind_(kind),
      positions_(body_.lattice(), 3),
      rotations_(body_.lattice(), 9),
      turning_(body_.lattice(), 7) {
  std::array<std::vector<char>, 3> unknown;
  for (auto& axis : unknown) axis.assign(std::size_t(body_.lattice().sites), 0);
  for (const auto [site, axis] : unknowns_of(system)) unknown[std::size_t(axis)][std::size_t(site)] = 1;
  find_edges(unknown);
  find_pieces(unknown);
  finest_ = std::make_unique<RestLevel>(body_, unknown);
  set_rotations();
}

void RestCycle::find_edges(const std::array<std::vector<char>, 3>& unknown) {
  const Lattice& lattice = body_.lattice();
  body_.for_each_cell([&](std::ptrdiff_t site) {
    for (int c = 0; c < 8; ++c)
      for (int axis = 0; axis < 3; ++axis)
        turning_[2 * axis + corner_bit(c, axis)][site + lattice.corner(c)] = 1;
  });
  for (const std::ptrdiff_t site : body_.sites()) {
    const bool is_free = std::all_of(unknown.begin(), unknown.end(),
                                     [&](const auto& axis) { return axis[std::size_t(site)] != 0; });
    for (int axis = 0; axis < 3; ++axis) {
      float &ahead = turning_[2 * axis][site], &behind = turning_[2 * axis + 1][site];
      const float share = is_free ? 1 / (ahead + behind) : 0;  // prescribed axes do not turn
      ahead *= share;
      behind *= share;
    }
    turning_[6][site] = 1;
  }
}

void RestCycle::find_pieces(const std::array<std::vector<char>, 3>& unknown) {
  constexpr std::size_t portion = 1024;
  std::vector<int> other(body_.particle_count());  // a particle of the same piece that comes no later
  std::iota(other.begin(), other.end(), 0);
  const auto first_of = [&](int p) {
    while (other[std::size_t(p)] != p) p = other[std::size_t(p)] = other[std::size_t(other[std::size_t(p)])];
    return p;
  };
  body_.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double, double) {
    const int one = first_of(body_.particle(a)), two = first_of(body_.particle(b));
    other[std::size_t(std::max(one, two))] = std::min(one, two);
  });
  piece_of_.resize(other.size());
  std::vector<std::vector<std::ptrdiff_t>> sites;
  for (std::size_t p = 0; p < other.size(); ++p) {
    const auto first = std::size_t(first_of(int(p)));
    if (first == p) {
      piece_of_[p] = int(pieces_.size());
      pieces_.emplace_back();
      sites.emplace_back();
    }
    const auto piece = std::size_t(piece_of_[p] = piece_of_[first]);
    const std::ptrdiff_t site = body_.sites()[p];
    sites[piece].push_back(site);
    pieces_[piece].mass += body_.mass(site);
    for (int axis = 0; axis < 3; ++axis)
      if (unknown[std::size_t(axis)][std::size_t(site)] == 0) pieces_[piece].free[axis] = 0;
  }
  for (std::size_t piece = 0; piece < sites.size(); ++piece) {
    const std::size_t end = sites_.size() + sites[piece].size();
    for (std::size_t first = sites_.size(); first < end; first += portion)
      portions_.push_back({piece, first, std::min(first + portion, end)});
    sites_.insert(sites_.end(), sites[piece].begin(), sites[piece].end());
  }
  for (const std::ptrdiff_t site : sites_) masses_.push_back(body_.mass(site));
}

bool RestCycle::any_piece_keeps() const {
  return std::any_of(pieces_.begin(), pieces_.end(),
                     [](const Piece& piece) { return !piece.keeps(Vec3::Ones()).isZero(); });
}

RestCycle::~RestCycle() = default;

Status RestCycle::prepare(const TangentCoefficients& sum) {
  TangentCoefficients enough = sum;
  double stiffest = 0;  // a particle in the middle of its springs, over its mass
  for (const Part& part : body_.parts()) {
    const SpringConstants& k = part.springs;
    stiffest = std::max(stiffest,
                        (2 * k.edge + 4 * k.face + 8.0 / 3 * k.body) / (part.density * body_.cell_volume()));
  }
  enough.mass = std::max(sum.mass, least_mass * sum.stiffness * stiffest);
  return finest_->prepare(enough);
}

/// None: everything stands as at rest.
void RestCycle::set_rotations() {
  for (int i = 0; i < 9; ++i) std::fill_n(rotations_[i], body_.lattice().sites, 0.0F);
  for (const int i : {0, 4, 8}) std::copy_n(turning_[6], body_.lattice().sites, rotations_[i]);
}

void RestCycle::place(const Field<double>& x) {
  const RestKernels& kernels = fastest_copy<RestKernels>();
  const Vec3 middle = x.at(body_.sites()[body_.sites().size() / 2]);
  const auto from = axes_of(x);
  const auto positions = beginnings<3>(positions_);
  const auto shares = beginnings<6>(turning_);
  const auto rotations = beginnings<9>(rotations_);
  finest_->for_ranges(parallel_, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    kernels.scale_positions(from.data(), middle.data(), 1 / body_.config().cell_size, positions.data(), first,
                            last);
  });
  finest_->for_ranges(parallel_, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    kernels.rotations(finest_->stencil(), positions.data(), shares.data(), turning_[6], rotations.data(),
                      first, last);
  });
  if (!held_.empty()) hold_in_lattice();
}

void RestCycle::place_stiffly(const Field<double>& x) {
  std::vector<Vec3> at(pieces_.size(), Vec3::Zero()), at_rest = at;
  std::vector<Eigen::Matrix3d> turned(pieces_.size(), Eigen::Matrix3d::Zero());
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p) {
      at[piece] += masses_[p] / pieces_[piece].mass * x.at(sites_[p]);
      at_rest[piece] += masses_[p] / pieces_[piece].mass * body_.rest_position(sites_[p]);
    }
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p)
      turned[piece] += masses_[p] * (x.at(sites_[p]) - at[piece]) *
                       (body_.rest_position(sites_[p]) - at_rest[piece]).transpose();
  for (Eigen::Matrix3d& matrix : turned) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    matrix = u * svd.matrixV().transpose();
  }
  set_rotations();
  for (const auto& [piece, first, last] : portions_)
    for (std::size_t p = first; p < last; ++p) {
      const std::ptrdiff_t site = sites_[p];
      if (turning_[0][site] + turning_[1][site] == 0) continue;
      for (int i = 0; i < 9; ++i) rotations_[i][site] = float(turned[piece](i / 3, i % 3));
    }
  if (!held_.empty()) hold_in_lattice();
}

void RestCycle::hold(std::vector<HeldParticle> held) {
  held_ = std::move(held);
  for (Piece& piece : pieces_) piece.unheld = Eigen::Array3d::Ones();
  for (const auto& [site, directions, friction] : held_) {
    Piece& piece = pieces_[std::size_t(piece_of_[std::size_t(body_.particle(site))])];
    piece.unheld = ((directions + friction).diagonal().array() > 0).select(0, piece.unheld);
  }
  hold_in_lattice();
}

/// Held directions as they lie in the body at rest.
void RestCycle::hold_in_lattice() {
  std::vector<SiteConstraint> constraints;
  for (const auto& [site, directions, friction] : held_) {
    Eigen::Matrix3f q;
    for (int i = 0; i < 9; ++i) q(i / 3, i % 3) = rotations_[i][site];
    constraints.push_back(
        {site, q.transpose() * directions.cast<float>() * q, q.transpose() * friction.cast<float>() * q});
  }
  finest_->constrain(constraints);
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
void RestCycle::turn_back(const Field<double>& r, double norm, PaddedArrays& out) {
  const auto q = beginnings<9>(rotations_);
  const auto from = axes_of(r);
  const auto to = beginnings<3>(out);
  finest_->for_ranges(parallel_, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    fastest_copy<RestKernels>().turn_back(q.data(), from.data(), 1 / norm, to.data(), first, last);
  });
}

/// Takes from r what `values` makes of the rest.
void RestCycle::give_way(const Field<double>& values, double norm) {
  turn_back(values, norm, finest_->z());
  finest_->subtract_product(parallel_);
}

void RestCycle::take_held(const Field<double>& values, Field<double>& z) const {
  for (const auto& [site, directions, friction] : held_) {
    const Vec3 value = z.at(site);
    z.set(site, value - directions * value);
  }
  if (values.size() > 0) z.array() += values.array();
}

void RestCycle::solve(const Field<double>& r, double norm, const Field<double>& values, Field<double>& z) {
  const bool keeps = any_piece_keeps();
  std::vector<Vec3> momenta;
  if (keeps) {
    momenta = means([&](std::ptrdiff_t site, double) { return r.at(site); });
    r_ = r;
    for_each_of_pieces([&](std::size_t piece, std::ptrdiff_t site, double mass) {
      r_.set(site, r.at(site) - mass * momenta[piece]);
    });
  }
  if (values.size() > 0) norm = std::max(norm, values.array().abs().maxCoeff());
  if (!(norm > 0)) norm = 1;
  turn_back(keeps ? r_ : r, norm, finest_->r());
  if (values.size() > 0) give_way(values, norm);
  finest_->cycle(parallel_, kind_);
  const auto q = beginnings<9>(rotations_);
  const auto found = beginnings<3>(finest_->z());
  double* const to[3] = {z.axis(0), z.axis(1), z.axis(2)};
  finest_->for_ranges(parallel_, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    fastest_copy<RestKernels>().turn(q.data(), found.data(), norm, to, first, last);
  });
  if (!held_.empty()) take_held(values, z);
  if (!keeps) return;
  std::vector<Vec3> changes =
      means([&](std::ptrdiff_t site, double mass) { return Vec3(mass * z.at(site)); });
  for (std::size_t i = 0; i < changes.size(); ++i) changes[i] = momenta[i] - changes[i];
  for_each_of_pieces(
      [&](std::size_t piece, std::ptrdiff_t site, double) { z.set(site, z.at(site) + changes[piece]); });
}

}  // namespace mss
