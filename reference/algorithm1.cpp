#include "reference/algorithm1.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/forces/spring_law.hpp"

namespace mss::reference {

namespace {

/// The thesis's corners p_1 .. p_8 as steps along x, y, z from the lower corner; read off eq. 3-5.
constexpr std::array<std::array<int, 3>, 8> corner_of{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {0, 0, 1}, {0, 1, 1}, {1, 1, 1}}};

/// Springs of one cell (Fig. 2-3) as pairs of thesis corners, 1-based. Of the two diagonals of a face the
/// first is the one that Fig. 2-2 left keeps.
constexpr std::array<std::pair<int, int>, 12> edges{
    {{1, 2}, {4, 3}, {6, 5}, {7, 8}, {2, 3}, {1, 4}, {5, 8}, {6, 7}, {1, 6}, {3, 8}, {2, 5}, {4, 7}}};
constexpr std::array<std::pair<int, int>, 12> face_diagonals{
    {{1, 3}, {2, 4}, {6, 8}, {5, 7}, {1, 5}, {2, 6}, {4, 8}, {3, 7}, {1, 7}, {4, 6}, {2, 8}, {3, 5}}};
constexpr std::array<std::pair<int, int>, 4> body_diagonals{{{1, 8}, {2, 7}, {3, 6}, {4, 5}}};

void atomic_add(Vec3& target, const Vec3& value) {
  for (int a = 0; a < 3; ++a) {
    double& component = target[a];
    const double addend = value[a];
#pragma omp atomic
    component += addend;
  }
}

struct Volume {
  double v;
  Vec3 yz, zx, xy;
};

/// Eq. 3-5 and 3-6.
Volume estimate(const std::vector<Algorithm1::Particle>& particles, const Algorithm1::Cell& cell) {
  const auto p = [&](int i) -> const Vec3& { return particles[cell.p[std::size_t(i - 1)]].x; };
  const Vec3 x = 0.25 * ((p(2) - p(1)) + (p(3) - p(4)) + (p(5) - p(6)) + (p(8) - p(7)));
  const Vec3 y = 0.25 * ((p(3) - p(2)) + (p(4) - p(1)) + (p(8) - p(5)) + (p(7) - p(6)));
  const Vec3 z = 0.25 * ((p(6) - p(1)) + (p(8) - p(3)) + (p(5) - p(2)) + (p(7) - p(4)));
  return {x.dot(y.cross(z)), y.cross(z), z.cross(x), x.cross(y)};
}

/// The neighbour of corner c of a cell along an axis.
std::size_t neighbour(std::size_t c, std::size_t axis) {
  auto other = corner_of[c];
  other[axis] = 1 - other[axis];
  return std::size_t(std::find(corner_of.begin(), corner_of.end(), other) - corner_of.begin());
}

/// The principal stretches of the three edges at a corner; inverted (side -1), the smallest is negative.
struct StretchedCorner {
  Eigen::JacobiSVD<Eigen::Matrix3d> svd;
  double side;
  Vec3 stretch;
};

StretchedCorner stretched_corner(const std::vector<Algorithm1::Particle>& particles,
                                 const Algorithm1::Cell& cell, std::size_t c, double cell_size) {
  Eigen::Matrix3d along;
  for (std::size_t axis = 0; axis < 3; ++axis)
    along.col(Eigen::Index(axis)) = (1.0 - 2.0 * corner_of[c][axis]) / cell_size *
                                    (particles[cell.p[neighbour(c, axis)]].x - particles[cell.p[c]].x);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(along, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double side = along.determinant() < 0 ? -1 : 1;
  const Vec3& s = svd.singularValues();
  return {svd, side, Vec3(s[0], s[1], side * s[2])};
}

/// How far a stretch is below the length at which the guard begins to act.
double missing(double stretch) { return std::max(0.0, 0.7 - stretch); }

double mean(const std::array<float, 8>& corners) {
  return std::accumulate(corners.begin(), corners.end(), 0.0) / 8;
}

/// Corners c = bx + 2 by + 4 bz of core/body/cell_fill.hpp from the thesis's.
std::size_t number_of(std::size_t c) {
  const auto& [x, y, z] = corner_of[c];
  return static_cast<std::size_t>(x) + 2 * static_cast<std::size_t>(y) + 4 * static_cast<std::size_t>(z);
}

/// The mean of the octants at the corners that lie between two corners, themselves included; `floor` of the
/// cell's mean instead.
double share_of_spring(const CellFill& fill, std::size_t first, std::size_t second, double floor) {
  double sum = 0, count = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    bool between = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      between = between && (corner_of[first][axis] != corner_of[second][axis] ||
                            corner_of[c][axis] == corner_of[first][axis]);
    if (!between) continue;
    sum += double(fill.octant[number_of(c)]);
    count += 1;
  }
  return floor * mean(fill.octant) + (1 - floor) * sum / count;
}

double share_of_mass(const CellFill& fill, std::size_t c, double floor) {
  return floor * mean(fill.corner) + (1 - floor) * double(fill.corner[number_of(c)]);
}

}  // namespace

Algorithm1::Algorithm1(const BodyConfig& config, const Vec3& gravity, int threads)
    : threads_(threads),
      gravity_(gravity),
      has_volume_force_(config.has_volume_force()),
      is_guarded_(config.fold_guard > 0),
      cell_size_(config.cell_size),
      cell_volume_(config.cell_size * config.cell_size * config.cell_size),
      relaxation_(config.relaxation) {
  connect(config);
}

void Algorithm1::connect(const BodyConfig& config) {
  std::map<std::array<int, 3>, std::size_t> id;  // by (k, j, i): z-major, the order of particles.csv
  const VoxelGrid& voxels = config.voxels;
  const auto each_cell = [&](auto&& visit) {
    for (int k = 0; k < voxels.nz(); ++k)
      for (int j = 0; j < voxels.ny(); ++j)
        for (int i = 0; i < voxels.nx(); ++i)
          if (voxels.at(i, j, k)) visit(i, j, k);
  };
  each_cell([&](int i, int j, int k) {
    for (const auto& c : corner_of) id[{k + c[2], j + c[1], i + c[0]}] = 0;
  });
  for (auto& [kji, index] : id) {
    index = particles_.size();
    particles_.push_back({.x = config.origin + config.cell_size * Vec3(kji[2], kji[1], kji[0])});
  }

  Connections connections{config, {}, {}};
  each_cell([&](int i, int j, int k) {
    Cell cell{};
    for (std::size_t c = 0; c < 8; ++c)
      cell.p[c] = id.at({k + corner_of[c][2], j + corner_of[c][1], i + corner_of[c][0]});
    if (config.content_of.empty())
      fill(cell, {}, connections);
    else
      for (const PartFill& part : config.contents[config.content_of[voxels.index(i, j, k)]])
        fill(cell, part, connections);
    cells_.push_back(cell);
  });
  add_dampers(connections);
  for (Spring& s : springs_) s.branch = relaxation_.ratio * s.stiffness;
  for (const Weight& weight : config.weights) add_weight(weight, 1e-9 * config.cell_size);
}

/// Adds what a cell has of a part to its particles' masses (eq. 2-2), its stiffness and its springs.
void Algorithm1::fill(Cell& cell, const PartFill& filled, Connections& connections) {
  const BodyConfig& config = connections.config;
  const auto part = std::size_t(filled.part);
  const Part material = config.all_parts()[part];
  const SpringConstants& springs = material.springs;
  const bool weighted = config.sharing == Sharing::weighted;
  for (std::size_t c = 0; c < 8; ++c)
    particles_[cell.p[c]].mass +=
        material.density / 8 * cell_volume_ * share_of_mass(filled.fill, c, config.mass_floor());
  const double share = mean(filled.fill.octant);
  cell.volume_stiffness += share * springs.volume;
  // Times the shear modulus of springs, from the energy that shear stores in a cell's diagonals.
  cell.guard_stiffness +=
      share * config.fold_guard * (springs.face + 4.0 / 3 * springs.body) / config.cell_size;

  const auto connect_class = [&](const auto& pairs, double stiffness, double cells, std::size_t stride) {
    for (std::size_t s = 0; s < pairs.size(); s += stride) {
      const auto first = std::size_t(pairs[s].first - 1), second = std::size_t(pairs[s].second - 1);
      const double of_spring = share_of_spring(filled.fill, first, second, config.springs_floor());
      connect_pair(cell.p[first], cell.p[second],
                   {part, weighted ? stiffness / cells * of_spring : stiffness}, connections);
    }
  };
  connect_class(edges, springs.edge, 4, 1);
  if (config.topology != Topology::edges_body)
    connect_class(face_diagonals, springs.face, 2, config.topology == Topology::one_diagonal ? 2 : 1);
  connect_class(body_diagonals, springs.body, 1, 1);
}

void Algorithm1::connect_pair(std::size_t a, std::size_t b, const Share& share, Connections& connections) {
  if (share.stiffness == 0) return;
  const auto [entry, is_new] = connections.spring_of.try_emplace(std::minmax(a, b), springs_.size());
  if (is_new) {
    springs_.push_back({a, b, 0, (particles_[b].x - particles_[a].x).norm(), 0});
    connections.shares.emplace_back();
  } else if (connections.config.sharing == Sharing::uniform) {
    return;
  }
  springs_[entry->second].stiffness += share.stiffness;
  connections.shares[entry->second].push_back(share);
}

/// What the laws of its parts give the whole spring, each as far as the stiffness is that part's.
void Algorithm1::add_dampers(const Connections& connections) {
  const BodyConfig& config = connections.config;
  const std::vector<Part> parts = config.all_parts();
  for (std::size_t i = 0; i < springs_.size(); ++i)
    for (const Share& share : connections.shares[i]) {
      Spring& s = springs_[i];
      const double m1 = particles_[s.p1].mass, m2 = particles_[s.p2].mass;
      const auto& [law, zeta, viscosity] = parts[share.part].damping;
      const SpringConstants& k = parts[share.part].springs;
      double whole = 0;
      if (law == Damping::Law::ratio)  // critical for two masses on a spring, times zeta
        whole = zeta * 2 * std::sqrt(s.stiffness * (m1 * m2 / (m1 + m2)));
      if (law == Damping::Law::thesis)  // eq. 2-4
        whole = 2 * std::sqrt(s.stiffness * (m1 + m2)) / s.rest_length;
      if (law == Damping::Law::viscosity)  // the stress of a shear rate is that of viscosity / G
        whole = s.stiffness * viscosity * config.cell_size / (k.face + 4.0 / 3 * k.body);
      s.damping += whole * share.stiffness / s.stiffness;
    }
}

void Algorithm1::add_weight(const Weight& weight, double slack) {
  std::vector<Particle*> carriers;
  for (Particle& p : particles_) {
    bool inside = true;
    for (int a = 0; a < 3; ++a)
      inside = inside && p.x[a] >= weight.box.lower[a] - slack && p.x[a] <= weight.box.upper[a] + slack;
    if (inside) carriers.push_back(&p);
  }
  for (Particle* p : carriers) p->mass += weight.mass / double(carriers.size());
}

namespace {

/// Eq. 2-3. Of another law than Hooke's, if the program is built for one, the derivative of its energy by
/// differences, which are exact for fourth powers: the law's own tension is then checked against that.
double tension(double k, double rest_length, double length) {
  if (SpringLaw::is_linear) return k * (length - rest_length);
  const double h = 1e-3 * rest_length;
  const auto energy = [&](double change) { return spring_energy(k, rest_length, length + change); };
  return (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
}

}  // namespace

void Algorithm1::add_springs() {
  const auto count = std::ptrdiff_t(springs_.size());
#pragma omp parallel for num_threads(threads_) schedule(static)
  for (std::ptrdiff_t j = 0; j < count; ++j) {
    const Spring& s = springs_[std::size_t(j)];
    Particle& p1 = particles_[s.p1];
    Particle& p2 = particles_[s.p2];
    const Vec3 along = p2.x - p1.x;
    const double length = along.norm();
    if (length == 0) continue;  // no direction, no force
    const Vec3 direction = along / length;
    const Vec3 spring_force = tension(s.stiffness, s.rest_length, length) * direction;
    atomic_add(p1.f, spring_force);
    atomic_add(p2.f, -spring_force);
    const double speed_difference = (p2.v - p1.v).dot(direction);         // eq. 2-6, as a projection
    const Vec3 damping_force = s.damping * speed_difference * direction;  // eq. 2-5
    atomic_add(p1.f, damping_force);
    atomic_add(p2.f, -damping_force);
  }
}

/// The spring of a Maxwell branch is as long as its spring, less what its damper has given way.
void Algorithm1::add_branches() {
  if (relaxation_.ratio == 0) return;
  for (const Spring& s : springs_) {
    const double length = length_of(s);
    if (length == 0) continue;
    const Vec3 force =
        s.branch * (length - s.rest_length - s.dashpot) / length * (particles_[s.p2].x - particles_[s.p1].x);
    particles_[s.p1].f += force;
    particles_[s.p2].f -= force;
  }
}

/// The damper's ODE d' = (L - L0 - d) / time while the length L changes at a constant rate, by many steps of
/// Runge's and Kutta's method.
void Algorithm1::give_way(Spring& spring, double length_before, double dt) const {
  constexpr int steps = 8;
  const double change = length_of(spring) - length_before, h = dt / steps;
  for (int n = 0; n < steps; ++n) {
    const auto rate = [&](double share, double dashpot) {
      const double length = length_before + change * (n + share) / steps;
      return (length - spring.rest_length - dashpot) / relaxation_.time;
    };
    const double d = spring.dashpot, k1 = rate(0, d), k2 = rate(0.5, d + h / 2 * k1),
                 k3 = rate(0.5, d + h / 2 * k2), k4 = rate(1, d + h * k3);
    spring.dashpot += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
}

void Algorithm1::add_volume_forces() {
  if (!has_volume_force_) return;
  const auto count = std::ptrdiff_t(cells_.size());
#pragma omp parallel for num_threads(threads_) schedule(static)
  for (std::ptrdiff_t j = 0; j < count; ++j) {
    const Cell& cell = cells_[std::size_t(j)];
    const auto [v, yz, zx, xy] = estimate(particles_, cell);
    const double factor = -cell.volume_stiffness * (v - cell_volume_) / (4 * cell_volume_);
    for (std::size_t c = 0; c < 8; ++c) {  // eq. 3-7: the signs are the corner's side along x, y, z
      const auto sign = [&](std::size_t axis) { return 2.0 * corner_of[c][axis] - 1.0; };
      const Vec3 force = factor * (sign(0) * yz + sign(1) * zx + sign(2) * xy);
      atomic_add(particles_[cell.p[c]].f, force);
    }
  }
}

/// Against folding, corner by corner: core/forces/fold_guard.hpp.
void Algorithm1::add_guard_forces() {
  if (!is_guarded_) return;
  for (const Cell& cell : cells_)
    for (std::size_t c = 0; c < 8; ++c) {
      const StretchedCorner corner = stretched_corner(particles_, cell, c, cell_size_);
      Eigen::Matrix3d push = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i)
        push += missing(corner.stretch[i]) * (i == 2 ? corner.side : 1) * corner.svd.matrixU().col(i) *
                corner.svd.matrixV().col(i).transpose();
      push *= cell.guard_stiffness * cell_size_ * cell_size_ / 8;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Vec3 at_end = (1.0 - 2.0 * corner_of[c][axis]) * push.col(Eigen::Index(axis));
        particles_[cell.p[neighbour(c, axis)]].f += at_end;
        particles_[cell.p[c]].f -= at_end;
      }
    }
}

double Algorithm1::guard_energy() const {
  if (!is_guarded_) return 0;
  double energy = 0;
  for (const Cell& cell : cells_)
    for (std::size_t c = 0; c < 8; ++c) {
      const StretchedCorner corner = stretched_corner(particles_, cell, c, cell_size_);
      for (int i = 0; i < 3; ++i) energy += cell.guard_stiffness * std::pow(missing(corner.stretch[i]), 2);
    }
  return energy * std::pow(cell_size_, 3) / 16;
}

void Algorithm1::compute_forces() {
  const auto count = std::ptrdiff_t(particles_.size());
#pragma omp parallel for num_threads(threads_) schedule(static)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Particle& p = particles_[std::size_t(i)];
    p.f = p.mass * gravity_;
  }
  add_springs();
  add_branches();
  add_volume_forces();
  add_guard_forces();
}

void Algorithm1::step(double dt) {
  compute_forces();
  std::vector<double> lengths;
  for (std::size_t i = 0; relaxation_.ratio > 0 && i < springs_.size(); ++i)
    lengths.push_back(length_of(springs_[i]));
  const auto count = std::ptrdiff_t(particles_.size());
#pragma omp parallel for num_threads(threads_) schedule(static)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Particle& p = particles_[std::size_t(i)];
    p.v += dt / p.mass * p.f;
    p.x += dt * p.v;
  }
  for (std::size_t i = 0; i < lengths.size(); ++i) give_way(springs_[i], lengths[i], dt);
}

double Algorithm1::potential_energy() const {
  double energy = 0;
  for (const Spring& s : springs_) {
    const double stretch = (particles_[s.p2].x - particles_[s.p1].x).norm() - s.rest_length;
    energy += SpringLaw::is_linear ? 0.5 * s.stiffness * stretch * stretch
                                   : spring_energy(s.stiffness, s.rest_length, s.rest_length + stretch);
  }
  for (const Cell& cell : cells_) {  // eq. 3-1
    const double change = estimate(particles_, cell).v - cell_volume_;
    energy += 0.5 * cell.volume_stiffness * change * change / cell_volume_;
  }
  for (const Particle& p : particles_) energy -= p.mass * gravity_.dot(p.x);
  return energy + guard_energy();
}

}  // namespace mss::reference
