#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/device/device.hpp"
#include "core/environment/tethered_system.hpp"
#include "core/springs/spring_system.hpp"

namespace mss {

/// A body of springs in its environment on a device, and what explicit methods do with it: the counterpart of
/// a SpringSystem, from which it takes its coefficients, masses, holds, loads and planes. Formulas of springs
/// and cells are the text that the processor's kernels compile (core/base/formula.hpp); what shaders write
/// anew, the guard against folding and planes, is tested against these.
///
/// Every function needs a DeviceUse. What they ask for is done in order, but not when they return.
template <class Real>
class DeviceSystem {
 public:
  /// A vector at every site, on the device.
  using Vectors = DeviceMemory;

  /// All must outlive it. Throws InputError for what a device does not do: relaxation, sleep, ranks, planes
  /// of other laws than `impulse` or that touch a surface, wrapped systems other than a TetheredSystem.
  DeviceSystem(std::shared_ptr<Device> device, System<Real>& system);

  Device& device() { return *device_; }
  const std::shared_ptr<Device>& shared_device() const { return device_; }
  const SpringSystem<Real>& springs() const { return springs_; }
  bool has_planes() const { return plane_count_ > 0; }

  Vectors make_vectors() const;
  /// From a field's stream of one axis to that of the next, the least that one number a site needs.
  std::ptrdiff_t stride() const { return stride_; }
  void write(const Field<Real>& from, Vectors& to) const;
  void read(const Vectors& from, Field<Real>& to) const;

  /// Takes over positions and velocities, and gives them back, with what planes have given since the last
  /// time. Throws DeviceLost, and planes have given nothing.
  void load(const State<Real>& state);
  void store(State<Real>& state);
  /// Keeps in a record, or takes from one, what holds the particles that stick to planes.
  void remember_sticking(Record& record);
  Vectors& x() { return x_; }
  Vectors& v() { return v_; }

  /// As System's functions of these names; `a` and stages are vectors of make_vectors().
  void acceleration(double t, const Vectors& x, const Vectors& v, Vectors& a);
  /// The same at the present state, but only if the last collide() changed something.
  void acceleration_if_collided(double t, Vectors& a);
  void constrain(double t, Vectors& x, Vectors& v);
  /// One update of the present state, which ends at a time t_end.
  void kick_drift(const KickDrift& update, double t, double t_end);
  void apply(const KickDrift& update, const Vectors& a, double t_end);
  void kicked_for(double seconds);
  /// out = base + scale added; they may be the same.
  void combine(const Vectors& base, double scale, const Vectors& added, Vectors& out);

  /// How far accelerations are from those of the system that it was made of, over the largest: in a state in
  /// which every spring is strained and every particle moves. The present state is lost.
  double error_of_accelerations(System<Real>& system, double t);

  /// Remembers the present state as that before a step; ends a step of dt from there with its collisions.
  void step_begins();
  void collide(double dt);

  /// Whether all positions and velocities are finite. Waits for the device.
  bool is_finite();

  /// Forces of loads at time t; nullptr: there are none.
  const Vectors* loads_at(double t);

  /// A shader of this body: its text after prelude, formulas and `parts`, texts of shaders/, with words
  /// defined before them. Sizes, lengths, gravity and tables are set.
  ShaderProgram& program(const std::vector<std::string>& defines, const std::vector<std::string>& parts);
  /// Sets what the part `planes` asks for, if there are planes.
  void set_planes(ShaderProgram& program);
  /// Sites of the lattice, the number of threads that shaders of sites run in.
  std::ptrdiff_t sites() const { return springs_.body().lattice().sites; }
  const std::vector<std::uint32_t>& site_kinds() const { return kinds_; }

 private:
  void describe_body();
  void find_kinds();
  void find_guard();
  void find_planes();
  void find_outer();
  void check(const System<Real>& system) const;
  std::string text_of(const std::vector<std::string>& defines, const std::vector<std::string>& parts) const;
  std::vector<std::string> force_parts(const std::string& last) const;
  void set_body(ShaderProgram& program) const;
  void set_force(ShaderProgram& program, const Vectors& x, const Vectors& v);
  void set_tether(ShaderProgram& program) const;
  void set_update(ShaderProgram& program, const KickDrift& update);
  void prepare_outer(double t, const Vectors& x);
  void update_loads(double t);
  void run_acceleration(const std::vector<std::string>& more, const Vectors& x, const Vectors& v, Vectors& a);

  std::shared_ptr<Device> device_;
  const SpringSystem<Real>& springs_;
  const TetheredSystem<Real>* tethered_;  ///< nullptr: nothing can be tied
  PlaneImpulses* impulses_;               ///< nullptr: no planes
  std::ptrdiff_t stride_ = 0, pad_ = 0;
  std::vector<std::string> defines_;                          ///< words that describe the body
  std::unordered_map<std::string, ShaderProgram*> programs_;  ///< of program(), by what it was given
  std::vector<std::uint32_t> kinds_;                          ///< by site
  DeviceMemory kind_of_, coefficients_;
  Vectors x_, v_, x_next_, v_next_, x_before_, v_before_;

  std::vector<std::ptrdiff_t> held_sites_, loaded_sites_;
  DeviceMemory held_list_, held_motion_, loaded_list_, load_values_;
  bool holds_move_ = false, loads_known_ = false;
  Field<Real> held_x_, held_v_, load_field_;  ///< where the processor finds them
  std::vector<Real> packed_;
  Vectors loads_, outer_;  ///< forces of loads; the same and the guard's

  bool guarded_ = false;
  DeviceMemory guard_stiffness_, guard_marks_;

  int plane_count_ = 0;
  double push_out_speed_ = 0;
  std::vector<double> given_here_;
  DeviceMemory planes_, given_, held_force_, held_by_, collided_, non_finite_;
};

}  // namespace mss
