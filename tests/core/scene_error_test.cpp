// Every malformed scene is refused in one sentence that names the file, the line, the key and the remedy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/error.hpp"
#include "core/scene.hpp"
#include "tests/core/scene_texts.hpp"

namespace mss {
namespace {

using testing::full_scene;
using ::testing::HasSubstr;
using testing::plain_scene;
using testing::replaced;
using testing::SceneFolder;
using ::testing::StartsWith;
using Path = std::filesystem::path;

/// A scene nobody can simulate: `from` in the plain scene becomes `to`.
struct Malformed {
  std::string name;
  std::string from;
  std::string to;
  int line;  ///< where the message must point; 0: to no line
  std::vector<std::string> says;
  std::vector<std::string> overrides;
};

Malformed bad(const std::string& name, const std::string& from, const std::string& to, int line,
              const std::vector<std::string>& says, const std::vector<std::string>& overrides = {}) {
  return {name, from, to, line, says, overrides};
}

void PrintTo(const Malformed& malformed, std::ostream* out) { *out << malformed.name; }

const std::string material = "young = 1e5\npoisson = 0.3";
const std::string bottom_hold = "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n";
const std::string turn = bottom_hold + "turn = ";

std::vector<Malformed> malformed_bodies() {
  return {
      bad("zero_cells", "[2, 2, 2]", "[2, 0, 2]", 2, {"body.cells = [2, 0, 2]", "at least 1"}),
      bad("negative_cells", "[2, 2, 2]", "[-2, 2, 2]", 2, {"body.cells = [-2, 2, 2]", "at least 1"}),
      bad("broken_cells", "[2, 2, 2]", "[2, 2.5, 2]", 2, {"body.cells", "whole numbers"}),
      bad("two_cells", "[2, 2, 2]", "[2, 2]", 2, {"body.cells = [2, 2]", "three whole numbers"}),
      bad("text_cells", "[2, 2, 2]", "\"2x2x2\"", 2, {"body.cells = \"2x2x2\"", "three whole numbers"}),
      bad("huge_cells", "[2, 2, 2]", "[9223372036854775807, 2, 2]", 2, {"body.cells", "three whole numbers"}),
      bad("too_many_cells", "[2, 2, 2]", "[1000, 1000, 1000]", 2, {"body.cells", "at most 200 million"}),
      bad("too_many_particles", "[2, 2, 2]", "[200000000, 1, 1]", 2, {"body.cells", "at most 200 million"}),
      bad("cells_and_voxels", "[2, 2, 2]", "[2, 2, 2]\nvoxels = \"shape.txt\"", 3,
          {"body.voxels", "one of the two"}),
      bad("neither_cells_nor_voxels", "cells = [2, 2, 2]", "", 1,
          {"body.cells is missing", "voxels = \"file\""}),
      bad("no_body", "[body]", "[[hold]]", 2, {"hold.0.cells is not a known key", "body.cells"}),
      bad("no_cell_size", "cell_size = 0.5", "", 1,
          {"body.cell_size is missing", "positive number of metres"}),
      bad("zero_cell_size", "0.5", "0", 3, {"body.cell_size = 0", "positive number of metres"}),
      bad("nan_cell_size", "0.5", "nan", 3, {"body.cell_size = nan", "positive number of metres"}),
      bad("tiny_cell_size", "0.5", "1e-150", 3, {"body.cell_size = 1e-150", "material.density"}),
      bad("short_origin", "0.5", "0.5\norigin = [0, 0]", 4, {"body.origin = [0, 0]", "three finite numbers"}),
      bad("unknown_topology", "0.5", "0.5\ntopology = \"ful\"", 4,
          {"body.topology = \"ful\"", "nearest is \"full\""}),
      bad("number_as_topology", "0.5", "0.5\ntopology = 3", 4, {"body.topology = 3", "\"edges+body\""}),
      bad("unknown_sharing", "0.5", "0.5\nsharing = \"weigted\"", 4,
          {"body.sharing", "nearest is \"weighted\""}),
      bad("missing_voxel_file", "cells = [2, 2, 2]", "voxels = \"no.txt\"", 2,
          {"body.voxels", "no.txt", "path"}),
      bad("number_as_voxel_file", "cells = [2, 2, 2]", "voxels = 5", 2,
          {"body.voxels = 5", "path of a voxel file"}),
      bad("folder_as_voxel_file", "cells = [2, 2, 2]", "voxels = \".\"", 2, {"body.voxels", "text file"}),
      bad("ragged_voxels", "cells = [2, 2, 2]", "voxels = \"ragged.txt\"", 2,
          {"body.voxels", "ragged.txt:2", "equally"}),
      bad("ragged_layers", "cells = [2, 2, 2]", "voxels = \"layers.txt\"", 2,
          {"body.voxels", "layers.txt", "equally"}),
      bad("bad_voxel", "cells = [2, 2, 2]", "voxels = \"bad.txt\"", 2,
          {"body.voxels", "bad.txt:1", "'o'", "'#'"}),
      bad("empty_voxels", "cells = [2, 2, 2]", "voxels = \"empty.txt\"", 2,
          {"body.voxels", "empty.txt", "'#'"}),
      bad("hollow_voxels", "cells = [2, 2, 2]", "voxels = \"hollow.txt\"", 2,
          {"body.voxels", "hollow.txt", "'#'"}),
  };
}

std::vector<Malformed> malformed_materials() {
  const std::string springs = "springs = { edge = 1, face = 1, body = 1 }";
  return {
      bad("negative_density", "1000", "-5", 5, {"material.density = -5", "positive number of kg/m^3"}),
      bad("text_density", "1000", "\"heavy\"", 5,
          {"material.density = \"heavy\"", "positive number of kg/m^3"}),
      bad("infinite_density", "1000", "inf", 5, {"material.density = inf", "positive number of kg/m^3"}),
      bad("date_as_density", "1000", "2020-01-01", 5, {"material.density = a date", "positive number"}),
      bad("no_density", "density = 1000", "", 4,
          {"material.density is missing", "positive number of kg/m^3"}),
      bad("negative_young", "1e5", "-1e5", 6, {"material.young = -100000", "positive number of pascals"}),
      bad("overflowing_young", "1e5", "1.7e308", 6, {"material.young = 1.7e+308", "smaller"},
          {"material.poisson=0.4999999"}),
      bad("incompressible", "0.3", "0.5", 7, {"material.poisson = 0.5", "below 0.5"}),
      bad("beyond_incompressible", "0.3", "0.7", 7, {"material.poisson = 0.7", "below 0.5"}),
      bad("poisson_of_minus_one", "0.3", "-1", 7, {"material.poisson = -1", "above -1"}),
      bad("no_poisson", "poisson = 0.3", "", 4, {"material.poisson is missing", "below 0.5"}),
      bad("no_young", "young = 1e5", "", 4, {"material.young is missing", "positive number of pascals"}),
      bad("face_share_above_one", "0.3", "0.3\nface_share = 1.5", 8,
          {"material.face_share = 1.5", "from 0 to 1"}),
      bad("young_and_springs", "poisson = 0.3", springs, 6, {"material.young", "springs", "one of the two"}),
      bad("young_and_volume", "poisson = 0.3", "poisson = 0.3\nvolume = 1", 8,
          {"material.volume = 1", "one of the two"}),
      bad("neither_young_nor_springs", material, "", 4, {"material.young is missing", "springs = {"}),
      bad("negative_spring", material, "springs = { edge = -1, face = 1, body = 1 }", 6,
          {"material.springs.edge = -1", "not negative"}),
      bad("missing_spring", material, "springs = { edge = 1, face = 1 }", 6,
          {"material.springs.body is missing", "N/m"}),
      bad("springs_as_number", material, "springs = 100", 6, {"material.springs = 100", "table"}),
      bad("infinite_volume", material, springs + "\nvolume = -inf", 7,
          {"material.volume = -inf", "finite number"}),
      bad("negative_damping", "[solve]", "[damping]\nratio = -0.1\n[solve]", 9,
          {"damping.ratio = -0.1", "not negative"}),
      bad("truth_as_damping", "[solve]", "[damping]\nratio = true\n[solve]", 9,
          {"damping.ratio = true", "a number"}),
      bad("number_as_paper", "[solve]", "[damping]\npaper = 1\n[solve]", 9,
          {"damping.paper = 1", "true or false"}),
      bad("ratio_and_paper", "[solve]", "[damping]\nratio = 1\npaper = true\n[solve]", 9,
          {"damping.ratio = 1", "one of the two"}),
  };
}

std::vector<Malformed> malformed_environments() {
  const std::string load = "[[load]]\nbox = [[9, 9, 9], [10, 10, 10]]\nforce = [0, 0, 1]\n[solve]";
  return {
      bad("gravity_as_number", "[solve]", "[environment]\ngravity = -9.81\n[solve]", 9,
          {"environment.gravity = -9.81", "three finite numbers of m/s^2"}),
      bad("nan_gravity", "[solve]", "[environment]\ngravity = [0, 0, nan]\n[solve]", 9,
          {"environment.gravity = [0, 0, nan]", "three finite numbers"}),
      bad("hold_as_table", "[solve]", "[hold]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]", 8,
          {"hold = {...}", "[[hold]]"}),
      bad("hold_without_box", "[solve]", "[[hold]]\naxes = \"x\"\n[solve]", 8,
          {"hold.0.box is missing", "lower corner"}),
      bad("empty_box", "[solve]", "[[hold]]\nbox = []\n[solve]", 9,
          {"hold.0.box = []", "lower corner first"}),
      bad("flat_box", "[solve]", "[[hold]]\nbox = [[0, 0], [1, 1]]\n[solve]", 9,
          {"hold.0.box", "lower corner first"}),
      bad("inverted_box", "[solve]", "[[hold]]\nbox = [[1, 0, 0], [0, 1, 1]]\n[solve]", 9,
          {"hold.0.box = [[1, 0, 0], [0, 1, 1]]", "lower corner first"}),
      bad("infinite_box", "[solve]", "[[hold]]\nbox = [[0, 0, 0], [1, 1, inf]]\n[solve]", 9,
          {"hold.0.box", "[[x, y, z]"}),
      bad("second_hold_selects_nothing", "[solve]",
          bottom_hold + "[[hold]]\nbox = [[9, 9, 9], [9, 9, 9]]\n[solve]", 11,
          {"hold.1.box", "contains no particle", "[0, 0, 0] to [1, 1, 1]"}),
      bad("hold_between_particles", "[solve]", "[[hold]]\nbox = [[0.1, 0.1, 0.1], [0.4, 0.4, 0.4]]\n[solve]",
          9, {"hold.0.box", "contains no particle"}),
      bad("load_selects_nothing", "[solve]", load, 9, {"load.0.box", "contains no particle", "[1, 1, 1]"}),
      bad("load_without_force", "[solve]", "[[load]]\nbox = [[0, 0, 0], [1, 1, 1]]\n[solve]", 8,
          {"load.0.force is missing", "newtons"}),
      bad("bad_axes", "[solve]", bottom_hold + "axes = \"xw\"\n[solve]", 10,
          {"hold.0.axes = \"xw\"", "x, y and z"}),
      bad("repeated_axes", "[solve]", bottom_hold + "axes = \"xx\"\n[solve]", 10,
          {"hold.0.axes = \"xx\"", "x, y and z"}),
      bad("no_axes", "[solve]", bottom_hold + "axes = \"\"\n[solve]", 10,
          {"hold.0.axes = \"\"", "x, y and z"}),
      bad("number_as_axes", "[solve]", bottom_hold + "axes = 3\n[solve]", 10,
          {"hold.0.axes = 3", "x, y and z"}),
      bad("short_velocity", "[solve]", bottom_hold + "velocity = [1]\n[solve]", 10,
          {"hold.0.velocity = [1]", "m/s"}),
      bad("text_in_displacement", "[solve]", bottom_hold + "displacement = [0, 0, \"1\"]\n[solve]", 10,
          {"hold.0.displacement = [0, 0, \"1\"]", "metres"}),
      bad("zero_turn_axis", "[solve]", turn + "{ axis = [0, 0, 0], centre = [0, 0, 0], rate = 1 }\n[solve]",
          10, {"hold.0.turn.axis = [0, 0, 0]", "not zero"}),
      bad("turn_without_rate", "[solve]", turn + "{ axis = [0, 0, 1], centre = [0, 0, 0] }\n[solve]", 10,
          {"hold.0.turn.rate is missing", "rad/s"}),
      bad("turn_until_before_start", "[solve]",
          turn + "{ axis = [0, 0, 1], centre = [0, 0, 0], rate = 1, until = -1 }\n[solve]", 10,
          {"hold.0.turn.until = -1", "not negative"}),
      bad("turn_as_number", "[solve]", turn + "3\n[solve]", 10, {"hold.0.turn = 3", "table"}),
      bad("text_as_spin", "[solve]", "[start]\nspin = \"fast\"\n[solve]", 9,
          {"start.spin = \"fast\"", "rad/s"}),
  };
}

std::vector<Malformed> malformed_solves() {
  return {
      bad("zero_dt", "1e-3", "0", 9, {"solve.dt = 0", "positive number of seconds", "\"safe\""}),
      bad("negative_dt", "1e-3", "-1e-3", 9, {"solve.dt = -0.001", "positive number of seconds"}),
      bad("misspelt_safe", "1e-3", "\"save\"", 9, {"solve.dt = \"save\"", "\"safe\""}),
      bad("list_as_dt", "1e-3", "[1e-3]", 9, {"solve.dt = [0.001]", "positive number of seconds"}),
      bad("negative_duration", "duration = 1", "duration = -1", 10, {"solve.duration = -1", "not negative"}),
      bad("infinite_duration", "duration = 1", "duration = inf", 10, {"solve.duration = inf", "seconds"}),
      bad("zero_every", "duration = 1", "every = 0.0", 10, {"solve.every = 0", "positive number of seconds"}),
      bad("negative_threads", "duration = 1", "threads = -1", 10, {"solve.threads = -1", "from 0"}),
      bad("broken_threads", "duration = 1", "threads = 1.5", 10, {"solve.threads = 1.5", "whole number"}),
      bad("too_many_threads", "duration = 1", "threads = 100000", 10, {"solve.threads = 100000", "1024"}),
      bad("unknown_precision", "duration = 1", "precision = \"singel\"", 10,
          {"solve.precision", "nearest is \"single\""}),
      bad("number_as_integrator", "duration = 1", "integrator = 1", 10, {"solve.integrator = 1", "name"}),
      bad("no_integrator", "duration = 1", "integrator = \"\"", 10, {"solve.integrator = \"\"", "name"}),
      bad("solve_as_array", "[solve]", "[[solve]]", 8, {"solve = [{...}]", "not a table"}),
  };
}

std::vector<Malformed> malformed_toml() {
  return {
      bad("bad_toml", "density = 1000", "density = = 1000", 5, {"this is not TOML"}),
      bad("unclosed_array", "[2, 2, 2]", "[2, 2, 2", 3, {"this is not TOML"}),
      bad("duplicate_key", "0.5", "0.5\ncell_size = 1", 4, {"this is not TOML", "cell_size"}),
      bad("unknown_table", "[material]", "[materail]", 4,
          {"materail is not a known table", "did you mean material?"}),
      bad("unknown_key", "density", "densty", 5,
          {"material.densty is not a known key", "mean material.density?"}),
      bad("key_of_another_table", "cell_size = 0.5", "density = 1", 3,
          {"body.density", "did you mean material.density?"}),
      bad("key_outside_tables", "[body]", "gravity = 9.81\n[body]", 1,
          {"gravity", "did you mean environment.gravity?"}),
      bad("unknown_inner_key", material, "springs = { edge = 1, face = 1, bodi = 1 }", 6,
          {"material.springs.bodi is not a known key", "mean material.springs.body?"}),
      bad("unknown_hold_key", "[solve]", bottom_hold + "speed = [0, 0, 1]\n[solve]", 10,
          {"hold.0.speed", "did you mean"}),
      bad("line_break_in_key", "density", "\"den\\nsity\"", 5,
          {"material.den sity", "mean material.density?"}),
      bad("line_break_in_text", "1000", "\"a\\nb\"", 5, {"material.density = \"a b\"", "positive number"}),
  };
}

std::vector<Malformed> malformed_overrides() {
  const auto with = [](const std::string& name, const std::string& text,
                       const std::vector<std::string>& says) {
    return Malformed{name, "[solve]", bottom_hold + "[solve]", 0, says, {text}};
  };
  return {
      with("override_without_value", "solve.dt", {"--set solve.dt: ", "table.key=value"}),
      with("override_of_nothing", "=3", {"--set =3: ", "table.key=value"}),
      with("override_with_nothing", "solve.dt=", {"--set solve.dt=: ", "one TOML value"}),
      with("override_of_two_lines", "solve.dt=1\nx=2", {"--set solve.dt=1 x=2: ", "one TOML value"}),
      with("override_unclosed", "start.spin=[1, 2", {"--set start.spin=[1, 2: ", "one TOML value"}),
      with("override_out_of_range", "material.density=-5",
           {"--set material.density=-5: material.density = -5", "kg/m^3"}),
      with("override_unknown", "solve.td=5", {"--set solve.td=5: solve.td is not a known key", "solve.dt"}),
      with("override_unknown_table", "slove.dt=5", {"--set slove.dt=5: slove is not a known table", "solve"}),
      with("override_below_value", "body.cell_size.x=5",
           {"--set body.cell_size.x=5: 'x' stands below", "table"}),
      with("override_beyond_array", "hold.1.axes=x", {"--set hold.1.axes=x: '1' is none of the 1", "from 0"}),
      with("override_not_an_index", "hold.first.axes=x", {"--set hold.first.axes=x: 'first'", "from 0"}),
      with("override_of_an_element", "hold.0.box.1.2=nan",
           {"--set hold.0.box.1.2=nan: hold.0.box", "[[x, y, z]"}),
      with("override_empty_keys", "..=1", {"--set ..=1: ", "table.key=value"}),
  };
}

class MalformedScene : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedScene, IsRefusedInOneUsefulSentence) {
  const Malformed& malformed = GetParam();
  const SceneFolder folder;
  folder.write("ragged.txt", "##\n#\n");
  folder.write("layers.txt", "##\n##\n\n##\n");
  folder.write("bad.txt", "#o\n");
  folder.write("empty.txt", "");
  folder.write("hollow.txt", "..\n");
  const Path file = folder.write("scene.toml", replaced(plain_scene, malformed.from, malformed.to));
  try {
    load_scene(file, malformed.overrides);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string place = malformed.line == 0 ? "" : ":" + std::to_string(malformed.line) + ": ";
    if (malformed.overrides.empty()) {
      EXPECT_THAT(message, StartsWith(file.string() + place));
    }
    for (const std::string& part : malformed.says) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 400U) << message;
  }
}

std::vector<Malformed> all_malformed() {
  std::vector<Malformed> all;
  for (const auto& some : {malformed_bodies(), malformed_materials(), malformed_environments(),
                           malformed_solves(), malformed_toml(), malformed_overrides()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

INSTANTIATE_TEST_SUITE_P(Scene, MalformedScene, ::testing::ValuesIn(all_malformed()),
                         [](const auto& instance) { return instance.param.name; });

std::string refusal_of(const Path& file) {
  try {
    load_scene(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scene, RefusesWhatIsNoFile) {
  const SceneFolder folder;
  EXPECT_EQ(refusal_of(folder.path() / "none.toml"),
            (folder.path() / "none.toml").string() +
                ": cannot read this scene file; check its path and permissions");
  EXPECT_THAT(refusal_of(folder.path()), StartsWith(folder.path().string() + ": is a directory; give"));
  EXPECT_THAT(refusal_of(folder.write("empty.toml", "")),
              HasSubstr("empty.toml: body.cells is missing; give"));
  EXPECT_THAT(refusal_of(folder.write("binary.toml", "\xff\xfe\x01[body]")),
              HasSubstr("binary.toml:1: this is not TOML"));
}

// Whatever a file holds, the answer is a scene or an InputError of one line.
TEST(Scene, SurvivesDamagedFiles) {
  const SceneFolder folder;
  const std::string alphabet = "[]{}=.,\"#\n -+0129exyzinfa_\\\x01\xff";
  std::mt19937 rng(1);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(rng); };
  int refused = 0, accepted = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = full_scene;
    for (std::size_t edit = 0; edit <= below(3); ++edit) {
      if (below(2) == 0)
        text[below(text.size())] = alphabet[below(alphabet.size())];
      else
        text.erase(below(text.size()), 1 + below(5));
    }
    const std::string message = refusal_of(folder.write("scene.toml", text));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    ++(message == "accepted" ? accepted : refused);
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace mss
