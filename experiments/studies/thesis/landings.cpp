// Fig. 5-4 and section 5.2.2: from which landings the thesis's cube recovers, with its own contact and
// method, and with the remedies that the thesis names.
#include <fmt/format.h>

#include <vector>

#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/landing.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/thesis/thesis.hpp"

namespace mss::studies::thesis {

namespace {

/// The cube of Fig. 5-4 without the changes of a case: 3 x 3 x 3 cells of 0.2 m.
BodyConfig landing_cube() {
  return {.voxels = VoxelGrid::box(3, 3, 3),
          .cell_size = 0.2,
          .sharing = Sharing::uniform,
          .density = 1,
          .springs = thesis_springs,
          .damping = {.law = Damping::Law::ratio, .zeta = 0.05}};
}

BodyConfig changed_cube(const LandingCase& c) {
  BodyConfig cube = landing_cube();
  for (double* k : {&cube.springs.edge, &cube.springs.face, &cube.springs.body, &cube.springs.volume})
    *k *= c.all;
  cube.springs.body *= c.body;
  cube.fold_guard = c.fold_guard;
  return cube;
}

/// A tenth of the stable step of the body, times the factor of the case [s].
double step_of(const LandingCase& c) {
  const Body body(changed_cube(c));
  return c.step * trial_step(*make_system<double>(spring_model, body, {}, 1));
}

Table empty_landings() {
  return Table({{"case"},
                {"contact"},
                {"k_all"},
                {"k_body"},
                {"fold_guard"},
                {"dt", "s"},
                {"landing"},
                {"speed", "m/s"},
                {"max_stretch"},
                {"min_jacobian"},
                {"outcome"},
                {"status"}});
}

/// A row.
Table landing_at(const LandingCase& c, const Landing& landing, double speed) {
  Table row = empty_landings();
  const double dt = step_of(c);
  const Plane ground{.normal = landing.up, .contact = c.contact, .restitution = 0.5, .friction = 0.4};
  const RecoveryTrial trial = try_landing(spring_model, changed_cube(c), ground, speed, dt);
  const bool failed = trial.outcome == Recovery::non_finite;
  row.add({c.name, to_string(c.contact), c.all, c.body, c.fold_guard, dt, landing.name, speed,
           trial.max_stretch, trial.min_jacobian, std::string(to_string(trial.outcome)),
           std::string(failed ? "non_finite" : "ok")});
  return row;
}

}  // namespace

Table measure_landings(const ThesisConfig& config, Progress& progress) {
  Table rows = empty_landings();
  std::vector<Case> cases;
  for (const LandingCase& c : config.landing_cases)
    for (const Landing& landing : landings())
      for (const double speed : config.landing_speeds)
        cases.push_back({fmt::format("{}, {}, {:g} m/s", c.name, landing.name, speed),
                         [c, landing, speed] { return rows_of(landing_at(c, landing, speed)); }});
  Journal journal;
  gather_cases(cases, 0, journal, progress, [&](const Json& result) { add_rows(result, rows); });
  return rows;
}

}  // namespace mss::studies::thesis
