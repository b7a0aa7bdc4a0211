#pragma once

#include <string>
#include <vector>

#include "core/environment/environment.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/plot/chart.hpp"

namespace mss::studies::contact {

/// What a sphere is pressed on.
enum class PressedOn {
  impulse,  ///< a plane of that law, whose touches vertices do not pass
  penalty,  ///< a plane of that law
  sphere    ///< an equal sphere, by contact between bodies
};
const char* to_string(PressedOn on);

/// The half of an elastic sphere whose equator is pushed towards a plane, or towards the equator of another
/// half, and rests: cells that a mesh fills, touched by the mesh's vertices, about a cell apart; no friction.
struct PressRun {
  PressedOn on{};
  int cells = 20;         ///< of the diameter
  double stiffness = 1;   ///< of contact between bodies
  double deepest = 0.04;  ///< approach over the radius
  std::string name() const;
};

/// A free sphere of these cells that hits a plane.
struct ImpactRun {
  ContactLaw law{};
  int cells = 20;
  double speed = 0;  ///< over c = sqrt(E / density)
  std::string name() const;
};

/// What `mss validate contact` computes of spheres.
struct SphereConfig {
  std::vector<PressRun> pressed{};
  std::vector<ImpactRun> impacts{};
};
SphereConfig sphere_config(bool quick);

/// The force that presses a finite sphere by d on a plane over Hertz's, by d over its radius: linear elastic,
/// equator held along the push and free across it. From graded axisymmetric finite elements, between whose
/// figures it is linear in the logarithm; from 0.0005 to 0.06.
double finite_over_hertz(double approach);

Table empty_spheres();
/// A row for every approach d. Allowed by a / h, a = sqrt(d R): of the force beside the finite sphere's 12
/// percent from 2 on, 5 from 3, 3 from 4; of the contact radius sqrt(5/2 sum p r^2 / F) beside a 15 percent
/// from 2 on, 7 from
/// 3. The status is `ok`; `off`; `not_claimed` below 2; or how the method ended.
void add_press_run(const PressRun& run, Table& rows);

Table empty_impacts();
/// Allowed at 40 cells: 5 percent of the duration beside the finite sphere's, and restitution .995. The
/// status is `ok`; `off`; `not_claimed` at other cells; `never_left`; or how the method ended. Throws
/// std::logic_error at a speed other than those of sphere_config().
void add_impact_run(const ImpactRun& run, Table& rows);

/// Worst figures, and exponents of duration by speed, a line each.
std::string sphere_summary(const Table& spheres, const Table& impacts);

Chart sphere_chart(const Table& rows);
Chart impact_chart(const Table& rows);

}  // namespace mss::studies::contact
