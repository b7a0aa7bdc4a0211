#pragma once

#include <cstddef>
#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// What a body's slab of planes needs of the slabs beside it: the particles of one ghost plane on each side.
/// The cells between a slab and the ghost plane below it are then summed up twice, once in either process,
/// and every particle's force is added up in the order that it has in one process.
template <class Real>
class Halo {
 public:
  /// The body must outlive it.
  explicit Halo(const Body& body);

  /// Numbers that go from one rank to a rank beside it in an exchange: positions and velocities, three axes
  /// each.
  static std::ptrdiff_t numbers(const Lattice& lattice) { return 6 * lattice.used(); }

  /// Overwrites the ghost planes of positions and velocities, which no one else reads: they belong to this
  /// class in every field.
  void exchange(const Field<Real>& x, const Field<Real>& v);

 private:
  void pack(const Field<Real>& x, const Field<Real>& v, int plane, std::vector<Real>& packed) const;
  void unpack(const std::vector<Real>& packed, int plane, const Field<Real>& x, const Field<Real>& v) const;

  const Body& body_;
  std::vector<Real> to_below_, from_below_, to_above_, from_above_;
};

}  // namespace mss
