// The program from outside: exit statuses, sentences, and what its commands print and write.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <span>

#include "core/measures/measures.hpp"
#include "core/mesh/shapes.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "integrators/integrator.hpp"
#include "reference/closed_forms.hpp"

namespace mss::cli {
namespace {

namespace fs = std::filesystem;

ProgramRun mss(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), MSS_PROGRAM);
  return run_program(arguments);
}

/// Expects exit status 2 and a single line that starts like every message and holds `part`.
void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
  const ProgramRun run = mss(arguments);
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_EQ(run.output.rfind("mss: ", 0), 0U) << run.output;
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  EXPECT_NE(run.output.find(part), std::string::npos) << run.output;
}

class Directory {
 public:
  Directory() : path_(fs::temp_directory_path() / ("mss-program-test-" + std::to_string(getpid()))) {}
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  ~Directory() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }
  std::string string() const { return path_.string(); }

 private:
  fs::path path_;
};

TEST(Program, ExplainsItself) {
  const ProgramRun help = mss({"--help"});
  EXPECT_EQ(help.exit_status, 0);
  for (const std::string word : {"timing", "view", "reproduce", "material", "list", "Exit status", "130"})
    EXPECT_NE(help.output.find(word), std::string::npos) << word;
  const ProgramRun timing = mss({"timing", "--help"});
  EXPECT_EQ(timing.exit_status, 0);
  for (const std::string word : {"--quick", "--out", "--cells", "--threads"})
    EXPECT_NE(timing.output.find(word), std::string::npos) << word;
  const ProgramRun version = mss({"--version"});
  EXPECT_EQ(version.exit_status, 0);
  EXPECT_EQ(version.output, "mss " + program_version() + "\n");
}

TEST(Program, RefusesBadUsageInOneSentence) {
  expect_refused({}, "give a command");
  expect_refused({"timng"}, "did you mean 'timing'?");
  expect_refused({"--versio"}, "did you mean '--version'?");
  expect_refused({"timing", "--quik"}, "did you mean '--quick'?");
  expect_refused({"timing", "more"}, "'more' is one argument too many");
  expect_refused({"timing", "--cells", "2:x"}, "'2:x'");
  expect_refused({"timing", "--cells", "201"}, "from 1 to 200");
  expect_refused({"timing", "--cells"}, "--cells");
  expect_refused({"timing", "--threads", "x"}, "--threads = x is not a number");
  expect_refused({"timing", "--threads", "-2"}, "--threads: -2 is out of range");
  expect_refused({"timing", "--seed", "3"}, "'--seed' is unknown");  // it draws no random numbers
  expect_refused({"stability", "--seed", "-1"}, "--seed: -1 is out of range; give a number from 0 to");
  expect_refused({"stability", "--integrators", "cvode_bdf"}, "cvode_bdf has no largest step");
  expect_refused({"timing", "--out", "/dev/null/here"}, "/dev/null/here cannot be written");
  expect_refused({"timing", "--devices", "--peers"}, "--peers excludes --devices");
  const Directory directory;
  const std::string out = directory / "none";
  for (const char* experiment : {"precision", "energy"}) {
    expect_refused({experiment, "--out", out, "--integrators", "rk5"}, "did you mean 'rk4'?");
    expect_refused({experiment, "--out", out, "--integrators", "rk4,static"},
                   "'static' finds an equilibrium");
    expect_refused({experiment, "--out", out, "--integrators", "rk4,rk4"}, "'rk4' is named twice");
  }
  expect_refused({"stiffness", "--out", out, "--cells", "0"}, "from 1 to 30");
  for (const char* experiment : {"precision", "convergence"}) {
    expect_refused({experiment, "--out", out, "--scenes", "bal_soft"}, "did you mean 'ball_soft'?");
    expect_refused({experiment, "--out", out, "--scenes", "ball_soft,ball_soft"}, "is named twice");
  }
  expect_refused({"timing", "--out", out, "--scenes", "ball_soft"}, "'--scenes' is unknown");
  for (const char* experiment : {"precision", "energy", "stiffness"})
    expect_refused({experiment, "--out", out, "--model", "corotated"}, "did you mean 'corotational'?");
  expect_refused({"timing", "--out", out, "--model", "linear"}, "'--model' is unknown");
  expect_refused({"modes", "cantilever", "--out", out, "--count", "0"}, "--count is 0");
  expect_refused({"validate", "contact", "--quik"}, "`mss validate contact --help` shows all");
  expect_refused({"validate", "--quick", "contact", "--out", out}, "--quick stands before `contact`");
  for (const char* every : {"0", "-3", "x"})
    expect_refused({"run", "cantilever", "--out", out, "--vtk", every}, "--vtk");
  EXPECT_FALSE(fs::exists(out));
  expect_refused({"list", "scene"}, "did you mean 'scenes'?");
}

TEST(Program, SaysWhatARunWouldCompute) {
  const Directory directory;
  const std::string out = directory / "none";
  const ProgramRun run = mss({"run", "cantilever", "--out", out, "--dry-run"});
  EXPECT_EQ(run.exit_status, 0) << run.output;
  for (const char* word :
       {" m, ", " kg, ", " cells, ", " particles", " steps of ", "about ", " MB of memory"})
    EXPECT_NE(run.output.find(word), std::string::npos) << word << " is not in " << run.output;
  EXPECT_FALSE(fs::exists(out));
  const ProgramRun blown =
      mss({"run", "cantilever", "--set", "solve.dt=0.1", "--set", "solve.duration=100", "--dry-run"});
  EXPECT_EQ(blown.exit_status, 3) << blown.output;
}

TEST(Program, WritesToADirectoryThatNoOtherRunHas) {
  const Directory directory;
  const std::string out = directory / "run";
  fs::create_directories(out);
  {
    const DirectoryClaim claim(out);
    expect_refused({"run", "cantilever", "--out", out}, "written to by another run");
    const ProgramRun study = mss({"precision", "--quick", "--out", out});
    EXPECT_EQ(study.exit_status, 2);
    EXPECT_NE(study.output.find("written to by another run"), std::string::npos) << study.output;
    EXPECT_TRUE(fs::is_empty(out));
  }
  const ProgramRun run = mss({"run", "cantilever", "--out", out, "--set", "solve.duration=0.01"});
  EXPECT_EQ(run.exit_status, 0) << run.output;
}

TEST(Program, SuggestsNothingThatIsUnlike) {
  const Directory directory;
  const std::string scene = directory / "scene.toml";
  write_atomically(scene, "[expect]\ntolerance = 1e-3\n");
  const std::vector<std::vector<std::string>> refused{
      {"simulate"},
      {"list", "nope"},
      {"run", "cantilever", "--hdf5"},
      {"run", "cantilever", "--set", "plane=[{contact=\"foo\"}]"},
      {"advise", "free_cube", "--of", "stress"},
      {"check", scene}};
  for (const std::vector<std::string>& arguments : refused) {
    const ProgramRun run = mss(arguments);
    EXPECT_EQ(run.exit_status, 2) << run.output;
    EXPECT_EQ(run.output.find("did you mean"), std::string::npos) << run.output;
    EXPECT_EQ(run.output.find("nearest"), std::string::npos) << run.output;
  }
  expect_refused({"list", "nope"}, "give one of integrators, linear_solvers");
}

TEST(View, RefusesWhatItCannotShow) {
  expect_refused({"view"}, "scene");
  expect_refused({"view", "cantilver"}, "did you mean 'cantilever'?");
  const ProgramRun unlike = mss({"run", "cantilever", "--set", "solve.method=rk4"});
  EXPECT_EQ(unlike.output.find("did you mean"), std::string::npos) << unlike.output;
  expect_refused({"view", "cantilever", "--set", "solve.integrator=rk5"}, "did you mean 'rk4'?");
  for (const char* size : {"10x10", "1280", "1280x800x2", "wide", "9000x800"})
    expect_refused({"view", "cantilever", "--size", size}, std::string("--size is ") + size);
  expect_refused({"view", "cantilever", "--frames", "3"}, "--frames requires --shot or --record");
  expect_refused({"view", "cantilever", "--plain"}, "--plain requires --shot or --record");
  expect_refused({"view", "cantilever", "--frames", "-3", "--shot", "a.png"}, "--frames is -3");
  expect_refused({"view", "cantilever", "--rate", "3", "--shot", "a.png"}, "--rate requires --record");
}

TEST(View, RefusesWhatItCannotRecord) {
  const auto expect_record_refused = [](const std::string& file, const std::string& why,
                                        std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"view", "cantilever", "--record", file});
    expect_refused(more, why);
  };
  expect_record_refused("a.webp", "excludes", {"--shot", "a.png"});
  expect_record_refused("a.webp", "--frames is 0", {"--frames", "0"});
  for (const char* rate : {"0", "-1", "1001", "nan"})
    expect_record_refused("a.webp", std::string("--rate is ") + rate, {"--rate", rate});
  expect_record_refused("a.webp", "--size is 8x8", {"--size", "8x8"});
  if (!MSS_HAS_WINDOW) return;  // it says that first
  for (const char* file : {"a.gif", "a", "webp"})
    expect_record_refused(file, std::string("--record is ") + file + "; give a name that ends in .webp");
  for (const char* file : {"a_%s.png", "a_%d_%d.png", "a%.png", "a_%00d.png"})
    expect_record_refused(file,
                          std::string("--record is ") + file + "; give the number of a frame one place");
  expect_record_refused("/dev/null/a.webp", "/dev/null cannot be written");
}

TEST(View, SaysWhyThereIsNoWindow) {
  const ProgramRun run = run_program({"env", "-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", MSS_PROGRAM, "view",
                                      "cantilever", "--shot", "a.png"});
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  const char* reason = MSS_HAS_WINDOW ? "no window with OpenGL 3.3 can be opened" : "install libglfw3-dev";
  EXPECT_NE(run.output.find(reason), std::string::npos) << run.output;
  EXPECT_FALSE(fs::exists("a.png"));
}

TEST(Modes, OfAScene) {
  const Directory directory;
  for (const char* model : {"springs", "linear"}) {
    const std::string out = directory / model;
    const ProgramRun run = mss({"modes", "cantilever", "--count", "4", "--out", out, "--set",
                                std::string("material.model=") + model});
    ASSERT_EQ(run.exit_status, 0) << run.output;
    const auto rows = parse_csv(read_file(fs::path(out) / "modes.csv"));
    ASSERT_EQ(rows.size(), 5U);
    const double first = std::stod(rows[1][2]);
    EXPECT_NEAR(std::stod(rows[2][2]) / first, 1, 1e-8);  // it bends alike either way
    EXPECT_NEAR(first, 1, 0.05);
    const auto summary = Json::parse(read_file(fs::path(out) / "summary.json"));
    EXPECT_LT(summary["omega_max"], summary["omega_bound"]);
    EXPECT_EQ(summary["omega_bound_crushed"], summary["omega_bound"]);
    EXPECT_GT(summary["safe_dt_undamped"]["verlet"], 0);
    EXPECT_EQ(summary["integrator"], "verlet");
    const double undamped = 2 / summary["omega_max"].get<double>(), limit = summary["limit_dt"];
    EXPECT_LT(limit, undamped);  // damping takes some of it
    EXPECT_GT(limit, 0.8 * undamped);
  }
}

/// Of a membrane, which resists nothing across it at rest.
TEST(Modes, AboutAnEquilibrium) {
  const Directory directory;
  const ProgramRun run =
      mss({"modes", "drum", "--count", "1", "--about", "equilibrium", "--out", directory / "tense"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const auto rows = parse_csv(read_file(fs::path(directory / "tense") / "modes.csv"));
  const double stretch = 1.05, nu = 1.0 / 3;  // as drum.toml has it
  const reference::Stretched membrane{.length = 0.4 * stretch,
                                      .tension = 5e6 * 0.001 * (stretch - 1) / (1 - nu) / stretch,
                                      .mass = 1100 * 0.001 / (stretch * stretch)};
  EXPECT_NEAR(std::stod(rows[1][2]) / reference::net_frequency(membrane, 32, 1, 1), 1, 1e-8);
  EXPECT_EQ(Json::parse(read_file(fs::path(directory / "tense") / "summary.json"))["about"], "equilibrium");
  const ProgramRun slack = mss({"modes", "drum", "--count", "1", "--out", directory / "slack"});
  EXPECT_EQ(slack.exit_status, 0);
  EXPECT_NE(slack.output.find("a sheet at rest has no tension"), std::string::npos) << slack.output;
  EXPECT_NE(slack.output.find("(nothing resists it)"), std::string::npos) << slack.output;
  expect_refused({"modes", "drum", "--about", "nothing", "--out", directory / "none"}, "--about");
}

TEST(Run, SaysWhatARopeIs) {
  const Directory directory;
  const ProgramRun run = mss({"run", "hanging_rope", "--dry-run"});
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_NE(run.output.find("a rope of 2 m, 0.02 m thick, 0.88 kg"), std::string::npos) << run.output;
  // Its step, "safe", means nothing to that method either: the body is what is to be changed.
  expect_refused(
      {"run", "drum", "--set", "solve.integrator=\"shape_matching\"", "--out", directory / "regions"},
      "this body is a sheet");
}

TEST(Modes, SayWhenThereAreFewerThanAskedFor) {
  const Directory directory;
  const ProgramRun run = mss(
      {"modes", "free_cube", "--count", "30", "--out", directory / "cell", "--set", "body.cells=[1,1,1]"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("these are all: 30 modes were asked for, and a body has as many as unknowns, 24"),
            std::string::npos)
      << run.output;
  EXPECT_LT(Json::parse(read_file(fs::path(directory / "cell") / "summary.json"))["omega_error"], 1e-8);
}

TEST(Modes, PrintTheStableStepWhereAGuardActs) {
  const Directory directory;
  const ProgramRun run = mss({"modes", "cantilever", "--count", "1", "--out", directory / "guarded", "--set",
                              "material.fold_guard=20"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("where the fold guard acts"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("of the safe one"), std::string::npos) << run.output;
  const auto summary = Json::parse(read_file(fs::path(directory / "guarded") / "summary.json"));
  EXPECT_GT(summary["omega_bound_crushed"], 2 * summary["omega_bound"].get<double>());
  const ProgramRun unlimited =
      mss({"modes", "cantilever", "--count", "1", "--out", directory / "unlimited", "--set",
           "material.fold_guard=20", "--set", "solve.integrator=implicit_midpoint"});
  EXPECT_EQ(unlimited.exit_status, 0) << unlimited.output;
  EXPECT_NE(unlimited.output.find("where the fold guard acts"), std::string::npos) << unlimited.output;
  EXPECT_EQ(unlimited.output.find("of the safe one"), std::string::npos) << unlimited.output;
}

TEST(Coarsen, WritesASceneThatVibratesAsTheGivenOne) {
  const Directory directory;
  const fs::path file = directory / "coarse.toml";
  const ProgramRun run = mss({"coarsen", "cantilever", "--cells", "8", "--out", file});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("32 cells in place of 256"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("bending"), std::string::npos) << run.output;
  std::vector<double> slowest;
  for (const std::string& scene : {std::string("cantilever"), file.string()}) {
    const fs::path out = directory / "modes";
    ASSERT_EQ(mss({"modes", scene, "--count", "3", "--out", out}).exit_status, 0);
    slowest.push_back(std::stod(parse_csv(read_file(out / "modes.csv"))[3][2]));
  }
  EXPECT_NEAR(slowest[1] / slowest[0], 1, 1e-3) << "the third is the slowest that twists";
}

TEST(Coarsen, RefusesWhatItCannotCoarsen) {
  expect_refused({"coarsen", "cantilever", "--cells", "7"}, "merge into 4 along its longest side");
  expect_refused({"coarsen", "cantilever", "--cells", "16"}, "give fewer");
  expect_refused({"coarsen", "cantilever", "--cells", "4", "--match", "bend"}, "did you mean 'bending'?");
  expect_refused({"coarsen", "voxel_creature", "--cells", "2"}, "do not merge");
  expect_refused({"coarsen", "fig2_1_collapse", "--cells", "1"}, "material.springs are given");
}

TEST(CheckMesh, SaysWhatCellsHaveOfIt) {
  const Directory directory;
  fs::create_directories(directory.string());
  const std::string sphere = directory / "sphere.obj", finned = directory / "finned.obj",
                    out = directory / "out";
  write_obj(sphere, icosphere(0.5, 12));
  // a fin that touches the block, between the samples of cells of .1 m
  write_obj(finned, joined(box_mesh({0, 0, 0}, {1, 1, 0.2}), box_mesh({0.49, 0, 0.2}, {0.51, 1, 0.7})));
  const ProgramRun sound = mss({"check-mesh", sphere, "--cells", "10", "--out", out});
  EXPECT_EQ(sound.exit_status, 0) << sound.output;
  for (const std::string part : {"2880 triangles", "closed       yes", "of 0.1 m", "nothing is wrong"})
    EXPECT_NE(sound.output.find(part), std::string::npos) << part << sound.output;
  const ProgramRun large = mss({"check-mesh", sphere, "--scale", "100", "--out", out});
  EXPECT_EQ(large.exit_status, 0) << large.output;
  EXPECT_NE(large.output.find("it is 100 m long: if the file is in millimetres, give --scale 0.1, and"),
            std::string::npos)
      << large.output;
  EXPECT_EQ(large.output.find("nothing is wrong"), std::string::npos) << large.output;
  const ProgramRun small = mss({"check-mesh", sphere, "--scale", "1e-4", "--out", out});
  EXPECT_NE(small.output.find("it is 0.0001 m long: if it was meant larger"), std::string::npos)
      << small.output;
  const std::string twice = directory / "twice.obj";
  write_obj(twice, joined(icosphere(0.5, 12), icosphere(0.5, 12)));
  const ProgramRun doubled = mss({"check-mesh", twice, "--out", out});
  EXPECT_NE(doubled.output.find("100 percent of the volume is inside more than once"), std::string::npos)
      << doubled.output;
  const ProgramRun lost = mss({"check-mesh", finned, "--cell-size", "0.1", "--out", out});
  EXPECT_EQ(lost.exit_status, 1) << lost.output;
  for (const std::string part :
       {"miss its part from (0.49, 0, 0.2) to (0.51, 1, 0.7) m", "about 0.019 m thick", "2 shells"})
    EXPECT_NE(lost.output.find(part), std::string::npos) << part << lost.output;
  const bool draws = !gnuplot_version().empty();
  for (const char* picture : {"sphere.svg", "sphere.png", "finned.svg", "finned.png"})
    EXPECT_EQ(fs::exists(fs::path(out) / picture), draws) << picture;
}

TEST(CheckMesh, RefusesWhatMakesNoBody) {
  const Directory directory;
  fs::create_directories(directory.string());
  const std::string open = directory / "open.obj", sphere = directory / "sphere.obj";
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 2, 3});
  mesh.triangles.resize(10);
  write_obj(open, mesh);
  write_obj(sphere, icosphere(0.5, 4));
  expect_refused({"check-mesh", open}, "4 of its edges have no partner");
  expect_refused({"check-mesh", directory / "none.obj"}, "cannot be read");
  expect_refused({"check-mesh", sphere, "--cells", "0"}, "--cells is 0");
  expect_refused({"check-mesh", sphere, "--cell-size", "-1"}, "--cell-size is -1");
  expect_refused({"check-mesh", sphere, "--cells", "9", "--cell-size", "1"}, "conflicts");
  expect_refused({"check-mesh", sphere, "--scale", "nan"}, "--scale is nan");
}

TEST(Check, RefusesWhatItCannotDo) {
  const Directory directory;
  const std::string none = directory / "none", out = directory / "out";
  expect_refused({"check", "--quick", "--against", none, "--out", out}, "no directory of baselines");
  expect_refused({"check", "--quick", "--promote", "--against", none, "--out", out}, "--why");
  EXPECT_FALSE(fs::exists(none));
  EXPECT_FALSE(fs::exists(out));
}

// What is planted is all that moved: this is also the regression test of one thread, beside check_quick's of
// two.
TEST(Check, NamesTheRowThatMovedAndFails) {
  const Directory directory;
  const fs::path baselines = fs::path(MSS_SOURCE_DIR) / "results" / "check", planted = directory / "planted";
  fs::create_directories(planted);
  for (const auto& entry : fs::directory_iterator(baselines))
    fs::copy(entry.path(), planted / entry.path().filename());
  std::string csv = read_file(planted / "timing_quick.csv");
  csv.replace(csv.find("\n7,512,"), 7, "\n7,513,");
  write_atomically(planted / "timing_quick.csv", csv);
  std::string truths = read_file(planted / "truth.csv");  // what is right does not follow a baseline
  truths.replace(truths.find("springs,5068"), 12, "springs,5069");
  write_atomically(planted / "truth.csv", truths);
  std::vector<std::string> words{"check",          "--quick", "--against",
                                 planted.string(), "--out",   directory / "out"};
  if (MSS_SANITIZED != 0) words.insert(words.end(), {"--only", "timing"});  // others have too little time
  const ProgramRun run = mss(words);
  EXPECT_EQ(run.exit_status, 1) << run.output;
  EXPECT_NE(run.output.find("timing_quick.csv: cells = 7: particles: was 513, is 512; must be the same"),
            std::string::npos)
      << run.output;
  EXPECT_NE(run.output.find("should be 5069, is 5068; the truth, by 3 n (n + 1)^2"), std::string::npos)
      << run.output;
  EXPECT_NE(run.output.find("2 deviations from"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("to compare with baselines; takes less"), std::string::npos) << run.output;
}

/// A beam clamped at one end, its free end pulled down to rest.
std::string beam(const std::string& expect) {
  return "# a beam\n[body]\ncells = [4, 2, 2]\ncell_size = 0.5\n"
         "[material]\ndensity = 100\nyoung = 1e5\npoisson = 0.3\n"
         "[[hold]]\nbox = [[0, 0, 0], [0, 1, 1]]\n"
         "[[load]]\nbox = [[2, 0, 0], [2, 1, 1]]\nforce = [0, 0, -100]\n"
         "[solve]\nintegrator = \"static\"\nduration = 1\n" +
         expect;
}

std::string tip(const std::string& value) {
  return "displacement = { box = [[2, 0, 0], [2, 1, 1]], value = " + value + ", within = 1e-3 }\n";
}

TEST(Check, ComparesScenesWithTheirExpectations) {
  const Directory directory;
  const std::string right = directory / "right.toml", wrong = directory / "wrong.toml";
  const std::string met = "[expect]\nvolume_ratio = { value = 1, within = 1e-3 }\n" + tip("[0, 0, -0.0282]");
  write_atomically(right, beam(met));
  const ProgramRun passed = mss({"check", right});
  EXPECT_EQ(passed.exit_status, 0) << passed.output;
  EXPECT_EQ(passed.output, "1 scene, 2 expectations: all met\n");

  write_atomically(wrong, beam("[expect]\n" + tip("[0, 0, -0.04]")));
  const ProgramRun failed = mss({"check", directory.string()});
  EXPECT_EQ(failed.exit_status, 1) << failed.output;
  EXPECT_NE(failed.output.find("wrong: displacement: should be [0, 0, -0.04], is ["), std::string::npos)
      << failed.output;
  EXPECT_NE(failed.output.find("2 scenes, 3 expectations: 1 deviation\n"), std::string::npos)
      << failed.output;
}

// The same beam as a mesh, pulled at its four vertices there, with the mean displacement of these.
TEST(Check, ComparesDisplacementsOfAMesh) {
  const Directory directory;
  std::string scene = beam("[expect]\n" + tip("[0, 0, -0.0282]"));
  const auto replace_all = [&](const std::string& from, const std::string& to) {
    for (std::size_t at; (at = scene.find(from)) != std::string::npos;) scene.replace(at, from.size(), to);
  };
  replace_all("cells = [4, 2, 2]", "mesh = \"beam.obj\"");
  replace_all("\nbox = [[2,", "\nsurface_box = [[2,");
  replace_all("{ box = [[2,", "{ surface_box = [[2,");
  replace_all("within = 1e-3", "within = 2e-3");  // corners take larger shares
  write_atomically(directory / "right.toml", scene);
  write_obj(directory / "beam.obj", box_mesh({0, 0, 0}, {2, 1, 1}));
  const ProgramRun passed = mss({"check", directory / "right.toml"});
  EXPECT_EQ(passed.output, "1 scene, 1 expectation: all met\n");
  replace_all("-0.0282", "-0.0382");
  write_atomically(directory / "wrong.toml", scene);
  EXPECT_EQ(mss({"check", directory / "wrong.toml"}).exit_status, 1);
}

// Results of another program in the files of `mss run` are checked in the same way.
TEST(Check, ComparesResultsWithoutSimulating) {
  const Directory directory;
  const std::string scene = directory / "scene.toml", results = directory / "results";
  write_atomically(scene, beam("[expect]\nmax_speed = { value = 0, within = 0 }\n" + tip("[0, 0, -0.0282]")));
  ASSERT_EQ(mss({"run", scene, "--out", results}).exit_status, 0);
  const auto judged = [&] { return mss({"check", scene, "--results", results}); };
  EXPECT_EQ(judged().exit_status, 0) << judged().output;
  EXPECT_EQ(judged().output.find("warning"), std::string::npos) << judged().output;
  const std::string other = directory / "other.toml";
  fs::copy_file(scene, other);
  const ProgramRun doubted = mss({"check", other, "--results", results});
  EXPECT_NE(doubted.output.find("these are results of the scene 'scene', not of 'other'"), std::string::npos)
      << doubted.output;
  expect_refused({"check", scene, "--results", results, "--set", "solve.duration=9"},
                 "and the scene at solve.duration = 9 s");
  const fs::path series = fs::path(results) / "series.csv";
  const std::string kept = read_file(series);
  write_atomically(series, kept + "x\n");
  expect_refused({"check", scene, "--results", results}, "t = 'x' is not a number");
  write_atomically(series, kept);
  const fs::path summary = fs::path(results) / "summary.json";
  write_atomically(summary, "{\"status\": \"non_finite\"}");
  EXPECT_NE(judged().output.find("status: should be ok, is non_finite"), std::string::npos)
      << judged().output;
  write_atomically(summary, "{");
  expect_refused({"check", scene, "--results", results}, "is not JSON");
}

/// The results of a beam in motion, and what is done to them.
class JudgedFiles {
 public:
  explicit JudgedFiles(const Directory& directory)
      : scene_(directory / "scene.toml"), results_(directory / "results") {
    write_atomically(scene_, expecting(""));
    EXPECT_EQ(mss({"run", scene_, "--out", results_}).exit_status, 0);
    kept_ = read_file(particles());
  }

  /// The scene with an [expect].
  static std::string expecting(const std::string& expect) {
    std::string text = beam(expect);
    const std::string at_rest = "\"static\"\nduration = 1\n";
    text.replace(text.find(at_rest), at_rest.size(), "\"velocity_verlet\"\nduration = 0.05\n");
    return text;
  }
  std::vector<std::string> command() const { return {"check", scene_, "--results", results_}; }
  fs::path particles() const { return fs::path(results_) / "particles.csv"; }
  const std::string& scene() const { return scene_; }
  fs::path series() const { return fs::path(results_) / "series.csv"; }
  /// Lines of particles.csv as it was.
  std::vector<std::string> lines() const {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin < kept_.size(); begin = kept_.find('\n', begin) + 1)
      lines.push_back(kept_.substr(begin, kept_.find('\n', begin) - begin));
    return lines;
  }
  /// A line with another cell.
  static std::string with_cell(const std::string& line, std::size_t column, const std::string& cell) {
    std::vector<std::string> cells = parse_csv(line).front();
    cells.at(column) = cell;
    return fmt::format("{}", fmt::join(cells, ","));
  }
  void write(const std::vector<std::string>& lines) const {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    write_atomically(particles(), text);
  }

 private:
  std::string scene_, results_, kept_;
};

// Totals are measured from particles: those that a run printed are met to the last digits, others count for
// nothing.
TEST(Check, MeasuresResultsItself) {
  const Directory directory;
  const JudgedFiles files(directory);
  const Table series = Table::read(read_file(files.series()), "series.csv");
  std::string expect = "[expect]\n";
  for (const MeasureColumn& column : std::span(measure_columns).subspan(1, 16)) {
    const double value = series.number(series.size() - 1, column.name);
    expect += fmt::format("{} = {{ value = {}, within = {} }}\n", column.name, value,
                          1e-9 + 1e-9 * std::abs(value));
  }
  write_atomically(files.scene(), files.expecting(expect));
  EXPECT_EQ(mss(files.command()).output, "1 scene, 16 expectations: all met\n");
  write_atomically(files.series(), fmt::format("t\n{}\n", series.number(series.size() - 1, "t")));
  EXPECT_EQ(mss(files.command()).output, "1 scene, 16 expectations: all met\n");
  std::vector<std::string> lines = files.lines();
  lines.back() = files.with_cell(lines.back(), 4, "2.001");
  files.write(lines);
  EXPECT_EQ(mss(files.command()).exit_status, 1) << mss(files.command()).output;
}

TEST(Check, NamesWhatIsWrongWithResults) {
  const Directory directory;
  const JudgedFiles files(directory);
  write_atomically(files.scene(), files.expecting("[expect]\nmax_speed = { value = 0, within = 9 }\n"));
  const std::vector<std::string> kept = files.lines();
  const auto refused = [&](const std::vector<std::string>& lines, const std::string& part) {
    files.write(lines);
    expect_refused(files.command(), part);
  };
  std::vector<std::string> lines = kept;
  lines.erase(lines.begin() + 4);
  refused(lines, "particle 3 is missing: there are 44, and the scene has 45");
  lines = kept;
  lines[4] = lines[3];
  refused(lines, "particles.csv:5: particle 2 is there twice");
  lines = kept;
  lines[4] = files.with_cell(kept[4], 0, "45");
  refused(lines, "particles.csv:5: particle 45 is not one of the scene's 45");
  lines = kept;
  lines[4] = files.with_cell(kept[4], 0, "9");
  lines[10] = files.with_cell(kept[10], 0, "3");
  refused(lines, "particles.csv:5: particle 9 rests at [1.5, 0, 0], and the scene's at [2, 0.5, 0]");
  lines = kept;
  lines[0].replace(lines[0].find("vx"), 2, "ux");
  refused(lines, "columns vx, vy, vz are missing, from which max_speed follows");
  lines[0] = kept[0];
  lines[0].replace(lines[0].find("rest_y"), 6, "rest_q");
  refused(lines, "column rest_y is missing");
  lines = kept;
  lines[4] = files.with_cell(kept[4], 10, "0");  // its mass, which is not read
  files.write(lines);
  EXPECT_EQ(mss(files.command()).exit_status, 0) << mss(files.command()).output;
  lines[4] = files.with_cell(kept[4], 4, "nan");
  files.write(lines);
  const ProgramRun lost = mss(files.command());
  EXPECT_EQ(lost.exit_status, 1);
  EXPECT_NE(lost.output.find("status: should be ok, is NaN or infinity in particle 3"), std::string::npos)
      << lost.output;
  files.write(kept);
  write_atomically(files.series(), "t\n0\n");
  expect_refused(files.command(), "series.csv ends at t = 0 s, and the scene at solve.duration = 0.05 s");
}

TEST(Check, JudgesAChangedScene) {
  const Directory directory;
  const std::string scene = directory / "scene.toml";
  write_atomically(scene, beam("[expect]\nvolume_ratio = { value = 1, within = 0.5 }\n"));
  EXPECT_EQ(mss({"check", scene}).exit_status, 0);
  const ProgramRun changed = mss({"check", scene, "--set", "expect.volume_ratio.value=9"});
  EXPECT_EQ(changed.exit_status, 1) << changed.output;
  EXPECT_NE(changed.output.find("volume_ratio: should be 9"), std::string::npos) << changed.output;
  expect_refused({"check", "cantilever", "--set", "body.cells=[4,2,2]"},
                 "expect.displacement.box contains no particle");
}

// However many settings follow one --set, what is no setting is the scene.
TEST(Program, TakesTheSceneBehindSettings) {
  const Directory directory;
  const std::string scene = directory / "scene.toml", value = "expect.volume_ratio.value=9";
  write_atomically(scene, beam("[expect]\nvolume_ratio = { value = 1, within = 0.5 }\n"));
  const std::vector<std::vector<std::string>> settings{
      {"--set", value}, {"--set", "solve.every=0.1", value}, {"--set=solve.every=0.1", value}};
  for (std::vector<std::string> arguments : settings) {
    arguments.insert(arguments.begin(), "check");
    arguments.push_back(scene);
    const ProgramRun run = mss(arguments);
    EXPECT_EQ(run.exit_status, 1) << run.output;
    EXPECT_NE(run.output.find("volume_ratio: should be 9"), std::string::npos) << run.output;
  }
  expect_refused({"check", "--set", "solve.dt", scene}, "--set solve.dt: is not a setting");
}

TEST(Check, RefusesScenesThatExpectNothing) {
  const Directory directory;
  const std::string scene = directory / "scene.toml";
  write_atomically(scene, beam(""));
  expect_refused({"check", scene}, "has no table [expect]");
  expect_refused({"check", directory.string()}, "no scene");
  expect_refused({"check", scene, "--quick"}, "--quick");
  expect_refused({"check", "--results", directory.string()}, "--results needs the scene");
  expect_refused({"check", "--set", "solve.dt=1"}, "--set changes a scene, and none is given");
  write_atomically(scene, beam("[expect]\nvolume_rato = { value = 1, within = 1 }\n"));
  expect_refused({"check", scene}, "did you mean expect.volume_ratio");
  write_atomically(scene, beam("[expect]\nvolume_ratio = { value = 1, within = -1 }\n"));
  expect_refused({"check", scene}, "expect.volume_ratio.within = -1 is not a margin");
}

TEST(Advise, RefusesImpossibleRequests) {
  for (const std::string error : {"0", "0%", "-1%", "100%", "much", "1 %"})
    expect_refused({"advise", "free_cube", "--error", error}, "--error " + error);
  for (const std::string budget : {"0ms/frame", "16", "fast", "16ms"})
    expect_refused({"advise", "free_cube", "--budget", budget}, "--budget " + budget);
  expect_refused({"advise", "free_cube", "--of", "volumes"}, "did you mean 'volume'");
  expect_refused({"advise", "free_cube", "--patience", "0"}, "--patience");
  expect_refused({"advise", "free_cube", "--of", "stability"}, "give one, as in --budget 4ms/frame");
  expect_refused({"advise", "free_cube", "--of", "stability", "--budget", "4ms/frame", "--error", "5%"},
                 "--error 5% is not required by --of stability");
  expect_refused({"advise", "free_cube", "--of", "stability", "--budget", "4ms/frame", "--grid", "2"},
                 "--grid is about errors");
  expect_refused({"advise", "free_cube", "--grid", "0"}, "--grid is 0");
}

// One reference is a row of the table, but no estimate of errors.
TEST(Advise, ReportsThatPatienceIsTooShort) {
  const Directory out;
  const ProgramRun run = mss({"advise", "free_cube", "--patience", "1e-9", "--out", out / "advice"});
  EXPECT_EQ(run.exit_status, 1) << run.output;
  EXPECT_NE(run.output.find("one reference shows nothing"), std::string::npos) << run.output;
  EXPECT_NE(read_file(fs::path(out / "advice") / "advise.csv").find("a reference"), std::string::npos);
}

TEST(Advise, ReportsThatAGridsReferencesAreUncertain) {
  const Directory out;
  const ProgramRun run =
      mss({"advise", "free_cube", "--grid", "1", "--error", "0.01%", "--out", out / "grid"});
  EXPECT_EQ(run.exit_status, 1) << run.output;
  EXPECT_NE(run.output.find("is itself uncertain by"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("a larger --grid"), std::string::npos) << run.output;
}

TEST(Advise, WritesTheSceneThatItAdvises) {
  const Directory out;
  write_atomically(out / "ell.txt", "#.\n##\n");
  write_atomically(out / "ell.toml",
                   "[body]\nvoxels = 'ell.txt'\ncell_size = 0.1\n"
                   "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n"
                   "[start]\nspin = [3, 2, 1]\n[solve]\nduration = 0.1\n");
  const std::string scene = (out / "ell.toml").string(), advice = (out / "advice").string();
  // The coarsest references decide about errors this large, after milliseconds of the minute they may take.
  const ProgramRun run = mss({"advise", scene, "--error", "50%", "--out", advice});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  for (const char* file :
       {"advise.csv", "advise_request.csv", "advise.svg", "advise.png", "meta.json", "ell_advised.toml"})
    EXPECT_TRUE(fs::exists(fs::path(advice) / file)) << file;
  const ProgramRun again = mss({"run", advice + "/ell_advised.toml", "--out", (out / "run").string()});
  EXPECT_EQ(again.exit_status, 0) << again.output;
  const ProgramRun hasty = mss({"advise", scene, "--error", "50%", "--budget", "1ns/frame", "--out", advice});
  EXPECT_EQ(hasty.exit_status, 1) << hasty.output;
  EXPECT_NE(hasty.output.find("nothing is that cheap"), std::string::npos) << hasty.output;
  EXPECT_FALSE(fs::exists(fs::path(advice) / "ell_advised.toml"));
}

// A clamped beam. Three sizes, of milliseconds each, suffice for this error.
TEST(Advise, HalvesTheCellsOfASceneAtRest) {
  const Directory out;
  const std::string scene = (out / "beam.toml"), advice = (out / "advice");
  write_atomically(scene, beam("[expect]\n" + tip("[0, 0, -0.03]")));
  const ProgramRun run = mss({"advise", scene, "--error", "40%", "--patience", "1", "--out", advice});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("beam: 40 % is met by the corrected value in cells of 0.5 m"), std::string::npos)
      << run.output;
  for (const char* file :
       {"static_advice.csv", "static_advice_request.csv", "static_advice.png", "meta.json"})
    EXPECT_TRUE(fs::exists(fs::path(advice) / file)) << file;
  EXPECT_EQ(mss({"redraw", advice}).exit_status, 0);
  expect_refused({"advise", scene, "--budget", "1ms/frame"}, "--budget is about motion");
  expect_refused({"advise", scene, "--of", "volume"}, "--of volume is about motion");
  const ProgramRun hasty = mss({"advise", scene, "--patience", "1e-9", "--out", advice});
  EXPECT_EQ(hasty.exit_status, 1) << hasty.output;
  EXPECT_NE(hasty.output.find("give more --patience"), std::string::npos) << hasty.output;
}

TEST(Model, FillsEveryExperimentsBodies) {
  const Directory directory;
  const std::string out = directory / "energy";
  const ProgramRun run =
      mss({"energy", "--quick", "--integrators", "verlet", "--model", "corotational", "--out", out});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_EQ(Json::parse(read_file(fs::path(out) / "meta.json"))["configuration"]["model"], "corotational");
  EXPECT_NE(read_file(fs::path(out) / "energy.svg").find("corotational"), std::string::npos);
  EXPECT_NE(run.output.find("bounded"), std::string::npos) << run.output;
}

TEST(Material, RefusesWhatIsNoMaterial) {
  expect_refused({"material"}, "not given");
  expect_refused({"material", "--young", "1", "--edge", "1"}, "given in two ways");
  expect_refused({"material", "--young", "1", "--poisson", "0.3"}, "--cell-size is missing");
  expect_refused({"material", "--young", "1", "--cell-size", "1"}, "--poisson is missing");
  expect_refused({"material", "--young", "1", "--poisson", "0.5", "--cell-size", "1"}, "poisson = 0.5");
  expect_refused({"material", "--young", "1", "--poisson", "nan", "--cell-size", "1"}, "poisson = nan");
  expect_refused({"material", "--young", "0", "--poisson", "0", "--cell-size", "1"}, "young = 0");
  expect_refused({"material", "--young", "inf", "--poisson", "0", "--cell-size", "1"}, "young = inf");
  expect_refused({"material", "--young", "1", "--poisson", "0", "--cell-size", "0"}, "--cell-size is 0");
  expect_refused({"material", "--young", "1", "--poisson", "0", "--cell-size", "1", "--face-share", "2"},
                 "face_share = 2");
  const std::vector<std::string> springs{"material", "--cell-size", "1",      "--volume", "0",
                                         "--face",   "0",           "--body", "0"};
  const auto with_edge = [&](const std::string& edge) {
    std::vector<std::string> all = springs;
    all.insert(all.end(), {"--edge", edge});
    return all;
  };
  expect_refused(springs, "--edge is missing");
  expect_refused(with_edge("-1"), "--edge is -1");
  expect_refused(with_edge("nan"), "--edge is nan");
  expect_refused(with_edge("0"), "all 0");
}

TEST(Material, PrintsPublishedOnes) {
  const ProgramRun all = mss({"material", "--like"}), one = mss({"material", "--like", "Dragon Skin 10"});
  EXPECT_EQ(all.exit_status, 0) << all.output;
  EXPECT_NE(all.output.find("\ncartilage "), std::string::npos) << all.output;
  EXPECT_EQ(one.exit_status, 0) << one.output;
  for (const char* text : {"263.8 kPa", "[material]", "young = 263824", "viscosity = ", "arXiv 2201.12560"})
    EXPECT_NE(one.output.find(text), std::string::npos) << text << one.output;
  expect_refused({"material", "--like", "liwer"}, "did you mean 'liver'? ");
  expect_refused({"material", "--like", "--young", "1"}, "--like stands beside other options");
}

/// The number after `name` on its line.
double value_after(const std::string& text, const std::string& name) {
  const std::size_t at = text.find(name);
  if (at == std::string::npos) return -1;
  return std::strtod(text.c_str() + at + name.size(), nullptr);
}

TEST(Material, CardOfTheThesissConstants) {
  const ProgramRun run = mss({"material", "--edge", "100", "--face", "100", "--body", "300", "--volume",
                              "0.1", "--cell-size", "0.2"});
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_NEAR(value_after(run.output, "Zener ratio"), 5, 1e-5);
  EXPECT_NEAR(value_after(run.output, "[100]"), 1416.67, 0.01);
  EXPECT_NEAR(value_after(run.output, "C11"), 3500.1, 1e-2);
  EXPECT_NEAR(value_after(run.output, "C12"), 2500.1, 1e-2);
  EXPECT_NEAR(value_after(run.output, "C44"), 2500, 1e-2);
  // 1/E[111] = (C11 + 2 C12 + C44) / (3 C44 (C11 + 2 C12)).
  EXPECT_NEAR(value_after(run.output, "[111]"), 3 * 2500 * 8500.3 / (8500.3 + 2500), 0.1);
  EXPECT_NE(run.output.find("depends on direction"), std::string::npos);
  EXPECT_NEAR(value_after(run.output, "compression along [111]"), 0.122, 1e-3);
  EXPECT_NEAR(value_after(run.output, "shear along [100] across [010]"), 0.256, 1e-3);
}

/// How far the polar plot reaches from its middle along the axis, and anywhere, in widths of a letter.
std::pair<double, double> reach(const std::string& card) {
  std::vector<std::string> lines;
  std::size_t middle = 0, centre = 0;
  for (std::size_t at = 0; at < card.size(); at = card.find('\n', at) + 1) {
    lines.push_back(card.substr(at, card.find('\n', at) - at));
    const std::size_t cross = lines.back().find('+');
    if (cross == std::string::npos || lines.back().find("--") == std::string::npos) continue;
    middle = lines.size() - 1;
    centre = cross;
  }
  double furthest = 0;
  for (std::size_t row = middle - 8; row <= middle + 8; ++row)
    for (std::size_t column = 0; column < lines[row].size(); ++column)
      if (lines[row][column] == '*')
        furthest = std::max(furthest,
                            std::hypot(double(column) - double(centre), 2 * (double(row) - double(middle))));
  return {double(lines[middle].find_last_of('*') - centre), furthest};
}

TEST(Material, PolarPlotShowsAnisotropy) {
  const ProgramRun thesis = mss({"material", "--edge", "100", "--face", "100", "--body", "300", "--volume",
                                 "0.1", "--cell-size", "0.2"});
  const ProgramRun round = mss({"material", "--young", "1e5", "--poisson", "0.3", "--cell-size", "0.2"});
  const auto [edge, furthest] = reach(thesis.output);
  EXPECT_NEAR(furthest / edge, value_after(thesis.output, "[110]") / value_after(thesis.output, "[100]"),
              0.6);
  const auto [radius, anywhere] = reach(round.output);
  EXPECT_EQ(radius, 16);
  EXPECT_NEAR(anywhere, 16, 1);
}

TEST(Material, CardOfAnIsotropicMaterial) {
  const ProgramRun run =
      mss({"material", "--young", "1e5", "--poisson", "0.3", "--cell-size", "0.2", "--face-share", "1"});
  EXPECT_EQ(run.exit_status, 0);
  const double mu_h = 1e5 / 2.6 * 0.2;
  EXPECT_NEAR(value_after(run.output, "edge k_e"), mu_h, 0.01);
  EXPECT_NEAR(value_after(run.output, "face diagonal k_f"), mu_h, 0.01);
  EXPECT_EQ(value_after(run.output, "body diagonal k_c"), 0);
  for (const std::string direction : {"[100]", "[110]", "[111]"})
    EXPECT_NEAR(value_after(run.output, direction), 1e5, 0.1) << direction;
  EXPECT_NE(run.output.find("Warnings\n  none"), std::string::npos);
}

TEST(List, NamesEverythingThereIs) {
  const ProgramRun all = mss({"list"});
  EXPECT_EQ(all.exit_status, 0);
  for (const std::string word : {"integrators\n", "scenes\n", "experiments\n", "timing"})
    EXPECT_NE(all.output.find(word), std::string::npos) << word;
  const ProgramRun methods = mss({"list", "integrators"});
  EXPECT_EQ(std::size_t(std::count(methods.output.begin(), methods.output.end(), '\n')),
            integrators().size());
  for (const IntegratorInfo& info : integrators())
    EXPECT_NE(methods.output.find(info.name), std::string::npos);
  EXPECT_NE(methods.output.find("(a variant of semi_implicit_euler: "), std::string::npos);
  const ProgramRun scenes = mss({"list", "scenes"});
  int described = 0;
  for (const auto& entry : fs::directory_iterator(MSS_SOURCE_DIR "/experiments/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    ++described;
    const std::string name = entry.path().stem().string();
    const std::size_t text =
        scenes.output.find_first_not_of(' ', scenes.output.find(name + " ") + name.size());
    ASSERT_NE(text, std::string::npos) << name;
    EXPECT_TRUE(std::isupper(static_cast<unsigned char>(scenes.output[text])))
        << name << " should open with a comment that describes it";
  }
  EXPECT_EQ(std::count(scenes.output.begin(), scenes.output.end(), '\n'), described);
}

constexpr std::size_t timed_methods = 11;  // on one thread, four of them debug builds

TEST(TimingCommand, WritesRowsMetaAndChart) {
  const Directory out;
  const ProgramRun run =
      mss({"timing", "--cells", "2,3", "--threads", "1", "--quick", "--out", out.string()});
  EXPECT_EQ(run.exit_status, 0) << run.output;
  const auto rows = parse_csv(read_file(out / "timing.csv"));
  EXPECT_EQ(rows.size(), 1 + 2 * timed_methods);
  const Json meta = Json::parse(read_file(out / "meta.json"));
  EXPECT_EQ(meta["experiment"], "timing");
  EXPECT_EQ(meta["status"], "ok");
  EXPECT_EQ(meta["configuration"]["cells"], (std::vector{2, 3}));
  EXPECT_EQ(meta["tables"]["timing.csv"]["rows"], 2 * timed_methods);
  EXPECT_EQ(meta["tables"]["timing.csv"]["units"]["seconds_per_step"], "s");
  for (const std::string key :
       {"commit", "modified", "compiler", "flags", "build_type", "dependencies", "cpu", "cores_available",
        "os", "sweep_kernels", "date", "load_average", "other_work"})
    EXPECT_TRUE(meta["provenance"].contains(key)) << key;
  const auto date = meta["provenance"]["date"].get<std::string>();
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  EXPECT_EQ(
      std::sscanf(date.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ", &year, &month, &day, &hour, &minute, &second), 6);
  EXPECT_EQ(date.size(), 20U);
  for (const std::string name : {"timing_summary.csv", "timing_raw.csv", "timing.svg", "timing.png"})
    EXPECT_GT(fs::file_size(out / name), 0U) << name;
}

TEST(Program, KeepsItsRowsWithoutGnuplot) {
  const Directory out;
  const ProgramRun run = run_program({"env", "PATH=/nowhere", MSS_PROGRAM, "energy", "--integrators",
                                      "verlet", "--quick", "--out", out.string()});
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_NE(run.output.find("gnuplot-nox"), std::string::npos) << run.output;
  EXPECT_GT(parse_csv(read_file(out / "energy.csv")).size(), 10U);
  EXPECT_FALSE(fs::exists(out / "energy.svg"));
}

/// Where EGL finds no driver; a program without devices refuses in other words.
TEST(TimingCommand, SaysThatNoDeviceIsThere) {
  const Directory out;
  const ProgramRun run = run_program({"env", "__EGL_VENDOR_LIBRARY_FILENAMES=/nowhere", MSS_PROGRAM, "timing",
                                      "--devices", "--out", out.string()});
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_NE(run.output.find("device"), std::string::npos) << run.output;
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  EXPECT_FALSE(fs::exists(out.string()));
}

/// Runs a program for so many seconds of processor time.
constexpr const char* interrupt_after = MSS_SOURCE_DIR "/tests/experiments/interrupt_after.sh";

TEST(TimingCommand, KeepsFinishedRowsOnInterrupt) {
  const Directory out;
  const ProgramRun run = run_program({interrupt_after, "2", MSS_PROGRAM, "timing", "--cells", "2:60",
                                      "--threads", "1", "--out", out.string()});
  EXPECT_EQ(run.exit_status, 130) << run.output;
  EXPECT_EQ(Json::parse(read_file(out / "meta.json"))["status"], "interrupted");
  const auto rows = parse_csv(read_file(out / "timing.csv"));
  EXPECT_EQ(rows[0][0], "method");
  EXPECT_EQ((rows.size() - 1) % timed_methods, 0U);  // whole sizes only
  EXPECT_LT(rows.size(), 1 + 59 * timed_methods);
}

TEST(Reproduce, ShowsEveryChartOnOnePage) {
  const Directory out;
  // Interrupted early: the page must be there all the same, and one experiment suffices to see that it is
  // filled.
  const ProgramRun run =
      run_program({interrupt_after, "3", MSS_PROGRAM, "reproduce", "--quick", "--out", out.string()});
  EXPECT_EQ(run.exit_status, 130) << run.output;
  const std::string page = read_file(out / "index.html");
  EXPECT_NE(page.find("<section id=\"timing\""), std::string::npos);
  EXPECT_NE(page.find("mss timing --quick --peers --out timing"), std::string::npos);
  EXPECT_NE(page.find("href=\"timing/timing.csv\""), std::string::npos);
  EXPECT_NE(page.find("href=\"timing/meta.json\""), std::string::npos);
  EXPECT_NE(page.find("Not complete: timing."), std::string::npos);
  EXPECT_EQ(page.find(out.string()), std::string::npos);
  EXPECT_NE(run.output.find(" studies, about "), std::string::npos) << run.output;
}

}  // namespace
}  // namespace mss::cli
