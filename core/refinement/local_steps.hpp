#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/kernels/local_step.hpp"
#include "core/refinement/local_step_plan.hpp"
#include "core/refinement/refined_system.hpp"
#include "core/system/system_wrapper.hpp"

namespace mss {

/// A refined body in steps that only its largest cells resolve: local time stepping for methods with one
/// force a step, whose steps add v = v + dt a, x = x + dt v.
///
/// In place of a = M^-1 f(x_n) they get 2 (z_p - x_n) / dt^2, where z goes in p short steps from x_n under
/// forces of which those between particles that are not fast stay what they are at x_n,
///   d_1 = dt^2/(w delta) a(d_0),
///   d_{k+1} = 2 delta T_k/T_{k+1} d_k - T_{k-1}/T_{k+1} d_{k-1} + 2 T_k/(w T_{k+1}) dt^2 a(d_k),   z = x_n +
///   d,
/// with T_k Chebyshev's polynomials at delta and w = 2 T_p'/T_p (ChebyshevFilter). Fast particles are those
/// of the fast levels and the masters of what hangs there; forces see only these move. Where some are faster
/// still, a(d_k) is itself what short steps in the short step give: with A = M^-1 K, S the polynomial of
/// short steps and P the fast particles, B = S(A P) A replaces A, and S(B P) B in turn B, all of them
/// symmetric in M.
///
/// With delta = 1 it is Diaz and Grote, SIAM J. Sci. Comput. 31 (2009) 1985, and with several rates Comput.
/// Methods Appl. Mech. Engrg. 291 (2015) 240, unstable at some steps below the limit; delta = 1 + nu/p^2, nu
/// = 0.01 and more where there is damping, stabilises it: Grote, Michel and Sauter, arXiv 2005.13350. Dampers
/// see the velocities at the beginning of the step. Linear momentum is exact, angular momentum up to the
/// square of the step.
template <class Real>
class LocalSteps final : public SystemWrapper<Real> {
 public:
  /// For steps of dt [s]. The system must outlive it.
  LocalSteps(RefinedSystem<Real>& system, const Environment& of_level, double dt, int threads);

  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override {
    system_.force(t, x, v, f);
  }
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;
  bool in_local_steps() const override { return true; }
  /// The most of a rate's cells.
  double threads_working() const override;

 private:
  using Levels = std::vector<Field<Real>>;
  using Flags = std::vector<std::vector<bool>>;  ///< by level and site

  /// The cells of a level whose forces are computed equally often.
  struct Part {
    Part(std::size_t level_index, const BodyConfig& config, const Environment& environment, int threads)
        : level(level_index), body(config), system(body, environment, Execution{.threads = threads}) {}
    std::size_t level;
    Body body;
    SpringSystem<Real> system;
  };
  /// A level's planes from the first to the last that forces of a rate's cells act on, or of quicker ones.
  struct Span {
    Span(std::size_t level_, const Lattice& lattice, int first_, int last_)
        : level(level_), first(first_), last(last_) {
      for (auto* field : {&mobility, &frozen, &before, &now})
        *field = Field<Real>(lattice.plane * (last - first));
    }
    std::size_t level;
    int first, last;            ///< planes
    std::vector<Real> moves{};  ///< 1; 0: its force changes, but forces do not see it move; empty: all 1
    Field<Real> mobility;       ///< inverse mass; 0 where it is held
    Field<Real> frozen;         ///< forces of slower cells
    Field<Real> before, now;    ///< d_{k-1}, d_k
  };
  struct ShortStep {
    Real of_now, of_before, of_acceleration;
  };
  /// Cells whose forces are computed equally often, and how what they act on moves. The slowest has no spans.
  struct Rate {
    std::size_t first_level = 0;
    std::vector<std::unique_ptr<Part>> parts{};
    Levels force{};  ///< of these cells; without a size where they do not act
    std::vector<Span> spans{};
    std::vector<ShortStep> short_steps{};  ///< to d_1, ... d_p
    Real acceleration_of_move = 0;         ///< 2 / dt^2, of the step that the short ones are in
  };

  std::vector<Flags> find_fast() const;
  void split_cells(const std::vector<Flags>& fast, const Environment& of_level, int threads);
  void find_spans(const std::vector<Flags>& fast);
  void find_short_steps();

  /// Not where the quickest plan has none.
  bool has_short_steps() const { return rates_.size() > 1; }
  void accelerate(double t);
  void respond(std::size_t r, double t);
  void sum_forces(std::size_t r, double t);
  void take_short_steps(std::size_t r, double t);
  void freeze(std::size_t r);
  void displace(std::size_t r, std::size_t k);
  void displace_plane(std::size_t r, std::size_t k, Span& span, int plane);
  const Span* span_of(std::size_t r, std::size_t level) const;

  RefinedSystem<Real>& system_;
  LocalStepPlan plan_;
  double dt_;
  void (*short_step_)(const ShortStepPlane<Real>&);  ///< of the system's instruction set
  std::vector<Rate> rates_;
  Levels moved_, inverse_mass_;
};

}  // namespace mss
