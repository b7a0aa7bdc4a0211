#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "core/body/body.hpp"

namespace mss::reference {

/// The thesis's Algorithm 1 as it is written: objects for particles and springs, one loop over springs that
/// adds spring and damping force to both ends with atomic operations (lines 7, 8, 12, 13), eq. 3-5 to 3-7 per
/// cell with the thesis's corner numbering, one loop over particles.
///
/// It shares no physics with core/: springs are found by walking over cells, shared ones recognised by their
/// ends. So it is an independent reference for forces and trajectories, and the baseline of the timing chart.
class Algorithm1 {
 public:
  struct Particle {
    Vec3 x;
    Vec3 v = Vec3::Zero();
    Vec3 f = Vec3::Zero();
    double mass = 0;
  };
  struct Spring {
    std::size_t p1;
    std::size_t p2;
    double stiffness;
    double rest_length;
    double damping;
    double branch = 0;   ///< stiffness of its Maxwell branch [N/m]
    double dashpot = 0;  ///< how far that branch's damper has given way [m]
  };
  struct Cell {
    std::array<std::size_t, 8> p;  ///< p[0] is the thesis's p_1
    double volume_stiffness;       ///< [Pa]
    double guard_stiffness;        ///< [Pa]
  };

  /// `threads` OpenMP threads share each loop, also more than there are cores.
  Algorithm1(const BodyConfig& config, const Vec3& gravity, int threads);

  void set_threads(int threads) { threads_ = threads; }

  std::vector<Particle>& particles() { return particles_; }
  const std::vector<Particle>& particles() const { return particles_; }
  const std::vector<Spring>& springs() const { return springs_; }
  const std::vector<Cell>& cells() const { return cells_; }
  const Vec3& gravity() const { return gravity_; }
  bool has_volume_force() const { return has_volume_force_; }
  double cell_volume() const { return cell_volume_; }

  /// Lines 1 to 14, the volume force and the guard against folding: total forces of all particles [N].
  void compute_forces();

  /// One update of all particles with semi-implicit Euler (2-12), then of dampers in Maxwell branches.
  void step(double dt);

  /// Atomic additions of numbers that an update makes: 12 a spring (lines 7, 8, 12 and 13) and, of a body
  /// with a volume force, 24 a cell. The guard against folding, which the thesis has not, makes none.
  std::size_t atomic_additions() const {
    return 12 * springs_.size() + (has_volume_force_ ? 24 * cells_.size() : 0);
  }

  /// Energy of springs, volume, guard and gravity at the current positions [J]; gravity counts from the
  /// origin.
  double potential_energy() const;

 private:
  /// What a part adds to the stiffness of a spring.
  struct Share {
    std::size_t part;
    double stiffness;
  };
  /// While springs are made: which spring joins two particles, and what its stiffness is made of.
  struct Connections {
    const BodyConfig& config;
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> spring_of;
    std::vector<std::vector<Share>> shares;  ///< by spring
  };

  void connect(const BodyConfig& config);
  void fill(Cell& cell, const PartFill& filled, Connections& connections);
  void connect_pair(std::size_t a, std::size_t b, const Share& share, Connections& connections);
  void add_dampers(const Connections& connections);
  void add_weight(const Weight& weight, double slack);
  void add_springs();
  void add_branches();
  double length_of(const Spring& spring) const {
    return (particles_[spring.p2].x - particles_[spring.p1].x).norm();
  }
  void give_way(Spring& spring, double length_before, double dt) const;
  void add_volume_forces();
  void add_guard_forces();
  double guard_energy() const;

  int threads_;
  Vec3 gravity_;
  bool has_volume_force_;
  bool is_guarded_;
  double cell_size_;
  double cell_volume_;
  Relaxation relaxation_;
  std::vector<Particle> particles_;
  std::vector<Spring> springs_;
  std::vector<Cell> cells_;
};

}  // namespace mss::reference
