#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// The time between two pictures [s].
inline constexpr double frame = 1.0 / 60;

/// A cube of springs, 1 m and 1000 kg/m^3, held at the face x = 0 and straight at the start: its system, and
/// distances between positions.
struct HeldCube {
  /// `ratio` of damping to critical, of every spring. Without loads it is under gravity.
  HeldCube(const ElasticConstants& material, int cells, double ratio, int threads,
           const std::vector<Load>& loads = {})
      : body(unit_cube(material, 1000, cells, ratio)),
        owned(make_system<double>(spring_model, body,
                                  {.gravity = loads.empty() ? Vec3(0, 0, -9.81) : Vec3(0, 0, 0),
                                   .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}},
                                   .loads = loads},
                                  threads)),
        system(*owned),
        start(system.undeformed_state()) {}
  /// The system refers to the body.
  HeldCube(const HeldCube&) = delete;
  HeldCube& operator=(const HeldCube&) = delete;

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
double squared_distance(const HeldCube& cube, const FramePositions& a, const FramePositions& b);
/// The same of a motion from the straight cube.
double squared_displacement(const HeldCube& cube, const FramePositions& motion);

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

/// From the start on; stopped at the end of the frame in which it has taken `most_seconds`.
MeasuredMotion measure_motion(const HeldCube& cube, const IntegratorInfo& method,
                              const IntegratorOptions& options, int frames,
                              double most_seconds = std::numeric_limits<double>::infinity());

}  // namespace mss
