#include "core/body/phonons.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

#include "core/body/spring_slots.hpp"
#include "core/forces/spring_law.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;
constexpr std::size_t slots = spring_slots.size();

/// det(F) F^-T.
Matrix3d volume_slope(const Matrix3d& F) {
  Matrix3d slope;
  for (int i = 0; i < 3; ++i) slope.col(i) = F.col((i + 1) % 3).cross(F.col((i + 2) % 3));
  return slope;
}

/// From one end of a spring at rest to the other, in cells.
Vector3d along_slot(std::size_t s) {
  const auto place = [](int corner) { return Vector3d(corner & 1, corner >> 1 & 1, corner >> 2); };
  return place(spring_slots[s].b) - place(spring_slots[s].a);
}

double constant_of(const SpringConstants& springs, std::size_t s) {
  switch (spring_slots[s].kind) {
    case SpringSlot::Class::edge:
      return springs.edge;
    case SpringSlot::Class::face:
      return springs.face;
    case SpringSlot::Class::body:
      break;
  }
  return springs.body;
}

/// What K(q) needs of q.
struct Wave {
  Vector3d phases;
  std::array<double, slots> springs;  ///< 4 sin^2(q.n_s / 2)
  Vector3d edges;                     ///< a
  double size;                        ///< 4 sum_i sin^2(q_i / 2)

  explicit Wave(const Vector3d& q) : phases(q), size(4 * (q / 2).array().sin().square().sum()) {
    for (std::size_t s = 0; s < slots; ++s) {
      const double sine = std::sin(q.dot(along_slot(s)) / 2);
      springs[s] = 4 * sine * sine;
    }
    const Eigen::Array3d sine = (q / 2).array().sin(), cosine = (q / 2).array().cos();
    edges = 2 * Vector3d(sine[0] * cosine[1] * cosine[2], cosine[0] * sine[1] * cosine[2],
                         cosine[0] * cosine[1] * sine[2]);
  }
};

/// K(q) about one F for many q.
class WaveStiffness {
 public:
  WaveStiffness(const SpringConstants& springs, double cell_size, const Matrix3d& F)
      : volume_(springs.volume * cell_size), slope_(volume_slope(F)) {
    for (std::size_t s = 0; s < slots; ++s) {
      const Vector3d rest = along_slot(s), present = F * rest, along = present.normalized();
      const double k = constant_of(springs, s), ratio = rest.norm() / present.norm();
      const double across = tension_over_length(k, ratio);
      of_spring_[s] =
          across * Matrix3d::Identity() + (spring_stiffness(k, ratio) - across) * along * along.transpose();
    }
  }

  Matrix3d at(const Wave& wave) const {
    const Vector3d swelling = slope_ * wave.edges;
    Matrix3d stiffness = volume_ * swelling * swelling.transpose();
    for (std::size_t s = 0; s < slots; ++s) stiffness += wave.springs[s] * of_spring_[s];
    return stiffness;
  }

  /// Its smallest eigenvalue, relative as in SoftestWave.
  double least(const Wave& wave) const {
    Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
    eigen.computeDirect(at(wave), Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[0] / wave.size;
  }

  /// Whether no wave of zone_grid() has a least() below -`none`.
  bool resists_grid(double none) const;

 private:
  std::array<Matrix3d, slots> of_spring_;
  double volume_;
  Matrix3d slope_;
};

constexpr double long_phase = 1e-3;  ///< per cell, of waves whose next order in it is a millionth

/// A grid over half of the zone, as K(-q) = K(q), and long waves in the directions of its outer points.
const std::vector<Wave>& zone_grid() {
  static const std::vector<Wave> grid = [] {
    constexpr int parts = 6;
    std::vector<Wave> all;
    for (int i = -parts + 1; i <= parts; ++i)
      for (int j = -parts + 1; j <= parts; ++j)
        for (int k = 0; k <= parts; ++k) {
          if (k == 0 && (j < 0 || (j == 0 && i <= 0))) continue;
          const Vector3d q = pi / parts * Vector3d(i, j, k);
          all.emplace_back(q);
          if (std::max({std::abs(i), std::abs(j), k}) == parts) all.emplace_back(long_phase * q.normalized());
        }
    return all;
  }();
  return grid;
}

/// zone_grid(), number by number over the waves' sizes, so that waves are computed side by side.
struct GridColumns {
  Eigen::Matrix<double, Eigen::Dynamic, int(slots)> springs;
  Eigen::Array<double, Eigen::Dynamic, 3> edges;  ///< over the root of the size

  GridColumns()
      : springs(Eigen::Index(zone_grid().size()), Eigen::Index(slots)),
        edges(Eigen::Index(zone_grid().size()), 3) {
    for (std::size_t w = 0; w < zone_grid().size(); ++w) {
      const Wave& wave = zone_grid()[w];
      for (std::size_t s = 0; s < slots; ++s)
        springs(Eigen::Index(w), Eigen::Index(s)) = wave.springs[s] / wave.size;
      edges.row(Eigen::Index(w)) = wave.edges.transpose().array() / std::sqrt(wave.size);
    }
  }
};

/// By Sylvester's criterion: K / size + none I is positive definite.
bool WaveStiffness::resists_grid(double none) const {
  static const GridColumns grid;
  constexpr std::array<std::array<int, 2>, 6> entries{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};
  Eigen::Matrix<double, int(slots), 6> of_spring;
  for (std::size_t s = 0; s < slots; ++s)
    for (int e = 0; e < 6; ++e)
      of_spring(Eigen::Index(s), e) = of_spring_[s](entries[std::size_t(e)][0], entries[std::size_t(e)][1]);
  using Columns = Eigen::Array<double, Eigen::Dynamic, 6>;
  Columns k = (grid.springs * of_spring).array();
  const Eigen::Array<double, Eigen::Dynamic, 3> swelling = grid.edges.matrix() * slope_.transpose();
  for (int e = 0; e < 6; ++e) {
    const auto [row, column] = entries[std::size_t(e)];
    k.col(e) += volume_ * swelling.col(row) * swelling.col(column);
    if (row == column) k.col(e) += none;
  }
  const auto xx = k.col(0), yy = k.col(1), zz = k.col(2), yz = k.col(3), zx = k.col(4), xy = k.col(5);
  return (xx > 0).all() && (xx * yy > xy * xy).all() &&
         (xx * (yy * zz - yz * yz) + xy * (yz * zx - xy * zz) + zx * (xy * yz - yy * zx) > 0).all();
}

/// Downhill from a wave by steps along the axes, which halve where none leads down.
SoftestWave downhill(const WaveStiffness& stiffness, SoftestWave wave) {
  const bool is_long = wave.is_long();
  double step = is_long ? 0.3 * long_phase : 0.3;
  for (const double smallest = 1e-3 * step; step > smallest;) {
    const SoftestWave before = wave;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        Vector3d q = before.phases + sign * step * Vector3d::Unit(axis);
        if (is_long) q *= long_phase / q.norm();
        if (q.norm() < long_phase / 2) continue;
        if (const double least = stiffness.least(Wave(q)); least < wave.stiffness) wave = {least, q};
      }
    if (wave.phases == before.phases) step /= 2;
  }
  for (double& phase : wave.phases) phase = std::remainder(phase, 2 * pi);
  return wave;
}

/// Across each other: the direction of a path, and two axes of symmetry, along which its sides stay.
Matrix3d frame_of(StrainPath::Direction along) {
  Matrix3d frame = Matrix3d::Identity();
  if (along == StrainPath::Direction::edge) return frame;
  frame.col(0) = along == StrainPath::Direction::face_diagonal ? Vector3d(1, 1, 0) : Vector3d(1, 1, 1);
  frame.col(1) = Vector3d(1, -1, 0);
  frame.col(2) = frame.col(0).cross(frame.col(1));
  frame.colwise().normalize();
  return frame;
}

/// Stretches of the sides that free them from stress, by Newton's method from a guess; NaN if it finds none
/// at which the sides resist being moved, as where the volume force drives them apart.
Vector2d free_sides(const SpringConstants& springs, double cell_size, const Matrix3d& frame, double stretch,
                    Vector2d sides) {
  const auto stress_across = [&](const Vector2d& of_sides) -> Vector2d {
    const Matrix3d F = frame * Vector3d(stretch, of_sides[0], of_sides[1]).asDiagonal() * frame.transpose();
    const Matrix3d stress = frame.transpose() * lattice_stress(springs, cell_size, F) * frame;
    return {stress(1, 1), stress(2, 2)};
  };
  constexpr double difference = 1e-6, converged = 1e-11;
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::Matrix2d slope;
    for (int i = 0; i < 2; ++i)
      slope.col(i) = (stress_across(sides + difference * Vector2d::Unit(i)) -
                      stress_across(sides - difference * Vector2d::Unit(i))) /
                     (2 * difference);
    const Vector2d change = slope.fullPivLu().solve(stress_across(sides));
    sides -= change;
    if (change.norm() < converged && slope(0, 0) > 0 && slope.determinant() > 0) return sides;
  }
  return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

constexpr double search_step = 0.05;  ///< of strain, within which no lattice gets stable again

/// Gradients along a path, whose free sides are followed from rest on in small steps, so that a state is the
/// one that comes from there.
class FollowedPath {
 public:
  FollowedPath(const SpringConstants& springs, double cell_size, const StrainPath& path)
      : springs_(springs), cell_size_(cell_size), path_(path), frame_(frame_of(path.along)) {}

  /// See strained_gradient().
  Matrix3d gradient(double strain) {
    if (path_.kind == StrainPath::Kind::shear) {
      Matrix3d F = Matrix3d::Identity();
      F(0, 1) = strain;
      return F;
    }
    const Vector2d sides = sides_at(strain);
    return frame_ * Vector3d(stretch(strain), sides[0], sides[1]).asDiagonal() * frame_.transpose();
  }

 private:
  double stretch(double strain) const {
    return path_.kind == StrainPath::Kind::tension ? 1 + strain : 1 - strain;
  }

  /// From the nearest smaller strain at which they are known.
  Vector2d sides_at(double strain) {
    constexpr double step = 0.02;  // within which Newton's method follows them
    const auto [from, known] = *std::prev(known_.upper_bound(strain));
    if (from == strain) return known;
    Vector2d sides = known;
    const int steps = std::max(1, int(std::ceil((strain - from) / step)));
    for (int i = 1; i <= steps && sides.allFinite(); ++i)
      sides = free_sides(springs_, cell_size_, frame_, stretch(from + (strain - from) * i / steps), sides);
    return known_[strain] = sides;
  }

  const SpringConstants& springs_;
  double cell_size_;
  StrainPath path_;
  Matrix3d frame_;
  std::map<double, Vector2d> known_{{0, Vector2d(1, 1)}};  ///< by strain
};

}  // namespace

Matrix3d wave_stiffness(const SpringConstants& springs, double cell_size, const Matrix3d& F,
                        const Vector3d& phases) {
  return WaveStiffness(springs, cell_size, F).at(Wave(phases));
}

Matrix3d lattice_stress(const SpringConstants& springs, double cell_size, const Matrix3d& F) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t s = 0; s < slots; ++s) {
    const Vector3d rest = along_slot(s), present = F * rest;
    sum += tension_over_length(constant_of(springs, s), rest.norm() / present.norm()) * present *
           rest.transpose();
  }
  return sum / cell_size + springs.volume * (F.determinant() - 1) * volume_slope(F);
}

SoftestWave softest_wave(const SpringConstants& springs, double cell_size, const Matrix3d& F) {
  const WaveStiffness stiffness(springs, cell_size, F);
  SoftestWave of_short{std::numeric_limits<double>::infinity(), Vector3d::Zero()}, of_long = of_short;
  for (const Wave& wave : zone_grid()) {
    const SoftestWave found{stiffness.least(wave), wave.phases};
    SoftestWave& softest = found.is_long() ? of_long : of_short;
    if (found.stiffness < softest.stiffness) softest = found;
  }
  const SoftestWave a = downhill(stiffness, of_short), b = downhill(stiffness, of_long);
  return a.stiffness < b.stiffness ? a : b;
}

const char* to_string(StrainPath::Kind kind) {
  switch (kind) {
    case StrainPath::Kind::tension:
      return "tension";
    case StrainPath::Kind::compression:
      return "compression";
    case StrainPath::Kind::shear:
      return "shear";
  }
  return "";
}

std::string StrainPath::name() const {
  if (kind == Kind::shear) return "shear along [100] across [010]";
  const char* direction = along == Direction::edge            ? "[100]"
                          : along == Direction::face_diagonal ? "[110]"
                                                              : "[111]";
  return fmt::format("{} along {}", to_string(kind), direction);
}

const std::vector<StrainPath>& strain_paths() {
  static const std::vector<StrainPath> paths = [] {
    std::vector<StrainPath> all;
    for (const auto kind : {StrainPath::Kind::tension, StrainPath::Kind::compression})
      for (const auto along : {StrainPath::Direction::edge, StrainPath::Direction::face_diagonal,
                               StrainPath::Direction::body_diagonal})
        all.push_back({kind, along});
    all.push_back({StrainPath::Kind::shear});
    return all;
  }();
  return paths;
}

Matrix3d strained_gradient(const SpringConstants& springs, double cell_size, const StrainPath& path,
                           double strain) {
  return FollowedPath(springs, cell_size, path).gradient(strain);
}

PhononLimit phonon_limit(const SpringConstants& springs, double cell_size, const StrainPath& path,
                         double most) {
  constexpr double exact = 1e-4;
  // What mechanisms that nothing resists have by rounding.
  const double none = 1e-9 * (springs.edge + springs.face + springs.body);
  FollowedPath followed(springs, cell_size, path);
  // The grid finds most of what grows, in a tenth of the time that the softest wave takes.
  const auto fails_on_grid = [&](double strain) {
    const Matrix3d F = followed.gradient(strain);
    return !F.allFinite() || !WaveStiffness(springs, cell_size, F).resists_grid(none);
  };
  const auto fails = [&](double strain) {
    return fails_on_grid(strain) ||
           softest_wave(springs, cell_size, followed.gradient(strain)).stiffness < -none;
  };
  double failed = std::min(search_step, most);
  while (failed < most && !fails_on_grid(failed)) failed = std::min(failed + search_step, most);
  if (!fails(failed)) return {.path = path};
  double stable = failed - search_step;  // on the grid, though not always beside it
  while (stable > 0 && fails(stable)) stable -= search_step;
  stable = std::max(stable, 0.0);
  while (failed - stable > exact) {
    const double middle = (stable + failed) / 2;
    (fails(middle) ? failed : stable) = middle;
  }
  const Matrix3d F = followed.gradient(failed);
  return {.path = path,
          .strain = failed,
          .wave = F.allFinite() ? softest_wave(springs, cell_size, F) : SoftestWave{}};
}

std::vector<PhononLimit> least_phonon_limits(const SpringConstants& springs, double cell_size,
                                             const std::function<double(StrainPath::Kind)>& most) {
  std::vector<PhononLimit> least;
  for (const StrainPath& path : strain_paths()) {
    const PhononLimit limit = phonon_limit(springs, cell_size, path, most(path.kind));
    if (least.empty() || least.back().path.kind != path.kind)
      least.push_back(limit);
    else if (limit.strain < least.back().strain)
      least.back() = limit;
  }
  return least;
}

}  // namespace mss
