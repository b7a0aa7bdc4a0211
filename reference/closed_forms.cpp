#include "reference/closed_forms.hpp"

namespace mss::reference {

double pulled_extension(const SquareBar& bar, double force) {
  return force * bar.length / (bar.young * bar.width * bar.width);
}

double cantilever_deflection(const SquareBar& bar, double force) {
  const double area = bar.width * bar.width, moment = area * area / 12,
               shear = bar.young / (2 * (1 + bar.poisson));
  const double coefficient = 10 * (1 + bar.poisson) / (12 + 11 * bar.poisson);
  return force * bar.length * bar.length * bar.length / (3 * bar.young * moment) +
         force * bar.length / (coefficient * shear * area);
}

}  // namespace mss::reference
