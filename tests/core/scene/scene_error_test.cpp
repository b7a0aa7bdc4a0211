// Every malformed scene is refused in one sentence that names the file, the line, the key and the remedy.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string_view>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A scene that cannot be simulated: `from` in the plain scene becomes `to`.
struct Malformed {
  const char* name;
  const char* from;
  const char* to;
  int line;  ///< where the message must point; 0: to no line
  std::array<std::string_view, 4> says;
  const char* override_with = nullptr;
};

void PrintTo(const Malformed& malformed, std::ostream* out) { *out << malformed.name; }

constexpr Malformed malformed_bodies[]{
    {"zero_cells", "[2, 2, 2]", "[0, 0, 0]", 2, {"body.cells = [0, 0, 0]", "at least one"}},
    {"negative_cells", "[2, 2, 2]", "[-2, 2, 2]", 2, {"body.cells = [-2, 2, 2]", "0 where a sheet"}},
    {"thick_body",
     "[2, 2, 2]",
     "[2, 2, 2]\nthickness = 0.1",
     3,
     {"body.thickness = 0.1", "a sheet or a rope"}},
    {"sheet_without_thickness",
     "[2, 2, 2]",
     "[2, 2, 0]\nthickness = 0",
     3,
     {"body.thickness = 0", "positive"}},
    {"sheet_of_a_topology",
     "[2, 2, 2]",
     "[2, 2, 0]\ntopology = \"edges+body\"",
     3,
     {"body.topology", "cells of three dimensions", "a sheet"}},
    {"sheet_of_no_mass",
     "[2, 2, 2]",
     "[2, 2, 0]\nthickness = 1e-320",
     3,
     {"body.thickness", "particles of mass"}},
    {"matched_rope", "[2, 2, 2]", "[2, 0, 0]\nmatch = \"bending\"", 3, {"body.match", "a rope"}},
    {"broken_cells", "[2, 2, 2]", "[2, 2.5, 2]", 2, {"body.cells", "whole numbers"}},
    {"two_cells", "[2, 2, 2]", "[2, 2]", 2, {"body.cells = [2, 2]", "three whole numbers"}},
    {"text_cells", "[2, 2, 2]", "\"2x2x2\"", 2, {"body.cells = \"2x2x2\"", "three whole numbers"}},
    {"huge_cells", "[2, 2, 2]", "[9223372036854775807, 2, 2]", 2, {"body.cells", "three whole numbers"}},
    {"too_many_cells", "[2, 2, 2]", "[1000, 1000, 1000]", 2, {"body.cells", "at most 200 million"}},
    {"too_many_particles", "[2, 2, 2]", "[200000000, 1, 1]", 2, {"body.cells", "at most 200 million"}},
    {"cells_and_voxels",
     "[2, 2, 2]",
     "[2, 2, 2]\nvoxels = \"shape.txt\"",
     3,
     {"body.voxels", "one of the two"}},
    {"neither_cells_nor_voxels", "cells = [2, 2, 2]", "", 1, {"body.cells is missing", "voxels = \"file\""}},
    {"no_body", "[body]", "[[hold]]", 2, {"hold.0.cells is not a known key", "body.cells"}},
    {"no_cell_size", "cell_size = 0.5", "", 1, {"body.cell_size is missing", "positive number of metres"}},
    {"zero_cell_size", "0.5", "0", 3, {"body.cell_size = 0", "positive number of metres"}},
    {"nan_cell_size", "0.5", "nan", 3, {"body.cell_size = nan", "positive number of metres"}},
    {"tiny_cell_size", "0.5", "1e-150", 3, {"body.cell_size = 1e-150", "material.density"}},
    {"short_origin", "0.5", "0.5\norigin = [0, 0]", 4, {"body.origin = [0, 0]", "three finite numbers"}},
    {"unknown_topology",
     "0.5",
     "0.5\ntopology = \"ful\"",
     4,
     {"body.topology = \"ful\"", "nearest is \"full\""}},
    {"number_as_topology", "0.5", "0.5\ntopology = 3", 4, {"body.topology = 3", "\"edges+body\""}},
    {"unknown_sharing", "0.5", "0.5\nsharing = \"weigted\"", 4, {"body.sharing", "nearest is \"weighted\""}},
    {"missing_voxel_file", "cells = [2, 2, 2]", "voxels = \"no.txt\"", 2, {"body.voxels", "no.txt", "path"}},
    {"number_as_voxel_file",
     "cells = [2, 2, 2]",
     "voxels = 5",
     2,
     {"body.voxels = 5", "path of a voxel file"}},
    {"folder_as_voxel_file", "cells = [2, 2, 2]", "voxels = \".\"", 2, {"body.voxels", "text file"}},
    {"ragged_voxels",
     "cells = [2, 2, 2]",
     "voxels = \"ragged.txt\"",
     2,
     {"body.voxels", "ragged.txt:2", "equally"}},
    {"ragged_layers",
     "cells = [2, 2, 2]",
     "voxels = \"layers.txt\"",
     2,
     {"body.voxels", "layers.txt", "equally"}},
    {"bad_voxel", "cells = [2, 2, 2]", "voxels = \"bad.txt\"", 2, {"body.voxels", "bad.txt:1", "'o'", "'#'"}},
    {"cell_of_no_part",
     "cells = [2, 2, 2]",
     "voxels = \"parts.txt\"",
     2,
     {"body.voxels", "parts.txt:1", "'A'", "no part has that name"}},
    {"part_of_no_cell",
     "[solve]",
     "[[part]]\nname = \"A\"\n[solve]",
     9,
     {"part.0.name = \"A\"", "names a part that no cell uses", "body.voxels"}},
    {"uniform_tenths",
     "cells = [2, 2, 2]",
     "voxels = \"tenths.txt\"\nsharing = \"uniform\"",
     3,
     {"body.sharing = \"uniform\"", "full cells of one part", "\"weighted\""}},
    {"empty_voxels", "cells = [2, 2, 2]", "voxels = \"empty.txt\"", 2, {"body.voxels", "empty.txt", "'#'"}},
    {"hollow_voxels",
     "cells = [2, 2, 2]",
     "voxels = \"hollow.txt\"",
     2,
     {"body.voxels", "hollow.txt", "'#'"}},
};

constexpr Malformed malformed_materials[]{
    {"negative_density", "1000", "-5", 5, {"material.density = -5", "positive number of kg/m^3"}},
    {"text_density", "1000", "\"heavy\"", 5, {"material.density = \"heavy\"", "positive number of kg/m^3"}},
    {"infinite_density", "1000", "inf", 5, {"material.density = inf", "positive number of kg/m^3"}},
    {"date_as_density", "1000", "2020-01-01", 5, {"material.density = a date", "positive number"}},
    {"no_density", "density = 1000", "", 4, {"material.density is missing", "positive number of kg/m^3"}},
    {"negative_young", "1e5", "-1e5", 6, {"material.young = -100000", "positive number of pascals"}},
    {"overflowing_young",
     "1e5",
     "1.7e308",
     6,
     {"material.young = 1.7e+308", "smaller"},
     "material.poisson=0.4999999"},
    {"incompressible", "0.3", "0.5", 7, {"material.poisson = 0.5", "below 0.5"}},
    {"beyond_incompressible", "0.3", "0.7", 7, {"material.poisson = 0.7", "below 0.5"}},
    {"poisson_of_minus_one", "0.3", "-1", 7, {"material.poisson = -1", "above -1"}},
    {"no_poisson", "poisson = 0.3", "", 4, {"material.poisson is missing", "below 0.5"}},
    {"no_young", "young = 1e5", "", 4, {"material.young is missing", "positive number of pascals"}},
    {"fold_guard_below_zero", "0.3", "0.3\nfold_guard = -1", 8, {"material.fold_guard = -1", "not negative"}},
    {"fold_guard_without_shear",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 0, body = 0 }\nfold_guard = 5",
     7,
     {"material.fold_guard = 5", "face or body diagonals"}},
    {"face_share_above_one", "0.3", "0.3\nface_share = 1.5", 8, {"material.face_share = 1.5", "from 0 to 1"}},
    {"young_and_springs",
     "poisson = 0.3",
     "springs = { edge = 1, face = 1, body = 1 }",
     6,
     {"material.young", "springs", "one of the two"}},
    {"young_and_volume",
     "poisson = 0.3",
     "poisson = 0.3\nvolume = 1",
     8,
     {"material.volume = 1", "one of the two"}},
    {"neither_young_nor_springs",
     "young = 1e5\npoisson = 0.3",
     "",
     4,
     {"material.young is missing", "springs = {"}},
    {"negative_spring",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = -1, face = 1, body = 1 }",
     6,
     {"material.springs.edge = -1", "not negative"}},
    {"missing_spring",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 1 }",
     6,
     {"material.springs.body is missing", "N/m"}},
    {"springs_as_number",
     "young = 1e5\npoisson = 0.3",
     "springs = 100",
     6,
     {"material.springs = 100", "table"}},
    {"infinite_volume",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 1, body = 1 }\nvolume = -inf",
     7,
     {"material.volume = -inf", "finite number"}},
    {"negative_damping",
     "[solve]",
     "[damping]\nratio = -0.1\n[solve]",
     9,
     {"damping.ratio = -0.1", "not negative"}},
    {"cells_in_no_parts",
     "cells = [2, 2, 2]",
     "cells = [2, 2, 2]\nrefine = 0",
     3,
     {"body.refine = 0", "at least 1"}},
    {"too_many_parts",
     "cells = [2, 2, 2]",
     "cells = [2, 2, 2]\nrefine = 400",
     2,
     {"million particles", "give fewer cells"}},
    {"volume_force_of_given_springs",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 1, body = 1 }\nvolume_force = false",
     7,
     {"material.volume_force", "one of the two"}},
    {"truth_as_damping",
     "[solve]",
     "[damping]\nratio = true\n[solve]",
     9,
     {"damping.ratio = true", "a number"}},
    {"number_as_thesis",
     "[solve]",
     "[damping]\nthesis = 1\n[solve]",
     9,
     {"damping.thesis = 1", "true or false"}},
    {"number_as_paper",
     "[solve]",
     "[damping]\npaper = 1\n[solve]",
     9,
     {"damping.thesis = 1", "true or false"}},
    {"ratio_and_thesis",
     "[solve]",
     "[damping]\nratio = 1\nthesis = true\n[solve]",
     9,
     {"damping.ratio = 1", "damping.thesis = true", "one of the two"}},
    {"ratio_and_viscosity",
     "[solve]",
     "[damping]\nratio = 1\nviscosity = 2\n[solve]",
     10,
     {"damping.viscosity = 2", "damping.ratio", "one of the two"}},
    {"viscosity_and_thesis",
     "[solve]",
     "[damping]\nviscosity = 2\nthesis = true\n[solve]",
     9,
     {"damping.viscosity = 2", "damping.thesis = true", "one of the two"}},
    {"negative_viscosity",
     "[solve]",
     "[damping]\nviscosity = -2\n[solve]",
     9,
     {"damping.viscosity = -2", "a number of Pa s"}},
    {"viscosity_without_shear",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 0, body = 0 }\n[damping]\nviscosity = 2",
     8,
     {"damping.viscosity = 2", "face or body diagonals"}},
    {"ratio_and_paper",
     "[solve]",
     "[damping]\nratio = 1\npaper = true\n[solve]",
     9,
     {"damping.ratio = 1", "damping.thesis = true", "one of the two"}},
};

constexpr Malformed malformed_environments[]{
    {"gravity_as_number",
     "[solve]",
     "[environment]\ngravity = -9.81\n[solve]",
     9,
     {"environment.gravity = -9.81", "three finite numbers of m/s^2"}},
    {"nan_gravity",
     "[solve]",
     "[environment]\ngravity = [0, 0, nan]\n[solve]",
     9,
     {"environment.gravity = [0, 0, nan]", "three finite numbers"}},
    {"hold_as_table",
     "[solve]",
     "[hold]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     8,
     {"hold = {...}", "[[hold]]"}},
    {"hold_without_box",
     "[solve]",
     "[[hold]]\naxes = \"x\"\n[solve]",
     8,
     {"hold.0.box is missing", "lower corner"}},
    {"path_that_goes_back",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\npath = [[0, 0, 0, 0], [2, 0, 0, 1], [1, 0, 0, 0]]\n[solve]",
     10,
     {"hold.0.path", "[t, dx, dy, dz]", "later than the one before"}},
    {"path_of_short_rows",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\npath = [[0, 0, 0]]\n[solve]",
     10,
     {"hold.0.path", "[t, dx, dy, dz]"}},
    {"history_of_a_number",
     "[solve]",
     "[[load]]\nbox = [[0, 0, 0], [1, 1, 0]]\nforce = [0, 0, 1]\nhistory = 2\n[solve]",
     11,
     {"load.0.history = 2", "[t, share]"}},
    {"empty_box", "[solve]", "[[hold]]\nbox = []\n[solve]", 9, {"hold.0.box = []", "lower corner first"}},
    {"flat_box",
     "[solve]",
     "[[hold]]\nbox = [[0, 0], [1, 1]]\n[solve]",
     9,
     {"hold.0.box", "lower corner first"}},
    {"inverted_box",
     "[solve]",
     "[[hold]]\nbox = [[1, 0, 0], [0, 1, 1]]\n[solve]",
     9,
     {"hold.0.box = [[1, 0, 0], [0, 1, 1]]", "lower corner first"}},
    {"infinite_box",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, inf]]\n[solve]",
     9,
     {"hold.0.box", "[[x, y, z]"}},
    {"second_hold_selects_nothing",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[[hold]]\nbox = [[9, 9, 9], [9, 9, 9]]\n[solve]",
     11,
     {"hold.1.box", "contains no particle", "[0, 0, 0] to [1, 1, 1]"}},
    {"hold_between_particles",
     "[solve]",
     "[[hold]]\nbox = [[0.1, 0.1, 0.1], [0.4, 0.4, 0.4]]\n[solve]",
     9,
     {"hold.0.box", "contains no particle"}},
    {"load_selects_nothing",
     "[solve]",
     "[[load]]\nbox = [[9, 9, 9], [10, 10, 10]]\nforce = [0, 0, 1]\n[solve]",
     9,
     {"load.0.box", "contains no particle", "[1, 1, 1]"}},
    {"load_without_force",
     "[solve]",
     "[[load]]\nbox = [[0, 0, 0], [1, 1, 1]]\n[solve]",
     8,
     {"load.0.force is missing", "newtons"}},
    {"strike_selects_nothing",
     "[solve]",
     "[[strike]]\nbox = [[9, 9, 9], [10, 10, 10]]\nat = 1\nimpulse = [0, 0, 1]\n[solve]",
     9,
     {"strike.0.box", "contains no particle", "[1, 1, 1]"}},
    {"strike_before_the_start",
     "[solve]",
     "[[strike]]\nbox = [[0, 0, 0], [1, 1, 1]]\nat = -1\nimpulse = [0, 0, 1]\n[solve]",
     10,
     {"strike.0.at = -1", "not negative"}},
    {"negative_sleep", "[solve]", "[solve]\nsleep = -1e-3", 9, {"solve.sleep = -0.001", "not negative"}},
    {"weight_selects_nothing",
     "[solve]",
     "[[weight]]\nbox = [[9, 9, 9], [10, 10, 10]]\nmass = 1\n[solve]",
     9,
     {"weight.0.box", "contains no particle", "[1, 1, 1]"}},
    {"weight_of_nothing",
     "[solve]",
     "[[weight]]\nbox = [[0, 0, 0], [1, 1, 1]]\nmass = 0\n[solve]",
     10,
     {"weight.0.mass = 0", "positive number of kilograms"}},
    {"refines_nothing",
     "[solve]",
     "[[refine]]\nbox = [[1, 0, 0], [2, 1, 1]]\n[solve]",
     9,
     {"refine.0.box", "contains no part of a cell", "[1, 1, 1]"}},
    {"refines_too_far",
     "[solve]",
     "[[refine]]\nbox = [[0, 0, 0], [1, 1, 1]]\nlevels = 5\n[solve]",
     10,
     {"refine.0.levels = 5", "from 1 to 4"}},
    {"refines_elements",
     "poisson = 0.3",
     "poisson = 0.3\nmodel = \"linear\"\n[[refine]]\nbox = [[0, 0, 0], [0.5, 1, 1]]",
     10,
     {"refine.0.box", "is for model \"springs\"", "\"linear\""}},
    {"refines_uniform_sharing",
     "0.5\n",
     "0.5\nsharing = \"uniform\"\n[[refine]]\nbox = [[0, 0, 0], [0.5, 1, 1]]\n",
     6,
     {"refine.0.box", "sharing = \"weighted\""}},
    {"refines_beside_weights",
     "[solve]",
     "[[weight]]\nbox = [[0, 0, 0], [1, 1, 1]]\nmass = 1\n[[refine]]\nbox = [[0, 0, 0], [0.5, 1, "
     "1]]\n[solve]",
     12,
     {"refine.0.box", "weights are for bodies with cells of one size"}},
    {"holds_half_an_edge_of_larger_cells",
     "[solve]",
     "[[hold]]\nbox = [[0, 0.2, 0], [1, 0.3, 0]]\n[[refine]]\nbox = [[0, 0, 0], [0.5, 1, 1]]\n[solve]",
     11,
     {"refine.0.box", "a hold takes the particle at [0.5, 0.25, 0]"}},
    {"chooses_cells_in_no_known_way",
     "0.5\n",
     "0.5\nrefinement = \"by hand\"\n",
     4,
     {"body.refinement = \"by hand\"", "\"auto\""}},
    {"chooses_cells_for_no_known_goal",
     "0.5\n",
     "0.5\nrefinement = \"auto\"\nrefinement_goal = \"stress\"\n",
     5,
     {"body.refinement_goal = \"stress\"", "\"displacement\""}},
    {"chooses_cells_for_a_goal_that_is_missing",
     "0.5\n",
     "0.5\nrefinement = \"auto\"\nrefinement_goal = \"displacement\"\n",
     5,
     {"body.refinement_goal", "[expect]"}},
    {"expects_a_force_of_no_plane",
     "duration = 1\n",
     "duration = 1\n[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n[expect]\nplane_1_z = { value = 1, "
     "within "
     "= 1 }\n",
     15,
     {"expect.plane_1_z = {...}", "none of the scene's 0 holds and 1 planes", "from 0"}},
    {"expects_a_force_along_no_axis",
     "duration = 1\n",
     "duration = 1\n[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n[expect]\nplane_0_w = { value = 1, "
     "within "
     "= 1 }\n",
     15,
     {"expect.plane_0_w is not a known table", "plane_#_x/y/z"}},
    {"levels_of_no_chosen_cells",
     "0.5\n",
     "0.5\nrefinement_levels = 2\n",
     4,
     {"body.refinement_levels = 2", "body.refinement = \"auto\""}},
    {"chooses_cells_too_small",
     "0.5\n",
     "0.5\nrefinement = \"auto\"\nrefinement_levels = 5\n",
     5,
     {"body.refinement_levels = 5", "from 1 to 4"}},
    {"chooses_cells_and_gives_them",
     "0.5\n",
     "0.5\nrefinement = \"auto\"\n[[refine]]\nbox = [[0, 0, 0], [0.5, 1, 1]]\n",
     4,
     {"body.refinement = \"auto\"", "leave one of them out"}},
    {"chooses_cells_of_elements",
     "0.5\n",
     "0.5\nrefinement = \"auto\"\n",
     4,
     {"body.refinement = \"auto\"", "is for model \"springs\""},
     "material.model=\"linear\""},
    {"chooses_cells_of_uniform_sharing",
     "0.5\n",
     "0.5\nsharing = \"uniform\"\nrefinement = \"auto\"\n",
     5,
     {"body.refinement = \"auto\"", "sharing = \"weighted\""}},
    {"not_a_truth_value",
     "duration = 1",
     "duration = 1\nlocal_steps = 1",
     11,
     {"solve.local_steps = 1", "true or false"}},
    {"bad_axes",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\naxes = \"xw\"\n[solve]",
     10,
     {"hold.0.axes = \"xw\"", "x, y and z"}},
    {"repeated_axes",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\naxes = \"xx\"\n[solve]",
     10,
     {"hold.0.axes = \"xx\"", "x, y and z"}},
    {"no_axes",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\naxes = \"\"\n[solve]",
     10,
     {"hold.0.axes = \"\"", "x, y and z"}},
    {"number_as_axes",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\naxes = 3\n[solve]",
     10,
     {"hold.0.axes = 3", "x, y and z"}},
    {"short_velocity",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nvelocity = [1]\n[solve]",
     10,
     {"hold.0.velocity = [1]", "m/s"}},
    {"text_in_displacement",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\ndisplacement = [0, 0, \"1\"]\n[solve]",
     10,
     {"hold.0.displacement = [0, 0, \"1\"]", "metres"}},
    {"zero_turn_axis",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nturn = { axis = [0, 0, 0], centre = [0, 0, 0], rate = 1 "
     "}\n[solve]",
     10,
     {"hold.0.turn.axis = [0, 0, 0]", "not zero"}},
    {"turn_without_rate",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nturn = { axis = [0, 0, 1], centre = [0, 0, 0] }\n[solve]",
     10,
     {"hold.0.turn.rate is missing", "rad/s"}},
    {"turn_until_before_start",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nturn = { axis = [0, 0, 1], centre = [0, 0, 0], rate = 1, until "
     "= -1 }\n[solve]",
     10,
     {"hold.0.turn.until = -1", "not negative"}},
    {"turn_as_number",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nturn = 3\n[solve]",
     10,
     {"hold.0.turn = 3", "table"}},
    {"plane_without_point",
     "[solve]",
     "[[plane]]\nnormal = [0, 0, 1]\n[solve]",
     8,
     {"plane.0.point is missing", "metres"}},
    {"plane_without_normal",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\n[solve]",
     8,
     {"plane.0.normal is missing", "not zero"}},
    {"zero_normal",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 0]\n[solve]",
     10,
     {"plane.0.normal = [0, 0, 0] is not a normal", "not zero"}},
    {"misspelt_contact",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\ncontact = \"impuls\"\n[solve]",
     11,
     {"plane.0.contact = \"impuls\"", "nearest is \"impulse\""}},
    {"restitution_above_one",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nrestitution = 1.01\n[solve]",
     11,
     {"plane.0.restitution = 1.01", "from 0 (nothing rebounds) to 1"}},
    {"negative_restitution",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nrestitution = -0.5\n[solve]",
     11,
     {"plane.0.restitution = -0.5", "from 0"}},
    {"negative_friction",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfriction = -0.1\n[solve]",
     11,
     {"plane.0.friction = -0.1", "not negative"}},
    {"plane_as_table",
     "[solve]",
     "[plane]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n[solve]",
     8,
     {"plane = {...}", "[[plane]]"}},
    {"text_as_angular_velocity",
     "[solve]",
     "[start]\nangular_velocity = \"fast\"\n[solve]",
     9,
     {"start.angular_velocity = \"fast\"", "rad/s"}},
    {"two_names_of_a_key",
     "[solve]",
     "[start]\nspin = [1, 2, 3]\nangular_velocity = [1, 2, 3]\n[solve]",
     9,
     {"start.spin conflicts with start.angular_velocity", "one of the two"}},
    {"text_as_spin",
     "[solve]",
     "[start]\nspin = \"fast\"\n[solve]",
     9,
     {"start.angular_velocity = \"fast\"", "rad/s"}},
};

constexpr Malformed malformed_solves[]{
    {"zero_tolerance", "duration = 1", "tolerance = 0", 10, {"solve.tolerance = 0", "above 0 and below 1"}},
    {"unknown_tangent", "duration = 1", "tangent = \"exact\"", 10, {"solve.tangent = \"exact\"", "elastic"}},
    {"spectral_radius_above_one",
     "duration = 1",
     "spectral_radius = 1.2",
     10,
     {"solve.spectral_radius = 1.2", "from 0", "to 1"}},
    {"regions_too_wide", "duration = 1", "region_width = 17", 10, {"solve.region_width = 17", "0", "16"}},
    {"alpha_above_one", "duration = 1", "alpha = 1.5", 10, {"solve.alpha = 1.5", "up to 1"}},
    {"negative_spectral_radius",
     "duration = 1",
     "spectral_radius = -0.1",
     10,
     {"solve.spectral_radius = -0.1", "from 0"}},
    {"number_as_linear_solver", "duration = 1", "linear_solver = 1", 10, {"solve.linear_solver = 1", "name"}},
    {"number_as_nonlinear_solver",
     "duration = 1",
     "nonlinear_solver = 1",
     10,
     {"solve.nonlinear_solver = 1"}},
    {"half_an_iteration", "duration = 1", "iterations = 0.5", 10, {"solve.iterations = 0.5", "whole number"}},
    {"zero_dt", "1e-3", "0", 9, {"solve.dt = 0", "positive number of seconds", "\"safe\""}},
    {"negative_dt", "1e-3", "-1e-3", 9, {"solve.dt = -0.001", "positive number of seconds"}},
    {"misspelt_safe", "1e-3", "\"save\"", 9, {"solve.dt = \"save\"", "\"safe\""}},
    {"list_as_dt", "1e-3", "[1e-3]", 9, {"solve.dt = [0.001]", "positive number of seconds"}},
    {"negative_duration", "duration = 1", "duration = -1", 10, {"solve.duration = -1", "not negative"}},
    {"infinite_duration", "duration = 1", "duration = inf", 10, {"solve.duration = inf", "seconds"}},
    {"zero_every", "duration = 1", "every = 0.0", 10, {"solve.every = 0", "positive number of seconds"}},
    {"negative_threads", "duration = 1", "threads = -1", 10, {"solve.threads = -1", "from 0"}},
    {"broken_threads", "duration = 1", "threads = 1.5", 10, {"solve.threads = 1.5", "whole number"}},
    {"too_many_threads", "duration = 1", "threads = 100000", 10, {"solve.threads = 100000", "1024"}},
    {"unknown_precision",
     "duration = 1",
     "precision = \"singel\"",
     10,
     {"solve.precision", "nearest is \"single\""}},
    {"number_as_integrator", "duration = 1", "integrator = 1", 10, {"solve.integrator = 1", "name"}},
    {"no_integrator", "duration = 1", "integrator = \"\"", 10, {"solve.integrator = \"\"", "name"}},
    {"solve_as_array", "[solve]", "[[solve]]", 8, {"solve = [{...}]", "not a table"}},
};

constexpr Malformed malformed_toml[]{
    {"bad_toml", "density = 1000", "density = = 1000", 5, {"this is not TOML"}},
    {"unclosed_array", "[2, 2, 2]", "[2, 2, 2", 3, {"this is not TOML"}},
    {"duplicate_key", "0.5", "0.5\ncell_size = 1", 4, {"this is not TOML", "cell_size"}},
    {"unknown_table",
     "[material]",
     "[materail]",
     4,
     {"materail is not a known table", "did you mean material?"}},
    {"unknown_key", "density", "densty", 5, {"material.densty is not a known key", "mean material.density?"}},
    {"key_of_another_table",
     "cell_size = 0.5",
     "density = 1",
     3,
     {"body.density", "did you mean material.density?"}},
    {"key_outside_tables",
     "[body]",
     "gravity = 9.81\n[body]",
     1,
     {"gravity", "did you mean environment.gravity?"}},
    {"unknown_inner_key",
     "young = 1e5\npoisson = 0.3",
     "springs = { edge = 1, face = 1, bodi = 1 }",
     6,
     {"material.springs.bodi is not a known key", "mean material.springs.body?"}},
    {"unknown_hold_key",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\nvelocty = [0, 0, 1]\n[solve]",
     10,
     {"hold.0.velocty", "did you mean hold.velocity?"}},
    {"unknown_plane_key",
     "[solve]",
     "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfrictoin = 0.1\n[solve]",
     11,
     {"plane.0.frictoin", "mean plane.friction?"}},
    {"line_break_in_key", "density", "\"den\\nsity\"", 5, {"material.den sity", "mean material.density?"}},
    {"line_break_in_text", "1000", "\"a\\nb\"", 5, {"material.density = \"a b\"", "positive number"}},
};

constexpr Malformed malformed_overrides[]{
    {"override_without_value",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set solve.dt: ", "table.key=value"},
     "solve.dt"},
    {"override_of_nothing",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set =3: ", "table.key=value"},
     "=3"},
    {"override_with_nothing",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set solve.dt=: ", "one TOML value"},
     "solve.dt="},
    {"override_of_two_lines",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set solve.dt=1 x=2: ", "one TOML value"},
     "solve.dt=1\nx=2"},
    {"override_unclosed",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set start.angular_velocity=[1, 2: ", "one TOML value"},
     "start.angular_velocity=[1, 2"},
    {"override_out_of_range",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set material.density=-5: material.density = -5", "kg/m^3"},
     "material.density=-5"},
    {"override_unknown",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set solve.td=5: solve.td is not a known key", "solve.dt"},
     "solve.td=5"},
    {"override_unknown_table",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set slove.dt=5: slove is not a known table", "solve"},
     "slove.dt=5"},
    {"override_below_value",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set body.cell_size.x=5: 'x' stands below", "table"},
     "body.cell_size.x=5"},
    {"override_beyond_array",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set hold.1.axes=x: '1' is none of the 1", "from 0"},
     "hold.1.axes=x"},
    {"override_not_an_index",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set hold.first.axes=x: 'first'", "from 0"},
     "hold.first.axes=x"},
    {"override_of_no_array",
     "[solve]",
     "[solve]",
     0,
     {"--set load.0.force=[0, 0, 1]: the scene has no [[load]]", "adds none"},
     "load.0.force=[0, 0, 1]"},
    {"override_of_an_element",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set hold.0.box.1.2=nan: hold.0.box", "[[x, y, z]"},
     "hold.0.box.1.2=nan"},
    {"override_empty_keys",
     "[solve]",
     "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]",
     0,
     {"--set ..=1: ", "table.key=value"},
     "..=1"},
};

/// Beside a voxel file with cells of the letter A.
constexpr Malformed malformed_parts[]{
    {"no_part_name", "name = \"A\"", "", 8, {"part.0.name is missing", "a letter from A to Z"}},
    {"number_as_part_name", "\"A\"", "1", 9, {"part.0.name = 1", "a letter from A to Z"}},
    {"two_of_a_name", "[solve]", "[[part]]\nname = \"A\"\n[solve]", 11, {"part.1.name", "another part"}},
    {"negative_part_density", "[solve]", "density = -1\n[solve]", 10, {"part.0.density = -1", "kg/m^3"}},
    {"light_part", "[solve]", "density = 1e-320\n[solve]", 10, {"part.0.density", "body.cell_size"}},
    {"part_poisson", "[solve]", "poisson = 0.5\n[solve]", 10, {"part.0.poisson = 0.5", "below 0.5"}},
    {"part_young",
     "[solve]",
     "young = 1.7e308\npoisson = 0.4999999\n[solve]",
     10,
     {"part.0.young", "smaller"}},
    {"part_springs", "[solve]", "springs = 5\n[solve]", 10, {"part.0.springs is not a known key"}},
    {"part_damping",
     "[solve]",
     "damping = { ratio = 0.1, viscosity = 3 }\n[solve]",
     10,
     {"part.0.damping.viscosity = 3", "part.0.damping.ratio", "one of the two"}},
    {"part_of_half_a_material",
     "young = 1e5\npoisson = 0.3\n",
     "springs = { edge = 1, face = 1, body = 1 }\n",
     0,
     {"part.0.poisson is missing"},
     "part.0.young=5"},
};

class MalformedScene : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedScene, IsRefusedInOneUsefulSentence) {
  const Malformed& malformed = GetParam();
  const SceneFolder folder;
  folder.write("ragged.txt", "##\n#\n");
  folder.write("layers.txt", "##\n##\n\n##\n");
  folder.write("bad.txt", "#o\n");
  folder.write("empty.txt", "");
  folder.write("hollow.txt", "..\n");
  folder.write("parts.txt", "#A\n");
  folder.write("tenths.txt", "#5\n");
  const std::filesystem::path file =
      folder.write("scene.toml", replaced(plain_scene, malformed.from, malformed.to));
  try {
    if (malformed.override_with)
      load_scene(file, {malformed.override_with});
    else
      load_scene(file);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string place = malformed.line == 0 ? "" : ":" + std::to_string(malformed.line) + ": ";
    if (!malformed.override_with) {
      EXPECT_THAT(message, StartsWith(file.string() + place));
    }
    for (const std::string_view part : malformed.says) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 400U) << message;
  }
}

class MalformedPart : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedPart, IsRefusedInOneUsefulSentence) {
  const Malformed& malformed = GetParam();
  const SceneFolder folder;
  folder.write("shape.txt", "A#\n");
  std::string text = replaced(plain_scene, "cells = [2, 2, 2]", "voxels = \"shape.txt\"");
  text = replaced(text, "[solve]", "[[part]]\nname = \"A\"\n[solve]");
  const auto file = folder.write("scene.toml", replaced(text, malformed.from, malformed.to));
  try {
    if (malformed.override_with)
      load_scene(file, {malformed.override_with});
    else
      load_scene(file);
    FAIL() << "was accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string place =
        malformed.line == 0 ? "" : fmt::format("{}:{}: ", file.string(), malformed.line);
    EXPECT_THAT(message, StartsWith(place));
    for (const std::string_view part : malformed.says) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

const auto name_of = [](const auto& instance) { return instance.param.name; };
INSTANTIATE_TEST_SUITE_P(Bodies, MalformedScene, ::testing::ValuesIn(malformed_bodies), name_of);
INSTANTIATE_TEST_SUITE_P(Parts, MalformedPart, ::testing::ValuesIn(malformed_parts), name_of);
INSTANTIATE_TEST_SUITE_P(Materials, MalformedScene, ::testing::ValuesIn(malformed_materials), name_of);
INSTANTIATE_TEST_SUITE_P(Environments, MalformedScene, ::testing::ValuesIn(malformed_environments), name_of);
INSTANTIATE_TEST_SUITE_P(Solves, MalformedScene, ::testing::ValuesIn(malformed_solves), name_of);
INSTANTIATE_TEST_SUITE_P(Toml, MalformedScene, ::testing::ValuesIn(malformed_toml), name_of);
INSTANTIATE_TEST_SUITE_P(Overrides, MalformedScene, ::testing::ValuesIn(malformed_overrides), name_of);

std::string refusal_of(const std::filesystem::path& file) {
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

// Whatever a file contains, the result is a scene or an InputError of one line.
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
}  // namespace mss::testing
