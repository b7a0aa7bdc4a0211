#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "core/base/field.hpp"
#include "core/body/body.hpp"
#include "core/springs/block_matrix.hpp"
#include "core/system/step_memory.hpp"
#include "core/system/system.hpp"

namespace mss {

class Record;
template <class Real>
struct BranchKernel;
template <class Real>
struct BranchRow;

/// The Maxwell branches of a body's springs (core/body/relaxation.hpp): their tensions where the last step
/// ended, and their forces since then.
template <class Real>
class MaxwellBranches final : public StepMemory<Real> {
 public:
  /// For a system of the body, which must outlive it; the system's threads do the work. Throws InputError
  /// where several ranks share the body.
  MaxwellBranches(System<Real>& system, const Body& body);

  /// Adds their forces [N].
  void add_force(double t, const Field<Real>& x, Field<Real>& f);
  /// The same, over masses [m/s^2].
  void add_acceleration(double t, const Field<Real>& x, Field<Real>& a);

  /// Adds their tangents, as Tangents has them: to a matrix, to the blocks on its diagonal, by particle, and
  /// times p to `out`.
  void add_tangent(double t, const Field<Real>& x, const TangentCoefficients& sum, BlockMatrix& blocks) const;
  void add_diagonal(double t, const Field<Real>& x, const TangentCoefficients& sum,
                    std::vector<Eigen::Matrix3d>& diagonal) const;
  void add_product(double t, const Field<Real>& x, const TangentCoefficients& sum, const Field<Real>& p,
                   Field<Real>& out) const;

  /// Stored where the last step ended, and further at positions x [J].
  double energy(const Field<Real>& x) const;
  /// By their dampers, until the last step's end [J].
  double dissipated() const { return dissipated_; }

  void come_to(const State<Real>& state) override;
  void forget() override { t_ = long_ago; }
  void remember(Record& record);

 private:
  static constexpr double long_ago = -std::numeric_limits<double>::infinity();

  /// Nothing is left of tensions, and none arise: strains have been there for ever.
  bool is_relaxed() const { return t_ == long_ago; }
  BranchStep step_to(double t) const { return {relaxation_, std::max(0.0, t - t_)}; }
  BranchRow<Real> row(std::size_t slot, int plane, const BranchStep& step, const Field<Real>& x);
  void add_plane(int plane, const BranchStep& step, const Field<Real>& x, Field<Real>& f);
  /// Calls visit(site, slot, -dF/dd times `sum.stiffness` [N/m]), F the force on a spring's first end and d
  /// the difference of its ends.
  template <class Visit>
  void for_each_tangent(double t, const Field<Real>& x, const TangentCoefficients& sum, Visit&& visit) const;
  /// Calls visit(site, slot, index of the branch) for every branch.
  template <class Visit>
  void for_each_branch(Visit&& visit) const;
  double advance_plane(int plane, const BranchStep& step, const Field<Real>& x);
  Vec3 ends_apart(const Field<Real>& x, std::ptrdiff_t site, const SpringSlot& slot) const {
    return x.at(site + body_.lattice().corner(slot.b)) - x.at(site + body_.lattice().corner(slot.a));
  }
  std::size_t index(std::size_t slot, std::ptrdiff_t site) const {
    return slot * std::size_t(body_.lattice().sites) + std::size_t(site);
  }

  System<Real>& system_;
  const Body& body_;
  Relaxation relaxation_;
  const BranchKernel<Real>& kernel_;
  double t_ = long_ago;          ///< where the last step ended [s]
  double dissipated_ = 0;        ///< until then [J]
  std::vector<Real> stiffness_;  ///< by slot, then site [N/m]
  std::vector<Real> length_;     ///< where the last step ended [m]
  std::vector<Real> tension_;    ///< the same [N]
  std::vector<Real> mobility_;   ///< by site, 1 over its mass [1/kg]
  Field<Real> force_;            ///< of add_acceleration()
};

}  // namespace mss
