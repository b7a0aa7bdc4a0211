#include "experiments/simulation/held_cube.hpp"

#include "experiments/harness/measure.hpp"

namespace mss {

double squared_distance(const HeldCube& cube, const FramePositions& a, const FramePositions& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += cube.squared_distance(a[i], b[i]);
  return sum;
}

double squared_displacement(const HeldCube& cube, const FramePositions& motion) {
  double sum = 0;
  for (const Field<double>& x : motion) sum += cube.squared_distance(x, cube.start.x);
  return sum;
}

MeasuredMotion measure_motion(const HeldCube& cube, const IntegratorInfo& method,
                              const IntegratorOptions& options, int frames, double most_seconds) {
  MeasuredMotion run{.end = cube.start};
  std::unique_ptr<Integrator<double>> integrator;
  for (int i = 1; i <= frames && run.ok(); ++i) {
    run.seconds += seconds_of([&] {
      if (!integrator) integrator = method.make<double>(options);
      run.status = integrator->advance(cube.system, run.end, i * frame, run.work);
    });
    run.motion.push_back(run.end.x);
    run.in_time = i == frames || run.seconds < most_seconds;
  }
  if (run.status == Status::ok && !run.end.x.array().isFinite().all()) run.status = Status::non_finite;
  if (!run.ok()) run.motion.clear();
  return run;
}

}  // namespace mss
