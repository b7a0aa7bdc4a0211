#pragma once

#include <array>
#include <vector>

#include "core/base/record.hpp"
#include "integrators/device/device_integrator.hpp"

namespace mss {

/// The sites of a lattice that have something, sorted into eight colours by the parity of their coordinates:
/// as ColouredLattice in integrators/position_based/, no two of a colour are neighbours.
struct SitesByColour {
  static constexpr int colours = 8;

  /// `sites` ascending.
  SitesByColour(const Lattice& lattice, const std::vector<std::ptrdiff_t>& sites);

  int count(int colour) const { return first[std::size_t(colour) + 1] - first[std::size_t(colour)]; }

  std::vector<std::ptrdiff_t> sites{};  ///< one colour after the other
  std::array<int, colours + 1> first{};
};

/// Planes during such passes: DisplacementContact on a device.
template <class Real>
class ContactOnDevice {
 public:
  using Vectors = typename DeviceSystem<Real>::Vectors;

  /// The parts of shaders that have planes and multipliers.
  static const std::vector<std::string> parts;

  explicit ContactOnDevice(DeviceSystem<Real>& system);

  /// Begins a step of dt [s] whose displacements are u.
  void begin_step(DeviceSystem<Real>& system, double dt, const Vectors& u);
  /// Applies planes after a colour has been passed over.
  void project(DeviceSystem<Real>& system, double dt, int colour, const Vectors& u);
  /// Ends passes and the step.
  void end_step(DeviceSystem<Real>& system, double dt, const Vectors& u);

  /// Moves what is behind a plane onto it, and finds impact(); what pushes() is forgotten.
  void put_in_front(DeviceSystem<Real>& system, double dt, const Vectors& u);
  /// The plane that a particle comes to in this step, see DisplacementContact; -1: none. Waits for the
  /// device.
  int impact() const;
  /// Whether a plane pushed a particle in the last step that has ended: a buffer that begins with a flag.
  const DeviceMemory& pushes() const { return meetings_; }
  /// Sets what `parts` ask for.
  void set_planes(DeviceSystem<Real>& system, ShaderProgram& program);
  /// Which particles planes have pushed in the last step. See core/base/record.hpp.
  void remember(DeviceSystem<Real>& system, Record& record);

 private:
  struct Meetings {
    std::uint32_t any_pushed = 0, comes_to = UINT32_MAX;
  };
  ShaderProgram& program(DeviceSystem<Real>& system, const std::string& part, double dt, const Vectors& u);

  DeviceMemory near_, multipliers_, meetings_;
};

/// Methods whose steps are passes that move particles by displacements u = x - x_n: their beginning and end,
/// as PositionBasedIntegrator has them on the processor.
template <class Real>
class DisplacedSteps : public StepsOnDevice<Real> {
 public:
  int forces_in_step() const final { return passes_; }
  void begin(DeviceSystem<Real>& system) override;
  void take(DeviceSystem<Real>& system, double t, double dt, long steps) final;

 protected:
  using Vectors = typename DeviceSystem<Real>::Vectors;

  /// In steps of dt [s].
  DisplacedSteps(double dt, int passes) : dt_(dt), passes_(passes) {}

  /// Leaves in u where passes begin, by displacement().
  virtual void displace(DeviceSystem<Real>& system, double t) = 0;
  /// What else passes need, when contact has begun.
  virtual void begin_passes(DeviceSystem<Real>& system) = 0;
  virtual void pass(DeviceSystem<Real>& system) = 0;

  /// The shader `displace`, ready for XPBD, whose passes begin where particles would be without springs.
  ShaderProgram& displacement(DeviceSystem<Real>& system, double t, std::vector<std::string> words);
  Vectors& u() { return u_; }
  double dt() const { return dt_; }
  ContactOnDevice<Real>* contact() { return contact_ ? &*contact_ : nullptr; }

 private:
  void settle(DeviceSystem<Real>& system);

  double dt_;
  int passes_;
  bool holds_move_ = false;
  Vectors u_, end_x_, end_v_;  ///< the latter where holds move
  std::optional<ContactOnDevice<Real>> contact_;
};

extern template class ContactOnDevice<float>;
extern template class ContactOnDevice<double>;

}  // namespace mss
