#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// The time between two pictures [s].
inline constexpr double frame = 1.0 / 60;

/// Of a system whose steps are not timed; results are the same for any number.
inline constexpr int as_many_threads_as_pay = 0;

/// A body of springs in its environment: its system, how it begins, and distances between its positions.
struct MovingBody {
  /// It begins undeformed and at rest.
  MovingBody(const BodyConfig& config, const Environment& environment, int threads)
      : body(config),
        owned(make_system<double>(spring_model, body, environment, threads)),
        system(*owned),
        start(system.undeformed_state()) {}
  /// The system refers to the body.
  MovingBody(const MovingBody&) = delete;
  MovingBody& operator=(const MovingBody&) = delete;
  virtual ~MovingBody() = default;  // a study keeps bodies of several kinds by this type

  /// Sum over particles of the squared distances [m^2].
  double squared_distance(const Field<double>& a, const Field<double>& b) const {
    double sum = 0;
    for (const std::ptrdiff_t site : body.sites()) sum += (a.at(site) - b.at(site)).squaredNorm();
    return sum;
  }

  Body body;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  State<double> start;
};

/// Positions at the end of every frame.
using FramePositions = std::vector<Field<double>>;

/// Sum over frames and particles of the squared distances between two motions of as many frames [m^2].
double squared_distance(const MovingBody& body, const FramePositions& a, const FramePositions& b);
/// The same of a motion from where the body begins.
double squared_displacement(const MovingBody& body, const FramePositions& motion);

/// In tables, the status of a run that was stopped.
inline constexpr const char* too_slow = "stopped, took too long";

/// What a method makes of a number of frames.
struct MeasuredMotion {
  Status status = Status::ok;
  bool in_time = true;      ///< false: it was stopped, because it took too long
  FramePositions motion{};  ///< empty unless the status is ok and it was in time
  State<double> end{};
  double seconds = 0;  ///< wall time, making the method included
  Work work{};

  bool ok() const { return status == Status::ok && in_time; }
};

/// What looks at the ends of frames, while no time is taken.
using FrameObserver = std::function<void(const State<double>&)>;

/// From the start on; stopped at the end of the frame in which it has taken `most_seconds`.
MeasuredMotion measure_motion(const MovingBody& body, const IntegratorInfo& method,
                              const IntegratorOptions& options, int frames,
                              double most_seconds = std::numeric_limits<double>::infinity(),
                              const FrameObserver& at_frame = {});

}  // namespace mss
