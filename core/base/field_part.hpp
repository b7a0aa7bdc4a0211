#pragma once

#include <algorithm>
#include <cstddef>

#include "core/base/field.hpp"

namespace mss {

/// The `size` sites of a field from `first` on, as a field.
template <class Real>
Field<Real> part_of(const Field<Real>& field, std::ptrdiff_t first, std::ptrdiff_t size) {
  Field<Real> part(size);
  for (int axis = 0; axis < 3; ++axis) std::copy_n(field.axis(axis) + first, size, part.axis(axis));
  return part;
}

}  // namespace mss
