#include "experiments/fit/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/scene/scene_writer.hpp"

namespace mss::fit {

namespace {

constexpr const char* form = "give KEY or KEY=LOW..HIGH, as in material.young=1e5..1e6";

/// The numbers of a scene that are not whole, by key.
std::vector<std::pair<std::string, double>> numbers_of(const Scene& scene) {
  std::vector<std::pair<std::string, double>> numbers;
  const nlohmann::ordered_json leaves = to_json(scene).flatten();
  for (const auto& [pointer, value] : leaves.items()) {
    if (!value.is_number_float()) continue;
    std::string key = pointer.substr(1);
    std::replace(key.begin(), key.end(), '/', '.');
    numbers.emplace_back(std::move(key), value.get<double>());
  }
  return numbers;
}

double start_of(const std::string& key, const Scene& scene) {
  const auto numbers = numbers_of(scene);
  const auto found =
      std::find_if(numbers.begin(), numbers.end(), [&](const auto& number) { return number.first == key; });
  if (found != numbers.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [name, value] : numbers) known.push_back(name);
  throw InputError(fmt::format(
      "--parameters {}: {} has no such number that may vary; {}where it does not say one, give where to "
      "start with --set {}=START",
      key, scene.name, question(key, known), key));
}

double read_bound(const std::string& bound, double none, const std::string& text) {
  if (bound.empty()) return none;
  double value = 0;
  const auto [end, problem] = std::from_chars(bound.data(), bound.data() + bound.size(), value);
  if (problem != std::errc() || end != bound.data() + bound.size() || !std::isfinite(value))
    throw InputError(fmt::format("--parameters {}: '{}' is not a bound; {}", text, bound, form));
  return value;
}

void check_start(const Parameter& p, const std::string& text) {
  if (!(p.low < p.high))
    throw InputError(fmt::format("--parameters {}: the bounds do not ascend; {}", text, form));
  if (p.start < p.low || p.start > p.high)
    throw InputError(fmt::format(
        "--parameters {}: the scene's value, where the fit starts, is {:g}, outside the bounds; give others, "
        "or --set {}=START",
        text, p.start, p.key));
  if (p.start == 0 && !(std::isfinite(p.low) && std::isfinite(p.high)))
    throw InputError(fmt::format(
        "--parameters {}: the scene's value is 0, which has no scale to vary on; give another start with "
        "--set {}=START, or both bounds",
        text, p.key));
}

/// Of what is not fitted in the logarithm.
double scale_of(const Parameter& p) { return p.start != 0 ? std::abs(p.start) : p.high - p.low; }

}  // namespace

double Parameter::coordinate(double value) const {
  return is_logarithmic() ? std::log(value) : value / scale_of(*this);
}

double Parameter::unbounded(double coordinate) const {
  return is_logarithmic() ? std::exp(coordinate) : coordinate * scale_of(*this);
}

double Parameter::value(double coordinate) const {
  if (coordinate == this->coordinate(start)) return start;
  return std::clamp(unbounded(coordinate), low, high);  // rounding may leave the bounds
}

std::string Parameter::setting(double value) const { return fmt::format("{}={}", key, value); }

Parameter read_parameter(const std::string& text, const Scene& scene) {
  const auto equals = text.find('=');
  Parameter p{.key = text.substr(0, equals)};
  p.start = start_of(p.key, scene);
  if (equals != std::string::npos) {
    const std::string bounds = text.substr(equals + 1);
    const auto dots = bounds.find("..");
    if (dots == std::string::npos || bounds.size() == 2)
      throw InputError(fmt::format("--parameters {}: '{}' is not a range; {}", text, bounds, form));
    p.low = read_bound(bounds.substr(0, dots), p.low, text);
    p.high = read_bound(bounds.substr(dots + 2), p.high, text);
  }
  check_start(p, text);
  return p;
}

std::vector<Parameter> read_parameters(const std::vector<std::string>& texts, const Scene& scene) {
  if (texts.empty())
    throw InputError(fmt::format("there is nothing to fit: --parameters is empty; {}", form));
  std::vector<Parameter> parameters;
  for (const std::string& text : texts) {
    Parameter p = read_parameter(text, scene);
    if (std::any_of(parameters.begin(), parameters.end(), [&](const auto& q) { return q.key == p.key; }))
      throw InputError(fmt::format("--parameters {}: it is given twice; give it once", text));
    parameters.push_back(std::move(p));
  }
  return parameters;
}

}  // namespace mss::fit
