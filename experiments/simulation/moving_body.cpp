#include "experiments/simulation/moving_body.hpp"

#include "experiments/harness/measure.hpp"

namespace mss {

double squared_distance(const MovingBody& body, const FramePositions& a, const FramePositions& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += body.squared_distance(a[i], b[i]);
  return sum;
}

double squared_displacement(const MovingBody& body, const FramePositions& motion) {
  double sum = 0;
  for (const Field<double>& x : motion) sum += body.squared_distance(x, body.start.x);
  return sum;
}

MeasuredMotion measure_motion(const MovingBody& body, const IntegratorInfo& method,
                              const IntegratorOptions& options, int frames, double most_seconds,
                              const FrameObserver& at_frame) {
  MeasuredMotion run{.end = body.start};
  std::unique_ptr<Integrator<double>> integrator;
  for (int i = 1; i <= frames && run.ok(); ++i) {
    run.seconds += seconds_of([&] {
      if (!integrator) integrator = method.make<double>(options);
      run.status = integrator->advance(body.system, run.end, i * frame, run.work);
    });
    if (run.status == Status::ok && !run.end.x.array().isFinite().all()) run.status = Status::non_finite;
    if (at_frame && run.status == Status::ok) at_frame(run.end);
    run.motion.push_back(run.end.x);
    run.in_time = i == frames || run.seconds < most_seconds;
  }
  if (!run.ok()) run.motion.clear();
  return run;
}

}  // namespace mss
