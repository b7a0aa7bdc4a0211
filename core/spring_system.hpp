#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/body.hpp"
#include "core/environment.hpp"
#include "core/sweep.hpp"
#include "core/system.hpp"
#include "core/tangent.hpp"
#include "core/team.hpp"

namespace mss {

/// How a SpringSystem computes. No choice here changes what is computed beyond rounding, and the number of
/// threads not even that.
struct Execution {
  int threads = 0;       ///< 0: as many as pay
  std::string kernel{};  ///< name of a sweep kernel; empty: the fastest this processor runs
};

/// A mass-spring body in its environment, driven through the structured sweep.
///
/// Threads own slabs of planes. A slab's first plane is finished last, when the slab below has left its
/// share.
template <class Real>
class SpringSystem final : public System<Real> {
 public:
  /// The body must outlive the system. Throws InputError for an unknown kernel.
  SpringSystem(const Body& body, const Environment& environment, const Execution& execution = {});
  ~SpringSystem() override;

  const Body& body() const { return body_; }
  const Environment& environment() const { return environment_; }
  const LoadedSites& loads() const { return loads_; }
  int threads() const { return team_.size(); }
  const char* kernel_name() const { return kernel_.name; }

  /// The body at rest at t = 0, where holds put it.
  State<Real> rest_state() const;

  std::ptrdiff_t size() const override { return body_.lattice().size; }
  const std::vector<std::ptrdiff_t>& particles() const override { return body_.sites(); }
  double mass(std::ptrdiff_t site) const override { return body_.mass(site); }

  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override;
  void clear_prescribed(Field<Real>& field) const override { held_.clear(field); }
  const std::vector<Unknown>& unknowns() override { return assembler().unknowns(); }
  SparseMatrix tangent_pattern() override { return assembler().pattern(); }
  void tangent(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
               SparseMatrix& matrix) override;
  void tangent_product(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                       const Field<Real>& p, Field<Real>& out) override;
  void tangent_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                        std::vector<Eigen::Matrix3d>& blocks) override;
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override;
  void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const override;
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;

 private:
  struct Slab;
  enum class Finish { force, acceleration, product, kick_drift };
  struct Pass;

  TangentAssembler& assembler();
  void build_dictionary();
  void build_masses();
  void run(const Pass& pass, long steps);
  void step_slab(const Pass& pass, int rank, long step);
  void sweep_plane(const Pass& pass, int plane, const Streams<Real>& own, const Streams<Real>& above,
                   const ConstStreams<Real>* below, double t);
  void finish_plane(const Pass& pass, int plane, std::ptrdiff_t first, std::ptrdiff_t last,
                    const Streams<Real>& own, const ConstStreams<Real>& below, double t);

  const Body& body_;
  Environment environment_;
  HeldSites held_;
  LoadedSites loads_;
  SweepKernel<Real> kernel_;
  Team team_;
  bool damped_;
  std::unique_ptr<TangentAssembler> assembler_;  ///< made by the first method that needs it

  std::ptrdiff_t blocks_;               ///< per plane
  std::vector<std::uint32_t> entry_;    ///< per plane and block: dictionary entry
  std::vector<std::uint32_t> content_;  ///< per entry
  AlignedArray<Real> dictionary_;
  AlignedArray<Real> inverse_mass_;
  Field<Real> nothing_below_;  ///< the lowest plane's share from below: zero
  std::vector<std::unique_ptr<Slab>> slabs_;
};

}  // namespace mss
