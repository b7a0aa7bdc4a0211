#include "integrators/statics/linear_response.hpp"

#include "integrators/linear/linear_solver.hpp"

namespace mss {

namespace {

/// A function of rest positions at held coordinates, 0 elsewhere.
Field<double> at_holds(const SolidSystem<double>& system,
                       const std::function<Vec3(const Vec3&)>& prescribed) {
  Field<double> all(system.size());
  if (!prescribed) return all;
  for (const std::ptrdiff_t site : system.particles()) all.set(site, prescribed(system.rest_position(site)));
  Field<double> unknown = all;
  system.clear_prescribed(unknown);
  all.array() -= unknown.array();
  return all;
}

}  // namespace

LinearResponse linear_response(SolidSystem<double>& system,
                               const std::function<Vec3(const Vec3& rest)>& prescribed, Work& work) {
  const State<double> rest = system.undeformed_state();
  const TangentCoefficients stiffness{.stiffness = 1, .kind = Tangent::elastic};
  const std::ptrdiff_t size = system.size();
  LinearResponse r{
      .displacement = Field<double>(size), .load = Field<double>(size), .reaction = Field<double>(size)};
  Tangents<double>& tangents = tangents_of(system);
  const auto solver = find_linear_solver("automatic").make(1e-12);
  system.force(0, rest.x, rest.v, r.load);
  r.status = solver->prepare(system, 0, rest.x, rest.v, stiffness, work);
  if (r.status != Status::ok) return r;
  const Field<double> held = at_holds(system, prescribed);
  Field<double> rhs(size);
  tangents.product(0, rest.x, rest.v, stiffness, held, rhs);
  rhs.array() = r.load.array() - rhs.array();
  r.status = solver->solve(rhs, r.displacement, work);
  if (r.status != Status::ok) return r;
  r.displacement.array() += held.array();
  tangents.product(0, rest.x, rest.v, stiffness, r.displacement, r.reaction);
  r.reaction.array() -= r.load.array();
  return r;
}

double inner(const SolidSystem<double>& system, const Field<double>& a, const Field<double>& b) {
  double sum = 0;
  for (const std::ptrdiff_t site : system.particles()) sum += a.at(site).dot(b.at(site));
  return sum;
}

}  // namespace mss
