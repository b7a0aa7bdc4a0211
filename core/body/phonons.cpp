#include "core/body/phonons.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

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

bool is_positive(const Matrix3d& symmetric) {
  const double minor = symmetric(0, 0) * symmetric(1, 1) - symmetric(0, 1) * symmetric(0, 1);
  return symmetric(0, 0) > 0 && minor > 0 && symmetric.determinant() > 0;
}

bool WaveStiffness::resists_grid(double none) const {
  const std::vector<Wave>& grid = zone_grid();
  return std::all_of(grid.begin(), grid.end(), [&](const Wave& wave) {
    return is_positive(at(wave) / wave.size + none * Matrix3d::Identity());
  });
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

constexpr double sides_step = 0.02;   ///< of strain, within which Newton's method follows the free sides
constexpr double search_step = 0.05;  ///< of strain, within which no lattice gets stable again

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
  if (path.kind == StrainPath::Kind::shear) {
    Matrix3d F = Matrix3d::Identity();
    F(0, 1) = strain;
    return F;
  }
  const Matrix3d frame = frame_of(path.along);
  const double sign = path.kind == StrainPath::Kind::tension ? 1 : -1;
  Vector2d sides(1, 1);
  // In small steps, so that the state is the one that follows from rest.
  const int steps = std::max(1, int(std::ceil(strain / sides_step)));
  for (int i = 1; i <= steps && sides.allFinite(); ++i)
    sides = free_sides(springs, cell_size, frame, 1 + sign * strain * i / steps, sides);
  return frame * Vector3d(1 + sign * strain, sides[0], sides[1]).asDiagonal() * frame.transpose();
}

PhononLimit phonon_limit(const SpringConstants& springs, double cell_size, const StrainPath& path,
                         double most) {
  constexpr double exact = 1e-4;
  // What mechanisms that nothing resists have by rounding.
  const double none = 1e-9 * (springs.edge + springs.face + springs.body);
  const auto gradient = [&](double strain) { return strained_gradient(springs, cell_size, path, strain); };
  const auto fails_on_grid = [&](double strain) {
    const Matrix3d F = gradient(strain);
    return !F.allFinite() || !WaveStiffness(springs, cell_size, F).resists_grid(none);
  };
  // As in PhononLimit: the wave that grows, a still one if the sides give way, none of a stable lattice.
  const auto failure = [&](double strain) -> std::optional<SoftestWave> {
    const Matrix3d F = gradient(strain);
    if (!F.allFinite()) return SoftestWave{};
    const SoftestWave wave = softest_wave(springs, cell_size, F);
    return wave.stiffness < -none ? std::optional(wave) : std::nullopt;
  };
  double failed = std::min(search_step, most);
  while (failed < most && !fails_on_grid(failed)) failed = std::min(failed + search_step, most);
  if (!failure(failed)) return {.path = path};
  double stable = failed - search_step;  // on the grid, though not always beside it
  while (stable > 0 && failure(stable)) stable -= search_step;
  stable = std::max(stable, 0.0);
  while (failed - stable > exact) {
    const double middle = (stable + failed) / 2;
    (failure(middle) ? failed : stable) = middle;
  }
  return {.path = path, .strain = failed, .wave = failure(failed).value_or(SoftestWave{})};
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
