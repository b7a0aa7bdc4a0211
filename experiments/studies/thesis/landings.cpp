// Fig. 5-4 and section 5.2.2: from which landings the thesis's cube recovers, with its own contact and
// method, and with the remedies that the thesis names.
#include <cmath>
#include <limits>

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

}  // namespace

Table measure_landings(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"case"},
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
  for (const LandingCase& c : config.landing_cases)
    for (const Landing& landing : landings())
      for (const double speed : config.landing_speeds) {
        if (progress.stopped()) return rows;
        const double dt = step_of(c);
        const Plane ground{.normal = landing.up, .contact = c.contact, .restitution = 0.5, .friction = 0.4};
        const RecoveryTrial trial = try_landing(spring_model, changed_cube(c), ground, speed, dt);
        const bool failed = trial.outcome == Recovery::non_finite;
        rows.add({c.name, to_string(c.contact), c.all, c.body, c.fold_guard, dt, landing.name, speed,
                  trial.max_stretch, trial.min_jacobian, std::string(to_string(trial.outcome)),
                  std::string(failed ? "non_finite" : "ok")});
      }
  return rows;
}

}  // namespace mss::studies::thesis
