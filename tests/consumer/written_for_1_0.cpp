// A program as it was written for mss 1.0. It must compile and run with every 1.x: nothing here may be
// changed for a change of the library to pass. What later versions promise is added in files of their own.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mss/core/base/error.hpp>
#include <mss/core/base/record.hpp>
#include <mss/core/bodies/bodies_measures.hpp>
#include <mss/core/bodies/bodies_system.hpp>
#include <mss/core/environment/environment.hpp>
#include <mss/core/measures/measures.hpp>
#include <mss/core/mesh/triangle_mesh.hpp>
#include <mss/core/scene/scene.hpp>
#include <mss/core/springs/spring_system.hpp>
#include <mss/core/system/system_wrapper.hpp>
#include <mss/integrators/analysis/modes.hpp>
#include <mss/integrators/analysis/stable_step.hpp>
#include <mss/integrators/fixed_step.hpp>
#include <string>
#include <vector>

namespace {

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "written_for_1_0: not so: %s\n", what);
  std::exit(1);
}

mss::BodyConfig block(const mss::Vec3& origin) {
  mss::BodyConfig config{.voxels = mss::VoxelGrid::box(2, 2, 2), .cell_size = 0.05, .origin = origin};
  config.density = 1000;
  config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
  config.damping = {.law = mss::Damping::Law::ratio, .zeta = 0.05};
  return config;
}

/// A method of one's own.
template <class Real>
class Leapfrog final : public mss::Integrator<Real> {
 public:
  explicit Leapfrog(double dt) : dt_(dt) {}
  mss::Status do_advance(mss::System<Real>& system, mss::State<Real>& state, double t_end,
                         mss::Work& work) override {
    return mss::advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      for (long n = 0; n < steps; ++n) step(system, state);
      work.force_evaluations += steps;
    });
  }

 private:
  void step(mss::System<Real>& system, mss::State<Real>& state) {
    if (a_.size() == 0) a_ = state.v;
    state.x.array() += static_cast<Real>(dt_ / 2) * state.v.array();
    system.constrain(state.t + dt_ / 2, state.x, state.v);
    system.acceleration(state.t + dt_ / 2, state.x, state.v, a_);
    state.v.array() += static_cast<Real>(dt_) * a_.array();
    state.x.array() += static_cast<Real>(dt_ / 2) * state.v.array();
    state.t += dt_;
    system.constrain(state.t, state.x, state.v);
  }
  double dt_;
  mss::Field<Real> a_;
};

/// A force of one's own: wind along x.
class Windy final : public mss::SystemWrapper<double> {
 public:
  Windy(mss::System<double>& calm, double push) : mss::SystemWrapper<double>(calm), push_(push) {}
  void force(double t, const mss::Field<double>& x, const mss::Field<double>& v,
             mss::Field<double>& f) override {
    other().force(t, x, v, f);
    for (const std::ptrdiff_t site : particles())
      f.set(site, f.at(site) + mss::Vec3(mass(site) * push_, 0, 0));
  }
  void acceleration(double t, const mss::Field<double>& x, const mss::Field<double>& v,
                    mss::Field<double>& a) override {
    other().acceleration(t, x, v, a);
    for (const std::ptrdiff_t site : particles()) a.set(site, a.at(site) + mss::Vec3(push_, 0, 0));
  }

 private:
  double push_;
};

void one_body_by_several_methods() {
  const mss::Body body(block(mss::Vec3(0, 0, 0.01)));
  mss::Environment environment;
  environment.gravity = {0, 0, -9.81};
  environment.planes.push_back(
      {.point = {0, 0, 0}, .normal = {0, 0, 1}, .restitution = 0.5, .friction = 0.4});
  mss::SpringSystem<double> system(body, environment);
  for (const char* name : {"semi_implicit_euler", "rk4", "backward_euler", "xpbd", "vbd"}) {
    const mss::IntegratorInfo& method = mss::find_integrator(name);
    const double dt =
        method.limit ? mss::safe_share * mss::stable_step(method, system.spectral_bound()) : 1.0 / 240;
    const auto integrator = method.make<double>({.dt = dt});
    mss::State<double> state = system.rest_state();
    mss::Work work;
    const mss::Status status = integrator->advance(system, state, 0.1, work);
    expect(status == mss::Status::ok, mss::to_string(status).data());
    const mss::Measures measures = mss::measure(system, state);
    expect(std::isfinite(measures.total()) && measures.min_jacobian > 0.5, name);
    expect(work.steps > 0, "work counts steps");
  }
}

void own_method_and_force() {
  const mss::Body body(block(mss::Vec3::Zero()));
  mss::SpringSystem<double> calm(body, mss::Environment{});
  Windy system(calm, 2);
  Leapfrog<double> method(1e-4);
  mss::State<double> state = calm.rest_state();
  mss::Work work;
  expect(method.advance(system, state, 0.1, work) == mss::Status::ok, "a method of one's own");
  const double mass = body.total_mass();
  expect(std::abs(mss::measure(calm, state).momentum[0] / (mass * 0.2) - 1) < 1e-9, "wind gives momentum");
}

void held_beam_vibrates() {
  mss::BodyConfig beam{.voxels = mss::VoxelGrid::box(8, 2, 2), .cell_size = 0.05};
  beam.fill({.young = 1e5, .poisson = 0.3}, 0.5);
  const mss::Body body(beam);
  const mss::Hold wall{.box = {{0, 0, 0}, {0, 0.1, 0.1}}};
  mss::SpringSystem<double> system(body, {.holds = {wall}});
  mss::Work work;
  const mss::Modes modes = mss::slowest_modes(system, system.rest_state(), 2, work);
  expect(modes.modes.size() == 2 && modes.modes[0].omega > 0, "modes");
  expect(mss::fastest_mode(system, system.rest_state(), work).modes[0].omega <= system.spectral_bound().omega,
         "the bound holds");
}

void bodies_touch_and_go_on() {
  const mss::Body lower(block({0, 0, 0})), upper(block({0.02, 0.01, 0.1}));
  const mss::Environment environment{.contact = {.bodies = true, .friction = 0}};
  const auto make = [&] {
    mss::BodiesSystem<double>::Bodies bodies;
    for (const mss::Body* body : {&lower, &upper})
      bodies.push_back(std::make_unique<mss::SpringSystem<double>>(*body, mss::Environment{}));
    return std::make_unique<mss::BodiesSystem<double>>(std::move(bodies), environment,
                                                       mss::BodiesSystem<double>::Surfaces{}, 1);
  };
  const auto system = make();
  mss::State<double> state = system->rest_state();
  const mss::Level& second = system->levels()[1];
  for (const std::ptrdiff_t site : second.body.sites())
    state.v.set(second.first + site, mss::Vec3(0, 0, -0.5));
  const auto method = mss::find_integrator("verlet").make<double>({.dt = 1e-4});
  mss::Work work;
  expect(method->advance(*system, state, 0.004, work) == mss::Status::ok, "bodies");
  const auto contact = mss::measure_bodies(*system, state).contact;
  expect(contact && contact->touches > 0, "they touch");

  mss::Record kept;
  kept.keep(*system);
  method->remember(*system, kept);
  mss::Record read(kept.take_bytes());
  const auto again = make();
  const auto goes_on = mss::find_integrator("verlet").make<double>({.dt = 1e-4});
  read.keep(*again);
  goes_on->remember(*again, read);
  mss::State<double> other = state;
  expect(method->advance(*system, state, 0.02, work) == mss::Status::ok, "one goes on");
  expect(goes_on->advance(*again, other, 0.02, work) == mss::Status::ok, "the other too");
  expect((state.x.array() == other.x.array()).all(), "a restart changes no bit");
}

void scenes_are_read_and_refused() {
  const mss::Scene scene = mss::parse_scene(
      "[body]\ncells = [4, 1, 1]\ncell_size = 0.1\n\n[material]\ndensity = 500\nyoung = 1e5\npoisson = "
      "0.3\n\n"
      "[solve]\nintegrator = \"verlet\"\ndt = \"safe\"\nduration = 1\n",
      {"solve.duration=0.5"});
  expect(scene.solve.duration == 0.5 && mss::Body(scene.body).cell_count() == 4, "a scene");
  try {
    mss::parse_scene("[body]\ncells = [4, 1]\n");
    expect(false, "a scene that is wrong is refused");
  } catch (const mss::InputError& error) {
    expect(std::string(error.what()).find("cells") != std::string::npos, "the sentence names the key");
  }
}

}  // namespace

int main() {
  one_body_by_several_methods();
  own_method_and_force();
  held_beam_vibrates();
  bodies_touch_and_go_on();
  scenes_are_read_and_refused();
  for (const mss::MeasureColumn& column : mss::measure_columns)
    expect(!column.name.empty(), "columns have names");
  std::puts("written for 1.0: runs");
}
