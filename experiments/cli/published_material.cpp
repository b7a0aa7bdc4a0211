#include "experiments/cli/published_material.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace mss::cli {

namespace {

using reference::PublishedMaterial;

std::string as_in_the_table(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return c == ' ' || c == '-' ? '_' : char(std::tolower(c)); });
  return name;
}

[[noreturn]] void throw_unknown_material(const std::string& given, const std::string& name) {
  std::vector<std::string> known, containing;
  for (const PublishedMaterial& material : reference::published_materials()) {
    known.push_back(material.name);
    if (!name.empty() && material.name.find(name) != std::string::npos) containing.push_back(material.name);
  }
  const std::string hint = containing.size() > 1
                               ? fmt::format("give one of {}; ", fmt::join(containing, ", "))
                               : question(name, known);
  throw InputError(fmt::format("material '{}' is unknown; {}`mss material --like` shows all", given, hint));
}

/// "0.64 MPa" and the like.
std::string shown_modulus(double pascals) {
  return pascals >= 1e6   ? fmt::format("{:.4g} MPa", pascals / 1e6)
         : pascals >= 1e3 ? fmt::format("{:.4g} kPa", pascals / 1e3)
                          : fmt::format("{:.4g} Pa", pascals);
}

std::string shown_loss(const PublishedMaterial& material) {
  if (std::isnan(material.loss)) return "not in this table";
  return fmt::format("tangent {:g} at {:g} Hz: damping ratio {:.3g} there", material.loss,
                     material.loss_frequency, material.loss / 2);
}

}  // namespace

const PublishedMaterial& find_published_material(const std::string& given) {
  const std::string name = as_in_the_table(given);
  for (const PublishedMaterial& material : reference::published_materials())
    if (material.name == name) return material;
  throw_unknown_material(given, name);
}

std::string published_material_list() {
  std::string out = fmt::format("{:<24} {:<7} {:>10} {:>22} {:>6} {:>14}  {}\n", "name", "kind", "E",
                                "published from, to", "nu", "density", "loss tangent");
  for (const PublishedMaterial& m : reference::published_materials())
    out += fmt::format("{:<24} {:<7} {:>10} {:>22} {:>6g} {:>8g} kg/m^3  {}\n", m.name, m.kind,
                       shown_modulus(m.young),
                       shown_modulus(m.young_low) + ", " + shown_modulus(m.young_high), m.poisson, m.density,
                       std::isnan(m.loss) ? "-" : fmt::format("{:g} at {:g} Hz", m.loss, m.loss_frequency));
  return out + "\n`mss material --like NAME` has sources, and tables for a scene.\n";
}

std::string published_material_card(const PublishedMaterial& m) {
  std::string out = fmt::format("{}, a {}\n\n", m.name, m.kind);
  const auto line = [&](const char* name, const std::string& text) {
    out += fmt::format("  {:<16} {}\n", name, text);
  };
  line("E", m.young_low == m.young_high
                ? shown_modulus(m.young)
                : fmt::format("{}; published from {} to {}", shown_modulus(m.young),
                              shown_modulus(m.young_low), shown_modulus(m.young_high)));
  line("nu", fmt::format("{:g}, {}", m.poisson, m.poisson_measured ? "measured" : "assumed"));
  line("density", fmt::format("{:g} kg/m^3", m.density));
  line("loss", shown_loss(m));
  line("measured", m.measured);
  line("source", m.source);
  return out + "\nFor a scene file:\n\n" + material_block(m);
}

std::string material_block(const PublishedMaterial& m) {
  std::string out = fmt::format("# {}: {}\n[material]\ndensity = {:g}\nyoung = {:.6g}\n", m.name, m.source,
                                m.density, m.young);
  if (m.poisson > largest_block_poisson)
    out += fmt::format(
        "poisson = {:g}  # {:g} in the table; nearer to 1/2 steps get shorter, and little else changes\n",
        largest_block_poisson, m.poisson);
  else
    out += fmt::format("poisson = {:g}\n", m.poisson);
  if (!std::isnan(m.loss))
    out += fmt::format(
        "\n[damping]\nviscosity = {:.3g}  # Pa s: the loss at {:g} Hz; it grows as the frequency\n",
        m.viscosity(), m.loss_frequency);
  return out;
}

}  // namespace mss::cli
