#include "core/bodies/bodies_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/record.hpp"
#include "core/bodies/bodies_system.hpp"
#include "core/measures/distortion.hpp"
#include "core/measures/measures.hpp"

namespace mss {

namespace {

template <class Real>
BodyMeasures measure_body(const Level& level, const State<Real>& state) {
  BodyMeasures m;
  double mass = 0;
  for (const std::ptrdiff_t site : level.body.sites()) {
    const double of_site = level.body.mass(site);
    mass += of_site;
    m.centre += of_site * state.x.at(level.first + site);
    m.kinetic += of_site / 2 * state.v.at(level.first + site).squaredNorm();
  }
  m.centre /= mass;
  m.volume_ratio = volume_ratio(std::vector<Level>{level}, state.x);
  m.min_jacobian = min_jacobian(std::vector<Level>{level}, state.x);
  return m;
}

}  // namespace

void BodyMeasures::remember(Record& record) { record.keep(centre, kinetic, volume_ratio, min_jacobian); }

bool BodiesMeasures::is_finite() const {
  bool all = true;
  for_each_column(*this,
                  [&](const std::string&, const char*, double number) { all &= std::isfinite(number); });
  return all;
}

void BodiesMeasures::remember(Record& record) { record.keep(bodies, contact); }

void for_each_column(const BodiesMeasures& measures,
                     const std::function<void(const std::string&, const char*, double)>& visit) {
  for (std::size_t b = 0; b < measures.bodies.size(); ++b) {
    const BodyMeasures& m = measures.bodies[b];
    for (int axis = 0; axis < 3; ++axis)
      visit(fmt::format("body_{}_{}", b, "xyz"[axis]), "m", m.centre[axis]);
    visit(fmt::format("body_{}_kinetic", b), "J", m.kinetic);
    visit(fmt::format("body_{}_volume_ratio", b), "", m.volume_ratio);
    visit(fmt::format("body_{}_min_jacobian", b), "", m.min_jacobian);
  }
  if (!measures.contact) return;
  visit("contact_touches", "", double(measures.contact->touches));
  visit("contact_depth", "m", measures.contact->depth);
  visit("contact_force", "N", measures.contact->force);
  visit("contact_energy", "J", measures.contact->energy);
}

template <class Real>
BodiesMeasures measure_bodies(const SolidSystem<Real>& system, const State<Real>& state) {
  const auto* several = dynamic_cast<const BodiesSystem<Real>*>(&system);
  if (!several) return {};
  BodiesMeasures measures{.contact = several->contact_at(state)};
  if (several->body_count() > 1)
    for (const Level& level : several->levels()) measures.bodies.push_back(measure_body(level, state));
  return measures;
}

template BodiesMeasures measure_bodies(const SolidSystem<float>&, const State<float>&);
template BodiesMeasures measure_bodies(const SolidSystem<double>&, const State<double>&);

}  // namespace mss
