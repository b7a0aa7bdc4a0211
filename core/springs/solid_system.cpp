#include "core/springs/solid_system.hpp"

namespace mss {

template <class Real>
State<Real> SolidSystem<Real>::undeformed_state() const {
  State<Real> state{0, Field<Real>(this->size()), Field<Real>(this->size())};
  for (const auto& [body, first] : levels())
    for (std::ptrdiff_t site = 0; site < body.lattice().size; ++site)
      state.x.set(first + site, body.rest_position(site));
  return state;
}

template <class Real>
State<Real> SolidSystem<Real>::rest_state() const {
  State<Real> state = undeformed_state();
  this->constrain(0, state.x, state.v);
  return state;
}

template <class Real>
double SolidSystem<Real>::total_mass() const {
  double sum = 0;
  for (const Level& level : levels()) sum += level.body.total_mass();
  return sum;
}

template <class Real>
Vec3 SolidSystem<Real>::rest_position(std::ptrdiff_t site) const {
  auto level = levels().end() - 1;
  while (level->first > site) --level;
  return level->body.rest_position(site - level->first);
}

template <class Real>
void SolidSystem<Real>::give(const Strike& strike, Field<Real>& v) const {
  const std::vector<std::ptrdiff_t> sites = select(levels(), strike.box);
  double mass = 0;
  ranks().add_in_order(mass, [&] {
    for (const std::ptrdiff_t site : sites) mass += this->mass(site);
  });
  for (const std::ptrdiff_t site : sites)
    if (this->mass(site) > 0) v.set(site, v.at(site) + strike.impulse / mass);
}

template class SolidSystem<float>;
template class SolidSystem<double>;

}  // namespace mss
