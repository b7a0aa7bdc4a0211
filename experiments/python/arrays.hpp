#pragma once

#include <pybind11/numpy.h>

#include <string_view>
#include <vector>

#include "core/base/field.hpp"

namespace mss::python {

/// An array of Python's that may be given as anything that NumPy makes doubles of.
using Doubles = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// A new array (N, 3) of the vectors that a field has at N sites.
template <class Real>
Doubles vectors_of(const Field<Real>& field, const std::vector<std::ptrdiff_t>& sites);

/// Throws InputError if this is not of shape (N, 3); `what` it is, as in "positions".
void check_vectors(const Doubles& vectors, std::size_t n, std::string_view what);

/// Writes an array (N, 3) to a field's N sites, or adds it to them. Throws as check_vectors().
template <class Real>
void set_vectors(Field<Real>& field, const std::vector<std::ptrdiff_t>& sites, const Doubles& vectors,
                 std::string_view what);
template <class Real>
void add_vectors(Field<Real>& field, const std::vector<std::ptrdiff_t>& sites, const Doubles& vectors,
                 std::string_view what);

}  // namespace mss::python
