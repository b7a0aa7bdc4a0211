#include "integrators/device/displaced_steps.hpp"

#include "core/environment/plane_bounds.hpp"

namespace mss {

SitesByColour::SitesByColour(const Lattice& lattice, const std::vector<std::ptrdiff_t>& all) {
  for (int colour = 0; colour < colours; ++colour) {
    first[std::size_t(colour)] = int(sites.size());
    for (const std::ptrdiff_t site : all) {
      const auto [i, j, k] = lattice.coordinates(site);
      if ((i & 1) + 2 * (j & 1) + 4 * (k & 1) == colour) sites.push_back(site);
    }
  }
  first[colours] = int(sites.size());
}

template <class Real>
ContactOnDevice<Real>::ContactOnDevice(DeviceSystem<Real>& system)
    : near_(system.shared_device(), std::ptrdiff_t(sizeof(std::uint32_t)) * system.stride()),
      multipliers_(system.shared_device(), std::ptrdiff_t(sizeof(double)) * 4 * system.stride() *
                                               std::ptrdiff_t(system.springs().bounds()->planes().size())),
      meetings_(system.shared_device(), sizeof(Meetings)) {}

template <class Real>
const std::vector<std::string> ContactOnDevice<Real>::parts{"planes", "impulse", "multipliers"};

template <class Real>
void ContactOnDevice<Real>::set_planes(DeviceSystem<Real>& system, ShaderProgram& program) {
  const double cell_size = system.springs().bounds()->cell_size();
  system.set_planes(program);
  program.set("push_out_speed", push_out_rate * cell_size)
      .set("behind_by_rounding", behind_by_rounding * cell_size);
  program.bind(5, near_).bind(6, multipliers_);
}

template <class Real>
ShaderProgram& ContactOnDevice<Real>::program(DeviceSystem<Real>& system, const std::string& part, double dt,
                                              const Vectors& u) {
  std::vector<std::string> all = parts;
  all.emplace_back("displacement_contact");
  ShaderProgram& program = system.program({part}, all);
  set_planes(system, program);
  return program.set("step_size", dt).bind(0, system.x()).bind(1, system.v()).bind(3, u).bind(4, meetings_);
}

template <class Real>
void ContactOnDevice<Real>::begin_step(DeviceSystem<Real>& system, double dt, const Vectors& u) {
  program(system, "BEGIN", dt, u).run(system.sites());
}

/// The processor's passes over cells of odd planes leave the lowest particles alone.
template <class Real>
void ContactOnDevice<Real>::project(DeviceSystem<Real>& system, double dt, int colour, const Vectors& u) {
  const Lattice& lattice = system.springs().body().lattice();
  if ((colour & 1) > lattice.cells[0] || ((colour >> 1) & 1) > lattice.cells[1]) return;
  const std::ptrdiff_t first = colour < 4 ? 0 : lattice.plane;
  program(system, "PROJECT", dt, u).set("first_site", int(first)).run(system.sites() - first);
}

template <class Real>
void ContactOnDevice<Real>::end_step(DeviceSystem<Real>& system, double dt, const Vectors& u) {
  program(system, "END", dt, u)
      .set("rate", Real(1) / static_cast<Real>(dt))
      .set("may_leave", system.springs().bounds()->bounces(dt) ? 1 : 0)
      .run(system.sites());
}

template <class Real>
void ContactOnDevice<Real>::put_in_front(DeviceSystem<Real>& system, double dt, const Vectors& u) {
  const Meetings none;
  meetings_.write(&none, 0, sizeof(none));
  program(system, "PUT_IN_FRONT", dt, u).run(system.sites());
}

template <class Real>
int ContactOnDevice<Real>::impact() const {
  Meetings met;
  meetings_.read(&met, 0, sizeof(met));
  return met.comes_to == UINT32_MAX ? -1 : int(met.comes_to);
}

template <class Real>
void ContactOnDevice<Real>::remember(DeviceSystem<Real>& system, Record& record) {
  const auto stride = std::size_t(system.stride());
  const std::size_t planes = system.springs().bounds()->planes().size();
  std::vector<std::uint32_t> near(stride);
  std::vector<double> multipliers(4 * stride * planes);
  near_.read(near.data(), 0, near_.bytes());
  multipliers_.read(multipliers.data(), 0, multipliers_.bytes());
  std::vector<std::ptrdiff_t> pushed;
  for (const std::ptrdiff_t site : system.springs().particles())
    for (std::size_t p = 0; near[std::size_t(site)] != 0 && p < planes; ++p)
      if (multipliers[4 * p * stride + std::size_t(site)] > 0) {
        pushed.push_back(site);
        break;
      }
  record.keep(pushed);
  if (!record.reads()) return;
  near.assign(near.size(), 0);
  for (const std::ptrdiff_t site : pushed) {  // until the next step begins
    near[std::size_t(site)] = 1;
    multipliers[std::size_t(site)] = 1;
  }
  near_.write(near.data(), 0, near_.bytes());
  multipliers_.write(multipliers.data(), 0, multipliers_.bytes());
  const Meetings met{.any_pushed = pushed.empty() ? 0U : 1U};
  meetings_.write(&met, 0, sizeof(met));
}

template <class Real>
void DisplacedSteps<Real>::begin(DeviceSystem<Real>& system) {
  const SpringSystem<Real>& springs = system.springs();
  u_ = system.make_vectors();
  holds_move_ = springs.held().move(0, 0, springs.body().lattice().sites);
  if (holds_move_) end_x_ = system.make_vectors(), end_v_ = system.make_vectors();
  contact_.reset();
  if (system.has_planes()) contact_.emplace(system);
}

template <class Real>
void DisplacedSteps<Real>::take(DeviceSystem<Real>& system, double t, double dt, long steps) {
  for (long n = 0; n < steps; ++n, t += dt) {
    if (holds_move_) system.constrain(t + dt, end_x_, end_v_);
    displace(system, t);
    if (contact_) contact_->begin_step(system, dt, u_);
    begin_passes(system);
    for (int i = 0; i < passes_; ++i) pass(system);
    if (contact_)
      contact_->end_step(system, dt, u_);
    else
      settle(system);
    system.constrain(t + dt, system.x(), system.v());
  }
}

template <class Real>
ShaderProgram& DisplacedSteps<Real>::displacement(DeviceSystem<Real>& system, double t,
                                                  std::vector<std::string> words) {
  if (holds_move_) words.emplace_back("HOLDS_MOVE");
  const Vectors* loads = system.loads_at(t);
  ShaderProgram& program = system.program(words, {"displace"});
  program.set("step_size", static_cast<Real>(dt_)).bind(0, system.v()).bind(2, system.x()).bind(3, u_);
  if (loads) program.bind(1, *loads);
  if (holds_move_) program.bind(4, end_x_);
  return program;
}

template <class Real>
void DisplacedSteps<Real>::settle(DeviceSystem<Real>& system) {
  system.program({}, {"settle"})
      .set("rate", Real(1) / static_cast<Real>(dt_))
      .bind(0, u_)
      .bind(3, system.x())
      .bind(4, system.v())
      .run(system.sites());
}

template class ContactOnDevice<float>;
template class ContactOnDevice<double>;
template class DisplacedSteps<float>;
template class DisplacedSteps<double>;

}  // namespace mss
