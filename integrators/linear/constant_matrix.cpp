#include "integrators/linear/constant_matrix.hpp"

#include <algorithm>

namespace mss {

namespace {

std::size_t index(SpringSlot::Class kind) { return static_cast<std::size_t>(kind); }

double stiffness_of(const SpringConstants& springs, SpringSlot::Class kind) {
  return std::array{springs.edge, springs.face, springs.body}[index(kind)];
}

/// By class, a slot that every topology with such springs has.
constexpr std::array<std::size_t, 3> slot_of_class{0, 3, 9};

}  // namespace

ConstantMatrix bounding_matrix(const Body& body, double a, double b, double c) {
  const BodyConfig& config = body.config();
  ConstantMatrix matrix{.mass = a};
  for (const auto kind : {SpringSlot::Class::edge, SpringSlot::Class::face, SpringSlot::Class::body}) {
    const double interior = body.kinds().interior_stiffness(slot_of_class[index(kind)]);
    for (const Part& part : body.parts()) {
      // Of an interior spring: between two whole particles.
      const double mass = part.density * body.cell_volume(), k = stiffness_of(part.springs, kind);
      if (k == 0 || interior == 0) continue;
      const double shear_modulus = config.shear_modulus_of(part.springs);
      const double weight =
          c * k + b * part.damping.coefficient(k, mass, mass, body.rest_length(kind), shear_modulus);
      matrix.spring[index(kind)] = std::max(matrix.spring[index(kind)], weight * (interior / k));
    }
  }
  matrix.cell_edge = c * 0.75 * std::max(body.kinds().interior_volume(), 0.0) * config.cell_size;
  return matrix;
}

}  // namespace mss
