#include "experiments/view/colour_map.hpp"

#include <algorithm>
#include <cmath>

namespace mss::view {

namespace {

/// Every fifteenth of viridis' 256 colours; straight lines between them stay within 1/255 of the rest.
constexpr std::array<Colour, 18> viridis{{{0.267004F, 0.004874F, 0.329415F},
                                          {0.281924F, 0.089666F, 0.412415F},
                                          {0.280255F, 0.165693F, 0.476498F},
                                          {0.263663F, 0.237631F, 0.518762F},
                                          {0.237441F, 0.305202F, 0.541921F},
                                          {0.208623F, 0.367752F, 0.552675F},
                                          {0.182256F, 0.426184F, 0.557120F},
                                          {0.159194F, 0.482237F, 0.558073F},
                                          {0.137770F, 0.537492F, 0.554906F},
                                          {0.121148F, 0.592739F, 0.544641F},
                                          {0.128087F, 0.647749F, 0.523491F},
                                          {0.180653F, 0.701402F, 0.488189F},
                                          {0.274149F, 0.751988F, 0.436601F},
                                          {0.395174F, 0.797475F, 0.367757F},
                                          {0.535621F, 0.835785F, 0.281908F},
                                          {0.688944F, 0.865448F, 0.182725F},
                                          {0.845561F, 0.887322F, 0.099702F},
                                          {0.993248F, 0.906157F, 0.143936F}}};

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

}  // namespace

Colour map_colour(double share) {
  if (std::isnan(share)) return {0.5F, 0.5F, 0.5F};
  const double place = std::clamp(share, 0.0, 1.0) * double(viridis.size() - 1);
  const auto below = std::min(std::size_t(place), viridis.size() - 2);
  const auto part = static_cast<float>(place - double(below));
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = (1 - part) * viridis[below][c] + part * viridis[below + 1][c];
  return colour;
}

std::vector<double> ValueRange::ticks() const {
  std::vector<double> ticks;
  const long first = std::lround(low / step), last = std::lround(high / step);
  for (long i = first; i <= last; ++i) ticks.push_back(double(i) * step);
  return ticks;
}

ValueRange round_range(double low, double high, double least) {
  if (high - low < least) {
    const double middle = (low + high) / 2;
    low = middle - least / 2;
    high = middle + least / 2;
  }
  const double step = round_step((high - low) / 6);
  const double slack = 1e-6;  // of a step: what rounding leaves beside a tick is on it
  return {.low = step * std::floor(low / step + slack),
          .high = step * std::ceil(high / step - slack),
          .step = step};
}

}  // namespace mss::view
