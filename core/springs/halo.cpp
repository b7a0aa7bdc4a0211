#include "core/springs/halo.hpp"

#include <algorithm>

namespace mss {

template <class Real>
Halo<Real>::Halo(const Body& body) : body_(body) {
  const auto size = std::size_t(numbers(body.lattice()));
  if (!body.ranks().is_lowest()) to_below_ = from_below_ = std::vector<Real>(size);
  if (!body.ranks().is_highest()) to_above_ = from_above_ = std::vector<Real>(size);
}

template <class Real>
void Halo<Real>::pack(const Field<Real>& x, const Field<Real>& v, int plane,
                      std::vector<Real>& packed) const {
  const Lattice& lattice = body_.lattice();
  Real* out = packed.data();
  for (const Field<Real>* field : {&x, &v})
    for (int axis = 0; axis < 3; ++axis)
      out = std::copy_n(field->axis(axis) + lattice.plane * plane, lattice.used(), out);
}

template <class Real>
void Halo<Real>::unpack(const std::vector<Real>& packed, int plane, const Field<Real>& x,
                        const Field<Real>& v) const {
  const Lattice& lattice = body_.lattice();
  const Real* in = packed.data();
  for (const Field<Real>* field : {&x, &v})
    for (int axis = 0; axis < 3; ++axis, in += lattice.used())
      std::copy_n(in, lattice.used(), field->ghosts(axis) + lattice.plane * plane);
}

template <class Real>
void Halo<Real>::exchange(const Field<Real>& x, const Field<Real>& v) {
  const Communicator& ranks = body_.ranks();
  const auto [first, last] = body_.own_planes();
  if (!ranks.is_lowest()) pack(x, v, first, to_below_);
  if (!ranks.is_highest()) pack(x, v, last - 1, to_above_);
  ranks.exchange(std::as_bytes(std::span(to_below_)), std::as_writable_bytes(std::span(from_below_)),
                 std::as_bytes(std::span(to_above_)), std::as_writable_bytes(std::span(from_above_)));
  if (!ranks.is_lowest()) unpack(from_below_, first - 1, x, v);
  if (!ranks.is_highest()) unpack(from_above_, last, x, v);
}

template class Halo<float>;
template class Halo<double>;

}  // namespace mss
