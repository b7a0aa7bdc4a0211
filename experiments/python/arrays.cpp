#include "experiments/python/arrays.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.hpp"

namespace mss::python {

namespace py = pybind11;

template <class Real>
Doubles vectors_of(const Field<Real>& field, const std::vector<std::ptrdiff_t>& sites) {
  Doubles vectors({py::ssize_t(sites.size()), py::ssize_t(3)});
  double* out = vectors.mutable_data();
  for (const std::ptrdiff_t site : sites)
    for (int axis = 0; axis < 3; ++axis) *out++ = double(field.axis(axis)[site]);
  return vectors;
}

void check_vectors(const Doubles& vectors, std::size_t n, std::string_view what) {
  if (vectors.ndim() == 2 && vectors.shape(0) == py::ssize_t(n) && vectors.shape(1) == 3) return;
  const std::vector<py::ssize_t> shape(vectors.shape(), vectors.shape() + vectors.ndim());
  throw InputError(fmt::format("{} have the shape ({}); give ({}, 3), a row for each particle", what,
                               fmt::join(shape, ", "), n));
}

namespace {

template <class Real, class Put>
void visit(Field<Real>& field, const std::vector<std::ptrdiff_t>& sites, const Doubles& vectors,
           std::string_view what, Put&& put) {
  check_vectors(vectors, sites.size(), what);
  const double* in = vectors.data();
  for (const std::ptrdiff_t site : sites)
    for (int axis = 0; axis < 3; ++axis) put(field.axis(axis)[site], static_cast<Real>(*in++));
}

}  // namespace

template <class Real>
void set_vectors(Field<Real>& field, const std::vector<std::ptrdiff_t>& sites, const Doubles& vectors,
                 std::string_view what) {
  visit(field, sites, vectors, what, [](Real& to, Real value) { to = value; });
}

template <class Real>
void add_vectors(Field<Real>& field, const std::vector<std::ptrdiff_t>& sites, const Doubles& vectors,
                 std::string_view what) {
  visit(field, sites, vectors, what, [](Real& to, Real value) { to += value; });
}

template Doubles vectors_of(const Field<float>&, const std::vector<std::ptrdiff_t>&);
template Doubles vectors_of(const Field<double>&, const std::vector<std::ptrdiff_t>&);
template void set_vectors(Field<float>&, const std::vector<std::ptrdiff_t>&, const Doubles&,
                          std::string_view);
template void set_vectors(Field<double>&, const std::vector<std::ptrdiff_t>&, const Doubles&,
                          std::string_view);
template void add_vectors(Field<double>&, const std::vector<std::ptrdiff_t>&, const Doubles&,
                          std::string_view);

}  // namespace mss::python
