#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/base/record.hpp"
#include "core/environment/plane_bounds.hpp"
#include "core/system/plane_impulses.hpp"
#include "core/system/system_wrapper.hpp"
#include "integrators/linear/rest_cycle.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

/// Of a residual, to the impulse of gravity, at which a stage with contact is solved.
inline constexpr double contact_tolerance = 1e-8;

/// Another system during an implicit stage, with contact inside: an active set of particles that planes hold.
///
/// A particle that a plane touches is held along the normal while the plane pushes, and let go when it would
/// have to pull. It sticks, held along the plane too, while the force that this takes lies in Coulomb's cone;
/// otherwise it slides under friction mu p against its motion, with a pressure p that is known before an
/// iteration, so that tangents stay symmetric. What holds a particle is an impulse p = M (v - v_base) - gamma
/// f [N s]. Alart and Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353; Bertails-Descoubes et al.,
/// ACM TOG 30 (2011) 6, for the exact cone.
///
/// An obstacle bounds a particle in a stage by a plane, see PlaneBounds, of whose point velocities of sliding
/// are relative.
///
/// Held directions count as prescribed: clear_prescribed() removes them, and tangents hold them. The set
/// stays from stage to stage.
class BoundedSystem final : public SystemWrapper<double> {
 public:
  /// Of a system with bounds, which must outlive it. Throws InputError for more than 64 planes.
  explicit BoundedSystem(System<double>& other);

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    other().force(t, x, v, f);
  }
  void acceleration(double t, const Field<double>& x, const Field<double>& v, Field<double>& a) override {
    other().acceleration(t, x, v, a);
  }
  void clear_prescribed(Field<double>& field) const override;
  Tangents<double>* tangents() override { return other().tangents() ? &tangents_ : nullptr; }

  /// Begins a stage with the set of the last one.
  void begin(const ImplicitStage& stage);
  /// Lets go of everything, for a stage to be solved once more.
  void let_go() { touches_.clear(); }

  /// What velocities must change by for held particles to be where, and as slow as, they must: false if
  /// nothing, to rounding, which is then mended in `v`.
  bool jump(Field<double>& v, Field<double>& change) const;
  /// Adds impulses of friction on what slides to gamma f - M (v - v_base).
  void add_friction(const Field<double>& v, Field<double>& impulse);
  /// Changes the set after a move to `v`; `residual` is gamma f - M (v - v_base) there, without friction and
  /// with all its components. True if it changed. What holds a particle must be wrong by more than a third of
  /// `doubt` [N s], the norm of what is not solved yet, for it to be let go.
  bool update(const Field<double>& residual, const Field<double>& v, double doubt = 0);
  /// Lets friction follow the pressure that update() found; the largest change [N s].
  double follow_pressure();
  /// The same before a step is taken: `residual` is what is expected after it. Adds the change of friction to
  /// what is `left` to solve.
  /// Nothing happens if that would be more than `most`.
  double expect_pressure(const Field<double>& residual, double most, Field<double>& left);
  /// The system without contact.
  System<double>& unbounded() { return other(); }
  bool slides() const;
  /// The least speed of what slides: friction's direction is as sure as changes of velocity are small to it.
  double slowest(const Field<double>& v) const;
  /// How hard planes push by the last residual, the norm over particles [N s].
  double push() const;
  /// What is held, at velocities that say where friction points.
  std::vector<HeldParticle> held(const Field<double>& v) const;
  /// Puts all particles in front of planes, where iterations end before the set has settled.
  void put_in_front(Field<double>& v);
  /// Ends a stage: keeps the impulses that hold particles, with `residual` as in update().
  void end_stage(const ImplicitStage& stage, const Field<double>& residual);

  /// The impulse of gravity in a stage or a share of momentum, a measure of what is small [N s].
  double scale() const { return scale_; }
  /// See NonlinearSolver::end_step().
  void end_step(const StepTaken& step, State<double>& state, Field<double>* a);
  /// The set, where the next stage begins.
  void remember(Record& record) { record.keep(touches_, in_step_, touched_); }

  /// Particles that planes hold.
  std::size_t touching() const { return touches_.size(); }

 private:
  using Planes = std::uint64_t;  ///< a bit each
  struct Touch {
    Planes planes = 0;
    bool sticks = false;
    Vec3 direction = Vec3::Zero();                   ///< in which it slides
    double limit = 0;                                ///< of friction, mu p [N s]
    double pressure = 0;                             ///< what it would be by the last residual [N s]
    double expected = 0;                             ///< the same by what is expected of a step [N s]
    double push = 0;                                 ///< p by that, of all planes [N s]
    int changes = 0;                                 ///< in this stage
    Eigen::Matrix3d held = Eigen::Matrix3d::Zero();  ///< projects onto directions in which it cannot move
    Eigen::Matrix3d slip = Eigen::Matrix3d::Zero();  ///< onto those in which it can

    void remember(Record& record) {
      record.keep(planes, sticks, direction, limit, pressure, expected, push, changes, held, slip);
    }
  };

  class BoundedTangents final : public Tangents<double> {
   public:
    explicit BoundedTangents(BoundedSystem& system) : system_(system) {}
    const std::vector<FreeDof>& unknowns() override { return other().unknowns(); }
    SparseMatrix pattern() override { return other().pattern(); }
    bool has_fixed_pattern() const override { return other().has_fixed_pattern(); }
    void values(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                SparseMatrix& matrix) override;
    void product(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                 const Field<double>& p, Field<double>& out) override;
    void diagonal(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                  std::vector<Eigen::Matrix3d>& blocks) override;

   private:
    Tangents<double>& other() const { return *system_.other().tangents(); }
    BoundedSystem& system_;
  };

  void remember_touches();
  std::vector<std::size_t> indices(Planes planes) const;
  void find_obstacles(const ImplicitStage& stage);
  MovingPlane plane(std::size_t p, std::ptrdiff_t site) const {
    const std::size_t planes = bounds_.planes().size();
    return p < planes ? MovingPlane{bounds_.planes()[p]} : met_[p - planes][std::size_t(site)].plane;
  }
  Vec3 velocity(std::ptrdiff_t site, Planes planes) const;
  void give(std::ptrdiff_t site, Planes planes, const Vec3& impulse, bool must_push = false);
  Vec3 contact_position(std::ptrdiff_t site, const Field<double>& v) const;
  double gap(std::size_t plane, std::ptrdiff_t site, const Vec3& x) const;
  void set_directions(std::ptrdiff_t site, Touch& touch) const;
  void turn(std::ptrdiff_t site, Touch& touch) const;
  Eigen::Matrix3d friction_block(std::ptrdiff_t site, const Touch& touch, const Field<double>& v) const;
  bool sticks_at_first(std::ptrdiff_t site, Planes planes) const;
  bool close_deepest(const Field<double>& v);
  bool close(std::ptrdiff_t site, const Field<double>& v, const std::vector<double>& from);
  double pressures(std::ptrdiff_t site, const Touch& touch, const Vec3& reaction,
                   std::vector<std::pair<std::size_t, double>>& by_plane) const;
  bool judge(std::ptrdiff_t site, Touch& touch, const Vec3& reaction, const Vec3& v, double doubt);

  /// An obstacle's plane for a particle in this stage.
  struct Met {
    MovingPlane plane;
    double allowed = 0;  ///< the gap that it asks for, 0 or less [m]
  };

  const PlaneBounds& bounds_;
  BoundedTangents tangents_;
  const Field<double>* start_ = nullptr;  ///< of the step
  const Field<double>* base_ = nullptr;   ///< particles must be in front of planes at base + gamma v
  double gamma_ = 0;                      ///< [s]
  double t_ = 0;                          ///< where that is so [s]
  std::vector<std::vector<Met>> met_;     ///< by obstacle, by site
  double scale_ = 0;
  double length_ = 0;                                     ///< of a body, for what is small [m]
  std::map<std::ptrdiff_t, Touch> touches_;               ///< by site
  std::vector<std::pair<std::size_t, double>> by_plane_;  ///< scratch
  bool in_step_ = false;                                  ///< after its first stage has begun
  std::map<std::ptrdiff_t, Planes> touched_;              ///< planes, in stages of this step
};

/// See Integrator::remember(): of a system with bounds, or of none if there has been no step yet.
void remember_bounded(System<double>& system, Record& record, std::shared_ptr<BoundedSystem>& bounded);

}  // namespace mss
