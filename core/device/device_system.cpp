#include "core/device/device_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/forces/fold_guard.hpp"

namespace mss {

namespace {

/// Of the 27 sites around one.
constexpr int sites_around = 27;

constexpr int around(int dx, int dy, int dz) { return (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1); }

/// The place around a particle of another corner of a cell whose corner `own` it is.
constexpr int place_of(int own, int corner) {
  return around(corner_bit(corner, 0) - corner_bit(own, 0), corner_bit(corner, 1) - corner_bit(own, 1),
                corner_bit(corner, 2) - corner_bit(own, 2));
}

/// What the coefficients of a particle depend on: the kinds of the eight sites whose springs and cells may
/// touch it, its mass, and which axes are held.
struct ParticleKind {
  std::array<std::uint32_t, 8> of_corner{};
  double mass = 0;
  int held = 0;

  friend bool operator<(const ParticleKind& a, const ParticleKind& b) {
    return std::tie(a.of_corner, a.mass, a.held) < std::tie(b.of_corner, b.mass, b.held);
  }
};

ParticleKind kind_at(const Body& body, const HeldSites& held, std::ptrdiff_t site) {
  ParticleKind kind;
  const auto at = body.lattice().coordinates(site);
  for (int c = 0; c < 8; ++c) {
    const bool inside = at[0] >= corner_bit(c, 0) && at[1] >= corner_bit(c, 1) && at[2] >= corner_bit(c, 2);
    if (inside) kind.of_corner[std::size_t(c)] = body.kind(site - body.lattice().corner(c));
  }
  kind.mass = body.mass(site);
  for (int axis = 0; axis < 3; ++axis)
    if (held.holds(site, axis)) kind.held |= 1 << axis;
  return kind;
}

/// A row of the table in shaders/prelude.glsl.
template <class Real>
void append_coefficients(const Body& body, const ParticleKind& kind, bool damped, std::vector<Real>& table) {
  std::array<double, sites_around> stiffness{}, damping{};
  std::array<double, 8> volume{};
  for (int own = 0; own < 8; ++own) {
    const SiteElements e = body.kinds().elements(kind.of_corner[std::size_t(own)]);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      const SpringSlot& slot = spring_slots[s];
      if (slot.a != own && slot.b != own) continue;
      const auto other = std::size_t(place_of(own, slot.a == own ? slot.b : slot.a));
      stiffness[other] += e.stiffness[s];
      damping[other] += e.damping[s];
    }
    volume[std::size_t(own)] = e.volume / (64 * body.cell_volume());
  }
  const auto append = [&](double value) { table.push_back(static_cast<Real>(value)); };
  std::for_each(stiffness.begin(), stiffness.end(), append);
  if (damped) std::for_each(damping.begin(), damping.end(), append);
  std::for_each(volume.begin(), volume.end(), append);
  for (int axis = 0; axis < 3; ++axis)
    append(kind.mass > 0 && (kind.held >> axis & 1) == 0 ? 1 / kind.mass : 0);
  append(kind.mass);
}

std::vector<std::int32_t> as_int(const std::vector<std::ptrdiff_t>& sites) {
  return {sites.begin(), sites.end()};
}

}  // namespace

template <class Real>
DeviceSystem<Real>::DeviceSystem(std::shared_ptr<Device> device, System<Real>& system)
    : device_(std::move(device)),
      springs_([&]() -> const SpringSystem<Real>& {
        if (const SpringSystem<Real>* springs = system.springs()) return *springs;
        throw InputError(
            "a device steps bodies of springs in cells of one size, and this body is of another kind; give "
            "device = \"cpu\"");
      }()),
      tethered_(dynamic_cast<const TetheredSystem<Real>*>(&system)),
      impulses_(system.plane_impulses()) {
  check(system);
  const Lattice& lattice = springs_.body().lattice();
  pad_ = lattice.plane + lattice.row + 1;
  pad_ = (pad_ + 63) / 64 * 64;
  stride_ = lattice.size + pad_;
  describe_body();
  find_kinds();
  find_guard();
  find_planes();
  find_outer();
  for (Vectors* vectors : {&x_, &v_, &x_next_, &v_next_}) *vectors = make_vectors();
  if (has_planes()) x_before_ = make_vectors(), v_before_ = make_vectors();
  non_finite_ = DeviceMemory(device_, sizeof(std::uint32_t));
}

/// Throws InputError for what no shader does.
template <class Real>
void DeviceSystem<Real>::check(const System<Real>& system) const {
  const auto refuse = [](const std::string& what) {
    throw InputError(fmt::format("a device does not do {}; leave it out, or give device = \"cpu\"", what));
  };
  const System<Real>& stepped = tethered_ ? tethered_->untied() : system;
  if (static_cast<const System<Real>*>(&springs_) != &stepped) refuse("forces that a program adds");
  if (springs_.body().ranks().are_several()) refuse("a body that ranks share");
  if (springs_.body().config().relaxation.acts()) refuse("material.relaxation");
  if (const StepEvents<Real>* events = const_cast<System<Real>&>(system).events(); events && events->sleeps())
    refuse("sleep");
  if (springs_.surface_contact()) refuse("contact_on = \"surface\"");
  for (const Plane& plane : springs_.environment().planes)
    if (plane.contact != ContactLaw::impulse) refuse("planes of another law than \"impulse\"");
  if (!springs_.environment().obstacles.empty()) refuse("[[obstacle]]");
}

template <class Real>
void DeviceSystem<Real>::describe_body() {
  const BodyConfig& config = springs_.body().config();
  constexpr bool is_single = std::is_same_v<Real, float>;
  defines_ = {is_single ? "real float" : "real double", is_single ? "rvec3 vec3" : "rvec3 dvec3"};
  if (config.is_damped()) defines_.emplace_back("DAMPED");
  const std::vector<SiteWeights>& weights = springs_.body().kinds().weights();
  const SiteKinds& kinds = springs_.body().kinds();
  const auto any = [&](auto&& has) {
    for (std::uint32_t kind = 0; kind < weights.size(); ++kind)
      if (has(kinds.elements(kind))) return true;
    return false;
  };
  if (any([](const SiteElements& e) {
        return std::any_of(e.stiffness.begin(), e.stiffness.end(), [](double k) { return k != 0; });
      }))
    defines_.emplace_back("SPRINGS");
  if (any([](const SiteElements& e) { return e.volume != 0; })) defines_.emplace_back("CELLS");
  guarded_ = any([](const SiteElements& e) { return e.fold_guard != 0; });
  if (guarded_ || !springs_.loads().empty()) defines_.emplace_back("OUTER");
  if (tethered_) defines_.emplace_back("TETHERED");
  if (!springs_.environment().planes.empty()) defines_.emplace_back("PLANES");
}

template <class Real>
void DeviceSystem<Real>::find_kinds() {
  const Body& body = springs_.body();
  const bool damped = body.config().is_damped();
  std::map<ParticleKind, std::uint32_t> numbers;
  kinds_.assign(std::size_t(body.lattice().size), 0);
  std::vector<Real> table;
  append_coefficients(body, ParticleKind{}, damped, table);
  for (const std::ptrdiff_t site : body.sites()) {
    const ParticleKind kind = kind_at(body, springs_.held(), site);
    const auto [number, is_new] = numbers.try_emplace(kind, std::uint32_t(numbers.size()) + 1);
    if (is_new) append_coefficients(body, kind, damped, table);
    kinds_[std::size_t(site)] = number->second;
  }
  kind_of_ = memory_of(device_, kinds_);
  coefficients_ = memory_of(device_, table);
}

template <class Real>
void DeviceSystem<Real>::find_guard() {
  if (!guarded_) return;
  const Body& body = springs_.body();
  std::vector<Real> stiffness(std::size_t(body.lattice().size), Real(0));
  body.for_each_cell([&](std::ptrdiff_t site) {
    stiffness[std::size_t(site)] = static_cast<Real>(
        guarded_corner_stiffness(body.elements_at(site).fold_guard, body.config().cell_size));
  });
  guard_stiffness_ = memory_of(device_, stiffness);
  guard_marks_ = DeviceMemory(device_, std::ptrdiff_t(stiffness.size() * sizeof(std::uint32_t)));
}

template <class Real>
void DeviceSystem<Real>::find_planes() {
  std::vector<double> numbers;
  for (const Plane& plane : springs_.environment().planes) {
    numbers.insert(numbers.end(), plane.point.data(), plane.point.data() + 3);
    numbers.insert(numbers.end(), plane.normal.data(), plane.normal.data() + 3);
    numbers.insert(numbers.end(), {plane.restitution, plane.friction});
  }
  plane_count_ = int(springs_.environment().planes.size());
  if (plane_count_ == 0) return;
  push_out_speed_ = push_out_rate * springs_.body().config().cell_size;
  planes_ = memory_of(device_, numbers);
  given_ = DeviceMemory(device_, std::ptrdiff_t(sizeof(double)) * 3 * plane_count_ * stride_);
  held_force_ = DeviceMemory(device_, std::ptrdiff_t(sizeof(double)) * 3 * stride_);
  held_by_ = DeviceMemory(device_, std::ptrdiff_t(sizeof(std::uint32_t)) * stride_);
  collided_ = DeviceMemory(device_, sizeof(std::uint32_t));
}

template <class Real>
void DeviceSystem<Real>::find_outer() {
  held_sites_ = springs_.held().sites();
  loaded_sites_ = springs_.loads().sites();
  holds_move_ = springs_.held().move(0, 0, sites());
  if (!held_sites_.empty()) {
    held_list_ = memory_of(device_, as_int(held_sites_));
    held_motion_ = DeviceMemory(device_, std::ptrdiff_t(sizeof(Real) * 6 * held_sites_.size()));
    held_x_ = held_v_ = Field<Real>(springs_.size());
  }
  if (!loaded_sites_.empty()) {
    loaded_list_ = memory_of(device_, as_int(loaded_sites_));
    load_values_ = DeviceMemory(device_, std::ptrdiff_t(sizeof(Real) * 3 * loaded_sites_.size()));
    load_field_ = Field<Real>(springs_.size());
  }
  if (guarded_ || !loaded_sites_.empty()) loads_ = make_vectors();
  if (guarded_) outer_ = make_vectors();
}

template <class Real>
typename DeviceSystem<Real>::Vectors DeviceSystem<Real>::make_vectors() const {
  return {device_, std::ptrdiff_t(sizeof(Real)) * (3 * stride_ + pad_)};
}

template <class Real>
void DeviceSystem<Real>::write(const Field<Real>& from, Vectors& to) const {
  const std::ptrdiff_t size = springs_.size();
  for (int axis = 0; axis < 3; ++axis)
    to.write(from.axis(axis), std::ptrdiff_t(sizeof(Real)) * (pad_ + axis * stride_),
             std::ptrdiff_t(sizeof(Real)) * size);
}

template <class Real>
void DeviceSystem<Real>::read(const Vectors& from, Field<Real>& to) const {
  const std::ptrdiff_t size = springs_.size();
  for (int axis = 0; axis < 3; ++axis)
    from.read(to.axis(axis), std::ptrdiff_t(sizeof(Real)) * (pad_ + axis * stride_),
              std::ptrdiff_t(sizeof(Real)) * size);
}

template <class Real>
void DeviceSystem<Real>::load(const State<Real>& state) {
  write(state.x, x_);
  write(state.v, v_);
  // What shaders leave alone, sites without a particle, is in both copies.
  x_next_.copy(x_);
  v_next_.copy(v_);
}

template <class Real>
void DeviceSystem<Real>::store(State<Real>& state) {
  read(x_, state.x);
  read(v_, state.v);
  if (has_planes()) {
    given_here_.resize(3 * std::size_t(plane_count_) * std::size_t(stride_));
    given_.read(given_here_.data(), 0, given_.bytes());
    given_.clear();
  }
  if (device_->is_lost()) throw DeviceLost();
  for (std::ptrdiff_t p = 0; p < plane_count_; ++p)
    for (const std::ptrdiff_t site : springs_.particles()) {
      const double* of_plane = given_here_.data() + 3 * p * stride_ + site;
      const Vec3 impulse(of_plane[0], of_plane[stride_], of_plane[2 * stride_]);
      if (!impulse.isZero(0)) impulses_->add(std::size_t(p), site, impulse);
    }
}

template <class Real>
void DeviceSystem<Real>::remember_sticking(Record& record) {
  if (!has_planes()) return;
  std::vector<double> force(std::size_t(3 * stride_));
  std::vector<std::uint32_t> by(std::size_t(stride_), 0);
  if (!record.reads()) {
    held_force_.read(force.data(), 0, held_force_.bytes());
    held_by_.read(by.data(), 0, held_by_.bytes());
  }
  record.keep(force, by);
  if (!record.reads()) return;
  held_force_.write(force.data(), 0, held_force_.bytes());
  held_by_.write(by.data(), 0, held_by_.bytes());
}

template <class Real>
ShaderProgram& DeviceSystem<Real>::program(const std::vector<std::string>& defines,
                                           const std::vector<std::string>& parts) {
  ShaderProgram*& program = programs_[fmt::format("{} {}", fmt::join(defines, " "), fmt::join(parts, " "))];
  if (!program) program = &device_->program(text_of(defines, parts));
  set_body(*program);
  return program->bind(14, kind_of_).bind(15, coefficients_);
}

template <class Real>
void DeviceSystem<Real>::set_body(ShaderProgram& program) const {
  const Body& body = springs_.body();
  const Lattice& lattice = body.lattice();
  program.set("stride", int(stride_)).set("pad", int(pad_));
  program.set("lattice_row", int(lattice.row)).set("lattice_plane", int(lattice.plane));
  const auto length = [&](SpringSlot::Class kind) { return static_cast<Real>(body.rest_length(kind)); };
  program.set("edge_length", length(SpringSlot::Class::edge));
  program.set("face_length", length(SpringSlot::Class::face));
  program.set("body_length", length(SpringSlot::Class::body));
  program.set("rest_volume", static_cast<Real>(body.cell_volume()));
  constexpr const char* gravity[3] = {"gravity_x", "gravity_y", "gravity_z"};
  for (int axis = 0; axis < 3; ++axis)
    program.set(gravity[axis], static_cast<Real>(springs_.environment().gravity[axis]));
  set_tether(program);
}

template <class Real>
void DeviceSystem<Real>::set_tether(ShaderProgram& program) const {
  if (!tethered_) return;
  program.set("tether_site", -1);
  if (!tethered_->tether()) return;
  const auto& [site, anchor, stiffness, damping] = *tethered_->tether();
  program.set("tether_site", int(site));
  program.set("tether_stiffness", static_cast<Real>(stiffness));
  program.set("tether_damping", static_cast<Real>(damping));
  constexpr const char* place[3] = {"anchor_x", "anchor_y", "anchor_z"};
  for (int axis = 0; axis < 3; ++axis) program.set(place[axis], static_cast<Real>(anchor[axis]));
}

template <class Real>
std::string DeviceSystem<Real>::text_of(const std::vector<std::string>& defines,
                                        const std::vector<std::string>& parts) const {
  std::string text;
  for (const std::string& word : defines_) text += fmt::format("#define {}\n", word);
  for (const std::string& word : defines) text += fmt::format("#define {}\n", word);
  for (const char* part : {"prelude", "spring_law", "spring_formulas.inc", "cell_formulas.inc"})
    text += shader_text(part);
  for (const std::string& part : parts) text += shader_text(part);
  return text;
}

template <class Real>
std::vector<std::string> DeviceSystem<Real>::force_parts(const std::string& last) const {
  std::vector<std::string> parts;
  if (has_planes()) parts.emplace_back("planes");
  parts.insert(parts.end(), {"neighbours", "force", "update", last});
  return parts;
}

template <class Real>
void DeviceSystem<Real>::set_force(ShaderProgram& program, const Vectors& x, const Vectors& v) {
  program.bind(0, x).bind(1, v);
  if (guarded_ || !loaded_sites_.empty()) program.bind(2, guarded_ ? outer_ : loads_);
}

template <class Real>
void DeviceSystem<Real>::set_planes(ShaderProgram& program) {
  if (!has_planes()) return;
  program.set("plane_count", plane_count_).set("cell_size", double(springs_.body().config().cell_size));
  program.bind(10, planes_).bind(11, given_).bind(12, collided_).bind(7, held_force_).bind(8, held_by_);
}

template <class Real>
void DeviceSystem<Real>::set_update(ShaderProgram& program, const KickDrift& update) {
  program.set("kick_before", static_cast<Real>(update.kick_before));
  program.set("kick_after", static_cast<Real>(update.kick_after));
  program.set("drift_old", static_cast<Real>(update.drift_old));
  program.set("drift_new", static_cast<Real>(update.drift_new));
}

/// Loads at time t, if they are not there yet.
template <class Real>
void DeviceSystem<Real>::update_loads(double t) {
  if (loaded_sites_.empty() || (loads_known_ && !springs_.loads().change(t))) return;
  load_field_.array() = Real(0);
  springs_.loads().add(t, 0, sites(),
                       std::array<Real*, 3>{load_field_.axis(0), load_field_.axis(1), load_field_.axis(2)});
  packed_.clear();
  for (const std::ptrdiff_t site : loaded_sites_)
    for (int axis = 0; axis < 3; ++axis) packed_.push_back(load_field_.axis(axis)[site]);
  load_values_.write(packed_.data(), 0, std::ptrdiff_t(packed_.size() * sizeof(Real)));
  program({}, {"loads"})
      .bind(3, loads_)
      .bind(5, loaded_list_)
      .bind(6, load_values_)
      .run(std::ptrdiff_t(loaded_sites_.size()));
  // The last change is taken over once more after it.
  loads_known_ = !springs_.loads().change(t);
}

/// The forces that shaders of forces add.
template <class Real>
void DeviceSystem<Real>::prepare_outer(double t, const Vectors& x) {
  update_loads(t);
  if (!guarded_) return;
  const double shortest = guarded_length(springs_.body().config().cell_size);
  program({"MARK"}, {"fold_guard"})
      .set("shortest", shortest)
      .bind(0, x)
      .bind(1, guard_stiffness_)
      .bind(3, guard_marks_)
      .run(sites());
  program({}, {"fold_guard"})
      .set("shortest", shortest)
      .bind(0, x)
      .bind(1, guard_stiffness_)
      .bind(2, loads_)
      .bind(3, outer_)
      .bind(5, guard_marks_)
      .run(sites());
}

template <class Real>
const typename DeviceSystem<Real>::Vectors* DeviceSystem<Real>::loads_at(double t) {
  update_loads(t);
  return loaded_sites_.empty() ? nullptr : &loads_;
}

template <class Real>
void DeviceSystem<Real>::run_acceleration(const std::vector<std::string>& more, const Vectors& x,
                                          const Vectors& v, Vectors& a) {
  ShaderProgram& shader = program(more, force_parts("acceleration"));
  set_force(shader, x, v);
  set_planes(shader);
  shader.bind(3, a).run(sites());
}

template <class Real>
void DeviceSystem<Real>::acceleration(double t, const Vectors& x, const Vectors& v, Vectors& a) {
  prepare_outer(t, x);
  run_acceleration({}, x, v, a);
}

template <class Real>
void DeviceSystem<Real>::acceleration_if_collided(double t, Vectors& a) {
  prepare_outer(t, x_);
  run_acceleration({"ONLY_IF_COLLIDED"}, x_, v_, a);
}

template <class Real>
void DeviceSystem<Real>::constrain(double t, Vectors& x, Vectors& v) {
  if (!holds_move_) return;
  springs_.constrain(t, held_x_, held_v_);
  packed_.clear();
  for (const std::ptrdiff_t site : held_sites_)
    for (const Field<Real>* field : {&held_x_, &held_v_})
      for (int axis = 0; axis < 3; ++axis) packed_.push_back(field->axis(axis)[site]);
  held_motion_.write(packed_.data(), 0, std::ptrdiff_t(packed_.size() * sizeof(Real)));
  program({}, {"hold"})
      .bind(3, x)
      .bind(4, v)
      .bind(5, held_list_)
      .bind(6, held_motion_)
      .run(std::ptrdiff_t(held_sites_.size()));
}

template <class Real>
void DeviceSystem<Real>::kick_drift(const KickDrift& update, double t, double t_end) {
  prepare_outer(t, x_);
  ShaderProgram& shader = program({}, force_parts("kick_drift"));
  set_force(shader, x_, v_);
  set_planes(shader);
  set_update(shader, update);
  shader.bind(3, x_next_).bind(4, v_next_).run(sites());
  std::swap(x_, x_next_);
  std::swap(v_, v_next_);
  constrain(t_end, x_, v_);
}

template <class Real>
void DeviceSystem<Real>::apply(const KickDrift& update, const Vectors& a, double t_end) {
  ShaderProgram& shader = program({}, {"update", "apply"});
  set_update(shader, update);
  shader.bind(3, x_).bind(4, v_).bind(5, a).run(sites());
  kicked_for(update.kick_before + update.kick_after);
  constrain(t_end, x_, v_);
}

template <class Real>
void DeviceSystem<Real>::kicked_for(double seconds) {
  if (!has_planes() || seconds == 0) return;
  ShaderProgram& shader = program({}, {"planes", "kicked_for"});
  set_planes(shader);
  shader.set("seconds", seconds).run(sites());
}

template <class Real>
void DeviceSystem<Real>::combine(const Vectors& base, double scale, const Vectors& added, Vectors& out) {
  program({}, {"combine"})
      .set("scale", static_cast<Real>(scale))
      .bind(3, out)
      .bind(4, base)
      .bind(5, added)
      .run(sites());
}

template <class Real>
void DeviceSystem<Real>::step_begins() {
  if (!has_planes()) return;
  x_before_.copy(x_);
  v_before_.copy(v_);
}

template <class Real>
void DeviceSystem<Real>::collide(double dt) {
  if (!has_planes()) return;
  collided_.clear();
  const double cell_size = springs_.body().config().cell_size;
  ShaderProgram& shader = program({}, {"planes", "impulse", "collide"});
  set_planes(shader);
  shader.set("step_size", dt)
      .set("push_out_speed", push_out_speed_)
      .set("behind_by_rounding", behind_by_rounding * cell_size)
      .bind(0, x_before_)
      .bind(1, v_before_)
      .bind(3, x_)
      .bind(4, v_)
      .run(sites());
}

template <class Real>
double DeviceSystem<Real>::error_of_accelerations(System<Real>& system, double t) {
  constexpr double rough = 0.05;  // of a cell, and of what a cell of the fastest vibration moves at
  const double size = rough * springs_.body().config().cell_size, speed = size * springs_.body_bound().omega;
  std::mt19937 numbers(1);
  const auto rough_number = [&] { return 2 * double(numbers()) / double(std::mt19937::max()) - 1; };
  State<Real> state = springs_.rest_state();
  for (const std::ptrdiff_t site : springs_.particles()) {
    Vec3 x = state.x.at(site), v;
    for (int axis = 0; axis < 3; ++axis) x[axis] += size * rough_number(), v[axis] = speed * rough_number();
    state.x.set(site, x);
    state.v.set(site, v);
  }
  Field<Real> force(springs_.size()), found(springs_.size());
  system.force(t, state.x, state.v, force);
  load(state);
  Vectors a = make_vectors();
  acceleration(t, x_, v_, a);
  read(a, found);
  double largest = 0, error = 0;
  for (const std::ptrdiff_t site : springs_.particles()) {
    const Vec3 expected = springs_.held().free_axes(site).cwiseProduct(force.at(site)) / springs_.mass(site);
    const double off = (found.at(site) - expected).norm();
    largest = std::max(largest, expected.norm());
    error = off <= error ? error : off;  // not a number stays
  }
  return largest > 0 ? error / largest : error;
}

template <class Real>
bool DeviceSystem<Real>::is_finite() {
  non_finite_.clear();
  program({}, {"finite"}).bind(0, x_).bind(1, v_).bind(3, non_finite_).run(sites());
  std::uint32_t flag = 0;
  non_finite_.read(&flag, 0, sizeof(flag));
  return flag == 0;
}

template class DeviceSystem<float>;
template class DeviceSystem<double>;

}  // namespace mss
