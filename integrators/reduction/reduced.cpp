// The coordinates of a reduced body (core/system/reduced_motion.hpp), in steps that its model takes: between
// two moments all of one length, at most solve.dt where that is given.
#include <algorithm>
#include <cmath>

#include "core/base/record.hpp"
#include "core/system/reduced_motion.hpp"
#include "integrators/integrator.hpp"

namespace mss {

namespace {

class Reduced final : public Integrator<double> {
 public:
  explicit Reduced(double longest_step) : longest_step_(longest_step) {}

  void reset() override { has_coordinates_ = false; }

  void remember(System<double>& system, Record& record) override {
    record.keep(has_coordinates_);
    if (has_coordinates_) record.keep(*system.reduced());
  }

 private:
  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    ReducedMotion& motion = *system.reduced();
    if (!has_coordinates_) motion.take(state);
    has_coordinates_ = true;
    const double span = t_end - state.t;
    if (!(span > 0)) return Status::ok;
    const double longest = std::min(motion.longest_step(), longest_step_ > 0 ? longest_step_ : span);
    const long steps = std::max(1L, long(std::ceil(span / longest - 1e-9)));
    const bool finite = motion.step(span / double(steps), steps);
    work.steps += steps;
    if (!finite) return Status::non_finite;
    motion.give(state);
    state.t = t_end;
    return Status::ok;
  }

  double longest_step_;
  bool has_coordinates_ = false;
};

}  // namespace

IntegratorInfo reduced() {
  return {.name = "reduced",
          .summary =
              "few coordinates of a reduced body (material.model = \"modal\" and others): vibrations "
              "exactly, others in small steps",
          .stepping = Stepping::reduced,
          .order_undamped = 2,
          .order_damped = 1,
          .collisions = Collisions::never,
          .make_double = [](const IntegratorOptions& options) -> std::unique_ptr<Integrator<double>> {
            return std::make_unique<Reduced>(options.dt);
          }};
}

}  // namespace mss
