#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/refined_system.hpp"
#include "core/system_wrapper.hpp"

namespace mss {

/// Which levels of a refined body take several short steps in each of the others'.
struct LocalStepPlan {
  std::size_t first_fast = 0;  ///< level; 0: all
  int substeps = 1;            ///< p
  double largest_step = 0;     ///< stable [s]
};

/// The quickest of the possible ones, of levels with these bounds and particle counts.
struct LevelCost {
  int depth;
  std::size_t particles;
  SpectralBound bound;
};
LocalStepPlan plan_local_steps(const std::vector<LevelCost>& levels);

/// A refined body in steps that only its larger cells resolve: local time stepping for methods with one force
/// a step, whose steps add v = v + dt a, x = x + dt v.
///
/// In place of M^-1 f(x_n) they get 2 (z_p - x_n) / dt^2, where z goes in p short steps from x_n under forces
/// of which those between particles that are not fast stay what they are at x_n,
///   d_1 = dt^2/(w delta) a(d_0),
///   d_{k+1} = 2 delta T_k/T_{k+1} d_k - T_{k-1}/T_{k+1} d_{k-1} + 2 T_k/(w T_{k+1}) dt^2 a(d_k),   z = x_n +
///   d,
/// with T_k Chebyshev's polynomials at delta = 1 + nu/p^2 and w = 2 T_p'/T_p. Fast particles are those of the
/// fast levels and the masters of what hangs there; forces see only these move. With nu = 0 it is Diaz and
/// Grote, SIAM J. Sci. Comput. 31 (2009) 1985, unstable at some steps below the limit; nu = 0.01 and more
/// where there is damping, stabilises it: Grote, Michel and Sauter, arXiv 2005.13350. Dampers see the
/// velocities at the beginning of the step. Linear momentum is exact, spin up to the square of the step.
template <class Real>
class LocalSteps final : public SystemWrapper<Real> {
 public:
  /// For steps of dt [s]. The system must outlive it.
  LocalSteps(RefinedSystem<Real>& system, const Environment& of_level, double dt, int threads);

  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override {
    system_.force(t, x, v, f);
  }
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;

 private:
  /// A level's cells, or some of them.
  struct Part {
    Part(std::size_t level_index, const BodyConfig& config, const Environment& environment, int threads)
        : level(level_index), body(config), system(body, environment, Execution{.threads = threads}) {}
    std::size_t level;
    Body body;
    SpringSystem<Real> system;
  };
  /// Particles of a level that forces of fast cells act on, and their displacements since the step began.
  struct FastLevel {
    std::size_t level = 0;
    std::vector<std::int32_t> sites{};
    std::vector<Real> moves{};                    ///< 1; 0: its forces change, but forces do not see it move
    std::array<std::vector<Real>, 3> mobility{};  ///< by axis: inverse mass; 0 where it is held
    std::array<std::vector<Real>, 3> before{}, now{};  ///< by axis: d_{k-1}, d_k
  };
  using Levels = std::vector<Field<Real>>;

  void split_cells(const Environment& of_level, int threads);
  void find_fast_sites();
  void add_slow_forces(double t);
  void take_substeps(double t);
  void displace(Real of_now, Real of_before, Real of_force);

  RefinedSystem<Real>& system_;
  LocalStepPlan plan_;
  double dt_;
  std::vector<std::unique_ptr<Part>> slow_, fast_;
  std::vector<std::vector<bool>> is_fast_;  ///< by level and site
  std::vector<FastLevel> sites_;
  Levels slow_force_, fast_force_, moved_, inverse_mass_;
};

}  // namespace mss
