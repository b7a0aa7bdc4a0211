#include "core/body_system.hpp"

namespace mss {

template <class Real>
BodySystem<Real>::BodySystem(const Body& body, const Environment& environment, int threads)
    : body_(body),
      environment_(environment),
      held_(body, environment.holds),
      loads_(body, environment.loads),
      team_(threads) {}

template <class Real>
State<Real> BodySystem<Real>::undeformed_state() const {
  State<Real> state{0, Field<Real>(size()), Field<Real>(size())};
  for (std::ptrdiff_t site = 0; site < size(); ++site) state.x.set(site, body_.rest_position(site));
  return state;
}

template <class Real>
State<Real> BodySystem<Real>::rest_state() const {
  State<Real> state = undeformed_state();
  constrain(0, state.x, state.v);
  return state;
}

template <class Real>
void BodySystem<Real>::constrain(double t, Field<Real>& x, Field<Real>& v) const {
  held_.apply(t, 0, body_.lattice().sites, x, v);
}

template <class Real>
BlockMatrix& BodySystem<Real>::blocks() {
  if (!blocks_) blocks_ = std::make_unique<BlockMatrix>(body_, held_);
  return *blocks_;
}

template <class Real>
void BodySystem<Real>::add_gravity(Field<Real>& f) const {
  if (environment_.gravity.isZero(0)) return;
  for (const std::ptrdiff_t site : body_.sites())
    for (int a = 0; a < 3; ++a)
      f.axis(a)[site] += static_cast<Real>(body_.mass(site) * environment_.gravity[a]);
}

template class BodySystem<float>;
template class BodySystem<double>;

}  // namespace mss
