// `mss coarsen`: writes a scene in larger cells, whose moduli make them vibrate as those of the given one do.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/scene/scene_edit.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

struct CoarsenChoice {
  std::string scene;
  std::string match = "both";
  std::string file;
  std::vector<std::string> overrides;
  int cells = 0;
};

FrequencyMatch::Of read_match(const std::string& name) {
  using Of = FrequencyMatch::Of;
  std::vector<std::string> names;
  for (const Of of : {Of::bending, Of::torsion, Of::both, Of::modes}) {
    if (to_string(of) == name) return of;
    names.push_back(to_string(of));
  }
  throw InputError(fmt::format("--match is \"{}\"; {}give one of {}", name, question(name, names),
                               fmt::join(names, ", ")));
}

int longest_side(const Scene& scene) {
  const std::array<int, 3> cells = scene.body.voxels.size();
  return *std::max_element(cells.begin(), cells.end());
}

/// Throws InputError for a scene whose moduli cannot be changed, or whose cells are of several sizes.
void check_coarsenable(const Scene& scene) {
  const auto refuse = [&](const char* problem) {
    throw InputError(fmt::format("{}: {}", scene.file.string(), problem));
  };
  check_one_body(scene, "mss coarsen");
  if (scene.match)
    refuse("body.match is of its own cells, and coarser ones are to be matched to these; leave it out");
  if (is_refined(scene)) refuse("its cells are of several sizes; leave [[refine]] and body.refinement out");
  if (!scene.body.is_solid())
    refuse("it is a rope or a sheet, whose stretching needs no matching; give it fewer cells in body.cells");
  if (!scene.body.elastic)
    refuse("material.springs are given, and E is to be changed; give material.young and material.poisson");
}

/// The scene with so many cells along its longest side. Meshes are filled anew; cells of boxes and of voxel
/// files are merged, which leaves whole ones.
Scene in_cells(const Scene& scene, int cells) {
  const int level = level_of(scene), side = longest_side(scene);
  if (cells < 1 || cells >= side)
    throw InputError(
        fmt::format("--cells is {}, and {} has {} along its longest side; give fewer, at least 1", cells,
                    scene.name, side));
  SceneEdit edit = edit_of(scene);
  if (scene.mesh) {
    edit.level = cells;
  } else {
    const int coarsest = side / level;
    if (coarsest == side)
      throw InputError(
          fmt::format("{}: its cells do not merge into larger ones that fill the same body; give it as a "
                      "mesh (body.mesh)",
                      scene.file.string()));
    if (cells % coarsest != 0)
      throw InputError(
          fmt::format("--cells is {}, and cells of {} merge into {} along its longest side or a multiple of "
                      "that; give one",
                      cells, scene.name, coarsest));
    edit.level = cells / coarsest;
  }
  return edited(scene, edit);
}

/// The report as a comment; its first line says what the scene is.
std::string comment(const Scene& fine, const MatchedScene& coarse) {
  std::string text = fmt::format(
      "# {} in {} cells along its longest side in place of {}, moduli matched by `mss coarsen`.\n", fine.name,
      longest_side(coarse.scene), longest_side(fine));
  for (const std::string& line : description(*coarse.report)) text += "# " + line + "\n";
  return text;
}

void run_coarsen(const CoarsenChoice& choice) {
  const FrequencyMatch::Of of = read_match(choice.match);
  const Scene fine = load_scene(scene_file(choice.scene), choice.overrides);
  check_coarsenable(fine);
  check_model(fine);
  const MatchedScene coarse = matched_to(in_cells(fine, choice.cells), of, fine);
  const fs::path file = choice.file.empty()
                            ? fs::path("out") / fmt::format("{}_{}.toml", fine.name, choice.cells)
                            : fs::path(choice.file);
  for (const std::string& warning : coarse.scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  write_atomically(file, comment(fine, coarse) + to_toml(coarse.scene, file.parent_path()));
  for (const std::string& line : description(*coarse.report)) fmt::print("{}: {}\n", fine.name, line);
  fmt::print("{}: {} cells in place of {}; see {}\n", fine.name, coarse.scene.body.voxels.count(),
             fine.body.voxels.count(), file.string());
}

void add_coarsen(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand(
      "coarsen", "write a scene in larger cells, with moduli that keep its slowest vibrations");
  const auto choice = std::make_shared<CoarsenChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--cells", choice->cells, "Cells along its longest side")->required();
  command
      ->add_option("--match", choice->match,
                   "What keeps its frequency: bending, torsion, both, or modes, the slowest few")
      ->capture_default_str();
  command->add_option("--out", choice->file, "File to write (default ./out/<scene>_<cells>.toml)");
  add_settings(*command, choice->overrides);
  command->callback([choice] { run_coarsen(*choice); });
}

}  // namespace

Command coarsen_command() { return add_coarsen; }

}  // namespace mss::cli
