// `mss material`: the material card of a set of spring constants, given or derived from E and nu; with
// --like, constants of published materials.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/error.hpp"
#include "core/body/material.hpp"
#include "core/body/phonons.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/published_material.hpp"

namespace mss::cli {

namespace {

struct MaterialChoice {
  std::optional<double> young, poisson, face_share;
  std::optional<double> edge, face, body, volume;
  std::optional<double> cell_size;
  std::string like;  ///< with --like; empty: all
};

constexpr const char* usage =
    "give either --young and --poisson (and --face-share), or --edge, --face, --body and --volume";

double required(const std::optional<double>& value, const char* option) {
  if (!value) throw InputError(fmt::format("{} is missing; {}", option, usage));
  return *value;
}

double spring_constant(const std::optional<double>& value, const char* option) {
  const double k = required(value, option);
  if (!(k >= 0) || !std::isfinite(k))
    throw InputError(fmt::format("{} is {}; give a stiffness in N/m, 0 or more", option, k));
  return k;
}

double cell_size(const MaterialChoice& choice) {
  if (!choice.cell_size) throw InputError("--cell-size is missing; give the edge of a cell in metres");
  const double h = *choice.cell_size;
  if (!(h > 0) || !std::isfinite(h))
    throw InputError(fmt::format("--cell-size is {}; give the edge of a cell in metres, above 0", h));
  return h;
}

SpringConstants given_springs(const MaterialChoice& choice) {
  const SpringConstants springs{.edge = spring_constant(choice.edge, "--edge"),
                                .face = spring_constant(choice.face, "--face"),
                                .body = spring_constant(choice.body, "--body"),
                                .volume = required(choice.volume, "--volume")};
  if (!std::isfinite(springs.volume))
    throw InputError(fmt::format("--volume is {}; give a volume stiffness in Pa", springs.volume));
  if (springs.edge + springs.face + springs.body == 0)
    throw InputError("--edge, --face and --body are all 0; at least one spring constant must be above 0");
  return springs;
}

SpringConstants derived_springs(const MaterialChoice& choice, double h) {
  const ElasticConstants material{.young = required(choice.young, "--young"),
                                  .poisson = required(choice.poisson, "--poisson")};
  return calibrate(material, h, choice.face_share.value_or(0.5));
}

/// A number with six digits; what divides by zero is undefined.
std::string shown(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : "undefined"; }

std::string shown_limit(const PhononLimit& limit) {
  return std::isfinite(limit.strain) ? fmt::format("{:.3f}", limit.strain)
                                     : fmt::format("{:g} or more", farthest_strain);
}

/// Young's modulus by direction in the plane of two edges, as a curve about the origin drawn with characters;
/// a circle is an isotropic material. Empty if some direction has none.
std::string polar_plot(const CubicStiffness& c) {
  constexpr int angles = 720, rows = 8, columns = 2 * rows;  // a character is twice as high as wide
  constexpr double pi = std::numbers::pi;
  const auto direction = [&](int i) {
    return Eigen::Vector3d(std::cos(2 * pi * i / angles), std::sin(2 * pi * i / angles), 0);
  };
  double largest = 0;
  for (int i = 0; i < angles; ++i) {
    const double young = c.young(direction(i));
    if (!std::isfinite(young) || young < 0) return {};
    largest = std::max(largest, young);
  }
  if (largest == 0) return {};
  std::vector<std::string> canvas(2 * rows + 1, std::string(2 * columns + 1, ' '));
  for (std::string& row : canvas) row[columns] = '|';
  canvas[rows] = std::string(2 * columns + 1, '-');
  canvas[rows][columns] = '+';
  for (int i = 0; i < angles; ++i) {
    const Eigen::Vector3d tip = c.young(direction(i)) / largest * direction(i);
    canvas[std::size_t(rows - std::lround(rows * tip[1]))]
          [std::size_t(columns + std::lround(columns * tip[0]))] = '*';
  }
  std::string out = fmt::format(
      "  E in the plane of two edges; the furthest point is {:.6g} Pa, a circle is isotropic\n\n", largest);
  for (const std::string& row : canvas)
    out += fmt::format("      {}\n", row.substr(0, row.find_last_not_of(' ') + 1));
  return out;
}

std::string card(const SpringConstants& springs, double h, const std::string& given) {
  const CubicStiffness c = cubic_stiffness(springs, h);
  std::string out = fmt::format("Material card: {}, cell size {} m\n", given, h);
  const auto section = [&](const char* name) { out += fmt::format("\n{}\n", name); };
  const auto line = [&](const char* name, double value, const char* unit) {
    out += fmt::format("  {:<24} {:>12}{}{}\n", name, shown(value), *unit ? " " : "", unit);
  };
  section("Spring constants (of a spring inside the body)");
  line("edge k_e", springs.edge, "N/m");
  line("face diagonal k_f", springs.face, "N/m");
  line("body diagonal k_c", springs.body, "N/m");
  line("volume k_vol", springs.volume, "Pa");
  section("Elastic constants (infinite lattice, weighted sharing)");
  line("C11", c.c11, "Pa");
  line("C12", c.c12, "Pa");
  line("C44", c.c44, "Pa");
  line("Zener ratio", c.zener_ratio(), "");
  section("Direction of pull            Young's modulus [Pa]   Poisson's ratio (mean)");
  for (const auto& [name, direction] :
       {std::pair{"[100]", Eigen::Vector3d(1, 0, 0)}, std::pair{"[110]", Eigen::Vector3d(1, 1, 0)},
        std::pair{"[111]", Eigen::Vector3d(1, 1, 1)}})
    out +=
        fmt::format("  {:<24} {:>22} {:>24}\n", name, shown(c.young(direction)), shown(c.poisson(direction)));
  if (const std::string plot = polar_plot(c); !plot.empty()) out += "\n" + plot;
  section("Stable up to a strain of");
  for (const StrainPath& path : strain_paths())
    out += fmt::format("  {:<32} {:>12}\n", path.name(),
                       shown_limit(phonon_limit(springs, h, path, farthest_strain)));
  section("Warnings");
  const std::vector<std::string> warnings = material_warnings(springs, h);
  for (const std::string& warning : warnings) out += fmt::format("  {}\n", warning);
  return warnings.empty() ? out + "  none\n" : out;
}

void print_card(const MaterialChoice& choice) {
  const bool elastic = choice.young || choice.poisson || choice.face_share;
  const bool springs = choice.edge || choice.face || choice.body || choice.volume;
  if (elastic == springs)
    throw InputError(
        fmt::format("the material is {}; {}", elastic ? "given in two ways" : "not given", usage));
  const double h = cell_size(choice);
  if (elastic) {
    const std::string given = fmt::format(
        "Young's modulus {} Pa, Poisson's ratio {}, face share {}", required(choice.young, "--young"),
        required(choice.poisson, "--poisson"), choice.face_share.value_or(0.5));
    fmt::print("{}", card(derived_springs(choice, h), h, given));
  } else {
    fmt::print("{}", card(given_springs(choice), h, "spring constants as given"));
  }
}

void print_published(const MaterialChoice& choice) {
  if (choice.young || choice.poisson || choice.face_share || choice.edge || choice.face || choice.body ||
      choice.volume || choice.cell_size)
    throw InputError("--like stands beside other options; give it alone, then E and nu that it prints");
  fmt::print("{}", choice.like.empty() ? published_material_list()
                                       : published_material_card(find_published_material(choice.like)));
}

void add_material(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand(
      "material", "the material card of springs, or springs for E and nu; constants of published materials");
  const auto choice = std::make_shared<MaterialChoice>();
  command->add_option("--cell-size", choice->cell_size, "Edge of a cell [m]");
  command->add_option("--young", choice->young, "Young's modulus E [Pa]");
  command->add_option("--poisson", choice->poisson, "Poisson's ratio nu, in (-1, 0.5)");
  command->add_option("--face-share", choice->face_share,
                      "Share of the shear stiffness that face diagonals carry, 0 to 1 (default 0.5)");
  command->add_option("--edge", choice->edge, "Stiffness of edges [N/m]");
  command->add_option("--face", choice->face, "Stiffness of face diagonals [N/m]");
  command->add_option("--body", choice->body, "Stiffness of body diagonals [N/m]");
  command->add_option("--volume", choice->volume, "Volume stiffness k_vol [Pa]; may be negative");
  const CLI::Option* like =
      command
          ->add_option(
              "--like", choice->like,
              "A published rubber, foam, gel or tissue: its constants, sources, and tables for a scene; "
              "all if no name follows")
          ->expected(0, 1);
  command->callback([choice, like] {
    if (like->count() > 0)
      print_published(*choice);
    else
      print_card(*choice);
  });
}

}  // namespace

Command material_command() { return add_material; }

}  // namespace mss::cli
