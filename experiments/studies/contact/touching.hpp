#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "core/bodies/bodies_system.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::contact {

/// Bodies of springs that may touch, in one system, moved by a method of fixed step.
class TouchingBodies {
 public:
  /// At rest, by steps of this share of the safe one. Surfaces as BodiesSystem takes them.
  TouchingBodies(const std::vector<BodyConfig>& configs, const Environment& environment,
                 const std::string& integrator, double share_of_step,
                 const BodiesSystem<double>::Surfaces& surfaces = {});

  BodiesSystem<double>& system() { return *system_; }
  const BodiesSystem<double>& system() const { return *system_; }
  State<double>& state() { return state_; }
  const State<double>& state() const { return state_; }
  const std::vector<Level>& levels() const { return system_->levels(); }
  double dt() const { return dt_; }
  const Body& body(std::size_t index) const { return bodies_[index]; }

  /// Adds a velocity and, about the body's centre of mass, an angular one.
  void push(std::size_t body, const Vec3& velocity, const Vec3& angular_velocity = Vec3::Zero());
  Status step();

  /// Sum of m x, or m v, over a body's mass.
  Vec3 mean(std::size_t body, const Field<double>& field) const;
  double kinetic() const;
  /// Kinetic, stored, and of contact [J].
  double energy() const;

 private:
  std::deque<Body> bodies_;
  std::unique_ptr<BodiesSystem<double>> system_;
  State<double> state_;
  double dt_ = 0;
  std::unique_ptr<Integrator<double>> method_;
  Work work_;
};

}  // namespace mss::studies::contact
