// `mss fit`: values that are known are found again, and what cannot be fitted is said in a sentence.
#include "experiments/fit/fit.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/error.hpp"
#include "experiments/fit/observed_run.hpp"
#include "experiments/fit/report.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "tests/experiments/stop_after.hpp"

namespace mss::fit {
namespace {

namespace fs = std::filesystem;

/// A bar that hangs by its top, is let go, and rings.
const std::string hanging_bar_to_fit = R"([body]
cells = [2, 2, 6]
cell_size = 0.05
[material]
density = 1000
young = 5e4
poisson = 0.3
[damping]
viscosity = 40
[environment]
gravity = [0, 0, -9.81]
[[hold]]
box = [[0, 0, 0.3], [0.1, 0.1, 0.3]]
[solve]
integrator = "damped_verlet"
dt = 5e-4
duration = 0.8
every = 0.005
)";
constexpr double true_young = 8e4, true_viscosity = 60;

/// A folder with that scene, bar.toml, removed at the end.
class Fitting : public ::testing::Test {
 protected:
  Fitting() {
    fs::remove_all(root_);
    write("bar.toml", hanging_bar_to_fit);
  }
  ~Fitting() override { fs::remove_all(root_); }
  Fitting(const Fitting&) = delete;
  Fitting& operator=(const Fitting&) = delete;

  fs::path write(const std::string& name, const std::string& text) const {
    write_atomically(root_ / name, text);
    return root_ / name;
  }
  fs::path operator/(const std::string& name) const { return root_ / name; }

  /// What the bar with the true values does, for observations like that one.
  std::vector<double> truth(const Observation& o, const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> all{fmt::format("material.young={}", true_young),
                                 fmt::format("damping.viscosity={}", true_viscosity)};
    all.insert(all.end(), settings.begin(), settings.end());
    const RunSpec run{.modes = o.mode > 0};
    const ObservedValues found = observe(load_scene(root_ / "bar.toml", all), run, {&o}, false);
    EXPECT_EQ(found.problem, "");
    return found.values.at(0);
  }
  /// A series of the end's displacement, every hundredth of a second.
  std::string true_series() const {
    Observation o{.kind = Kind::series, .point = Vec3(0.05, 0.05, 0), .column = "z"};
    for (int i = 0; i < 60; ++i) o.times.push_back(0.01 * i);
    const std::vector<double> z = truth(o);
    std::string text = "time,z\n";
    for (std::size_t i = 0; i < z.size(); ++i) text += fmt::format("{},{}\n", o.times[i], z[i]);
    return text;
  }

  FitResult fit_data(const std::string& data, const std::vector<std::string>& parameters) const {
    const SceneSource source = source_of(root_ / "bar.toml");
    problem_ = read_problem(source, {}, parameters);
    problem_.data = read_observations(write("data.toml", data), source, {});
    check_problem(problem_);
    Progress progress;
    return fit(problem_, progress);
  }
  ProgramRun run_fit(const std::string& data, std::vector<std::string> more) const {
    std::vector<std::string> arguments{MSS_PROGRAM,  "fit",   root_ / "bar.toml", "--data",
                                       root_ / data, "--out", root_ / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  /// Expects exit status 2 and one line that holds `part`.
  void expect_fit_refused(const std::string& data, const std::string& part,
                          const std::vector<std::string>& parameters = {"material.young"},
                          const std::string& name = "data.toml") const {
    write(name, data);
    std::vector<std::string> more{"--parameters"};
    more.insert(more.end(), parameters.begin(), parameters.end());
    const ProgramRun run = run_fit(name, more);
    EXPECT_EQ(run.exit_status, 2) << data << run.output;
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
    EXPECT_NE(run.output.find(part), std::string::npos) << run.output;
  }

  mutable FitProblem problem_;  ///< of the last fit

 private:
  fs::path root_ =
      fs::path(::testing::TempDir()) /
      ("mss_fit_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

const std::string of_the_end = "point = [0.05, 0.05, 0]\ncolumn = \"z\"\n";
const std::string at_rest =
    "[[observation]]\nkind = \"static\"\nset = [\"solve.integrator=static\"]\n" + of_the_end;

TEST_F(Fitting, FindsModulusAndViscosityOfASeriesAgain) {
  write("ring.csv", true_series());
  const FitResult found =
      fit_data("[[observation]]\nkind = \"series\"\nfile = \"ring.csv\"\npoint = [0.05, 0.05, 0]\n",
               {"material.young", "damping.viscosity"});
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.parameters[0].value / true_young, 1, 1e-4);
  EXPECT_NEAR(found.parameters[1].value / true_viscosity, 1, 1e-3);
  EXPECT_EQ(found.degrees_of_freedom, 58);
  EXPECT_LE(found.evaluations, 10);
}

TEST_F(Fitting, FindsThemFromWhereItRestsAndHowItRingsInEightEvaluations) {
  const std::string rings = of_the_end + "from = 0.02\n";
  const Observation rest{.point = Vec3(0.05, 0.05, 0), .column = "z", .from = 0.02};
  Observation frequency = rest, damping = rest;
  frequency.kind = Kind::frequency;
  damping.kind = Kind::damping;
  const FitResult found = fit_data(
      at_rest + fmt::format("value = {}\n", truth(rest, {"solve.integrator=static"})[0]) +
          "[[observation]]\nkind = \"frequency\"\n" + rings +
          fmt::format("value = {}\n", truth(frequency)[0]) + "[[observation]]\nkind = \"damping\"\n" + rings +
          fmt::format("value = {}\n", truth(damping)[0]),
      {"material.young=1e4..1e6", "damping.viscosity=1..1e3"});
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.parameters[0].value / true_young, 1, 2e-3);
  EXPECT_NEAR(found.parameters[1].value / true_viscosity, 1, 5e-3);
  EXPECT_LE(found.evaluations, 8);
  // The bar at rest was not run for its viscosity: of n evaluations of two runs, one run less than 2 n.
  EXPECT_EQ(problem_.data.runs.size(), 2U);
  EXPECT_EQ(found.runs % 2, 1);
}

// Without gravity's strain frequencies go with the root of E: four times the frequency, sixteen times the
// modulus.
TEST_F(Fitting, FindsTheModulusOfAFrequencyInOneStep) {
  Observation mode{.kind = Kind::frequency, .mode = 1};
  const double value = truth(mode)[0];
  const FitResult found =
      fit_data(fmt::format("[[observation]]\nkind = \"frequency\"\nmode = 1\nvalue = {}\n", value),
               {"material.young"});
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.parameters[0].value / true_young, 1, 1e-6);
  EXPECT_LE(found.evaluations, 3);
  EXPECT_EQ(found.degrees_of_freedom, 0);
  EXPECT_TRUE(std::isnan(found.parameters[0].low));
  EXPECT_EQ(found.parameters[0].status, "no degrees of freedom");
  EXPECT_NE(summary(problem_, found).find("nothing says how certain"), std::string::npos);
}

// A file of samples and one of their maxima and minima are the same ring-down: 5 Hz, swings that halve.
TEST_F(Fitting, MeasuredRingDownsAreOfSamplesOrOfExtrema) {
  std::string samples = "time,z\n", extrema = "time,z\n";
  for (int i = 0; i < 300; ++i) {
    const double t = 0.002 * i;
    samples += fmt::format("{},{}\n", t, 1e-3 * std::exp2(-10 * t) * std::cos(31.41592653589793 * t));
  }
  for (int i = 0; i < 6; ++i)
    extrema += fmt::format("{},{}\n", 0.1 * i, (i % 2 == 0 ? 1e-3 : -1e-3) * std::exp2(-i));
  write("samples.csv", samples);
  write("extrema.csv", extrema);
  const SceneSource source = source_of(*this / "bar.toml");
  const auto measured = [&](const std::string& kind, const std::string& file) {
    const std::string data =
        "[[observation]]\nkind = \"" + kind + "\"\n" + of_the_end + "file = " + file + "\n";
    return read_observations(write("data.toml", data), source, {}).observations.at(0).measured.at(0);
  };
  const double decrement = std::log(2), zeta = decrement / std::hypot(decrement, 3.141592653589793);
  EXPECT_NEAR(measured("frequency", "\"extrema.csv\"\nextrema = true"), 5, 1e-9);
  EXPECT_NEAR(measured("damping", "\"extrema.csv\"\nextrema = true"), zeta, 1e-9);
  EXPECT_NEAR(measured("frequency", "\"samples.csv\""), 5, 0.01);
  EXPECT_NEAR(measured("damping", "\"samples.csv\""), zeta, 0.01 * zeta);
  expect_fit_refused(
      "[[observation]]\nkind = \"frequency\"\n" + of_the_end + "file = \"samples.csv\"\nuntil = 0.1\n",
      "fewer than three turning points");
}

TEST_F(Fitting, ACsvFileAloneIsASeriesOfTheScene) {
  Observation o{.kind = Kind::series, .column = "elastic"};
  for (int i = 1; i < 20; ++i) o.times.push_back(0.005 * i);
  const std::vector<double> elastic = truth(o);
  std::string text = "time,elastic\n";
  for (std::size_t i = 0; i < elastic.size(); ++i) text += fmt::format("{},{}\n", o.times[i], elastic[i]);
  write("energy.csv", text);
  const ProgramRun run = run_fit("energy.csv", {"--parameters", "material.young", "damping.viscosity"});
  EXPECT_EQ(run.exit_status, 0) << run.output;
  const Table found = Table::read(read_file(*this / "out" / "fit.csv"), "fit.csv");
  EXPECT_NEAR(found.number(0, "fitted") / true_young, 1, 1e-3);
  EXPECT_NEAR(found.number(1, "fitted") / true_viscosity, 1, 1e-2);
}

// A twin of two cells, softer by half: what it has less is found in two or three runs of the bar.
TEST_F(Fitting, ACoarseTwinSparesRunsOfTheScene) {
  write("ring.csv", true_series());
  write("data.toml", "[[observation]]\nkind = \"series\"\nfile = \"ring.csv\"\npoint = [0.05, 0.05, 0]\n");
  const std::vector<std::string> by_twin{"--parameters", "material.young",       "damping.viscosity",
                                         "--coarse",     "body.cells=[1, 1, 3]", "body.cell_size=0.1"};
  const ProgramRun run = run_fit("data.toml", by_twin);
  EXPECT_EQ(run.exit_status, 0) << run.output;
  const Table found = Table::read(read_file(*this / "out" / "fit.csv"), "fit.csv");
  EXPECT_NEAR(found.number(0, "fitted") / true_young, 1, 1e-3);
  EXPECT_NEAR(found.number(1, "fitted") / true_viscosity, 1, 0.01);
  const Json meta = Json::parse(read_file(*this / "out" / "meta.json"));
  EXPECT_LE(meta["runs"].get<int>(), 6);
  EXPECT_GT(meta["coarse_runs"].get<int>(), meta["runs"].get<int>());
  EXPECT_EQ(Table::read(read_file(*this / "out" / "fit_steps.csv"), "fit_steps.csv").text(0, "kind"),
            "coarse: of ring-downs: start");
  std::vector<std::string> wrong = by_twin;
  wrong[4] = "body.cels=[1, 1, 3]";
  const ProgramRun refused = run_fit("data.toml", wrong);
  EXPECT_EQ(refused.exit_status, 2);
  EXPECT_NE(refused.output.find("the coarse scene: "), std::string::npos) << refused.output;
  wrong[4] = "material.young=1e5";
  EXPECT_NE(run_fit("data.toml", wrong).output.find("the coarse scene: material.young is fitted"),
            std::string::npos);
}

TEST_F(Fitting, AnInterruptedFitHasWhatItFound) {
  fit_data(at_rest + "value = -0.01\n", {"material.young"});
  for (const int reports : {1, 10, 30}) {
    StopAfter progress(reports);
    const FitResult found = fit(problem_, progress);
    if (found.ended == Ended::converged) continue;
    EXPECT_EQ(found.ended, Ended::interrupted);
    write_fit(problem_, found, provenance(), *this / "stopped");
    EXPECT_EQ(Table::read(read_file(*this / "stopped" / "fit.csv"), "fit.csv").size(),
              found.parameters.size());
  }
  StopAfter at_once(1);
  EXPECT_EQ(fit(problem_, at_once).ended, Ended::interrupted);
}

// Numbers that are not positive are fitted as they are.
TEST_F(Fitting, FindsGravityOfTheForceOfTheHold) {
  const double mass = 1000 * 0.1 * 0.1 * 0.3;
  const FitResult found = fit_data(
      fmt::format(
          "[[observation]]\nkind = \"static\"\nset = [\"solve.integrator=static\"]\ncolumn = \"hold_0_z\"\n"
          "value = {}\n",
          mass * 11),
      {"environment.gravity.2=-20..0"});
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.parameters[0].value, -11, 1e-4);
  EXPECT_LE(found.evaluations, 5);
}

TEST_F(Fitting, IntervalsAreStudents) {
  // Two drops, a percent above and below the truth's: in logarithms of E the mean, s sqrt(1/2) t(95 %, 1).
  const double drop = truth({.point = Vec3(0.05, 0.05, 0), .column = "z"}, {"solve.integrator=static"})[0];
  const FitResult found = fit_data(at_rest + fmt::format("value = {}\nuncertainty = 1e-3\n", 1.01 * drop) +
                                       at_rest + fmt::format("value = {}\nuncertainty = 1e-3\n", 0.99 * drop),
                                   {"material.young"});
  EXPECT_EQ(problem_.data.runs.size(), 1U);
  EXPECT_NEAR(found.parameters[0].value / true_young, 1, 1e-3);
  const double half_width = std::log(found.parameters[0].high / found.parameters[0].value);
  EXPECT_NEAR(half_width, 12.706 * 0.01 * std::sqrt(2.0) / std::sqrt(2.0), 0.02 * half_width);
}

TEST_F(Fitting, StopsAtABoundAndSaysSo) {
  const double drop = truth({.point = Vec3(0.05, 0.05, 0), .column = "z"}, {"solve.integrator=static"})[0];
  const FitResult found = fit_data(at_rest + fmt::format("value = {}\n", drop), {"material.young=1e4..7e4"});
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_DOUBLE_EQ(found.parameters[0].value, 7e4);
  EXPECT_TRUE(found.parameters[0].at_bound);
  ASSERT_FALSE(warnings_of(problem_, found).empty());
  EXPECT_NE(warnings_of(problem_, found)[0].find("material.young ends at its bound"), std::string::npos);
}

TEST_F(Fitting, TheProgramWritesTablesChartsAndASceneThatRuns) {
  write("ring.csv", true_series());
  write("data.toml", "[[observation]]\nkind = \"series\"\nfile = \"ring.csv\"\npoint = [0.05, 0.05, 0]\n" +
                         at_rest + "value = -0.0055\n");
  const ProgramRun run = run_fit("data.toml", {"--parameters", "material.young", "damping.viscosity"});
  EXPECT_EQ(run.exit_status, 0) << run.output;
  for (const char* file : {"fit.csv", "fit_data.csv", "fit_correlation.csv", "fit_steps.csv", "meta.json",
                           "fit.svg", "fit.png", "fit_series_1.svg", "bar_fitted.toml"})
    EXPECT_TRUE(fs::exists(*this / "out" / file)) << file;
  const Table parameters = Table::read(read_file(*this / "out" / "fit.csv"), "fit.csv");
  EXPECT_EQ(parameters.text(1, "parameter"), "damping.viscosity");
  EXPECT_LT(parameters.number(0, "low"), parameters.number(0, "fitted"));
  EXPECT_GT(parameters.number(0, "high"), parameters.number(0, "fitted"));
  EXPECT_EQ(Table::read(read_file(*this / "out" / "fit_data.csv"), "fit_data.csv").size(), 61U);
  const fs::path fitted = *this / "out" / "bar_fitted.toml";
  EXPECT_DOUBLE_EQ(load_scene(fitted).body.elastic->young, parameters.number(0, "fitted"));
  EXPECT_EQ(run_program({MSS_PROGRAM, "run", fitted, "--out", *this / "run"}).exit_status, 0);
  EXPECT_EQ(run_program({MSS_PROGRAM, "redraw", *this / "out"}).exit_status, 0);
}

// The mode asks for a modulus with which the given step is unstable, and nothing else has a say.
TEST_F(Fitting, ARunThatDivergesHasANameAndEndsTheFit) {
  write("data.toml", R"([[observation]]
kind = "frequency"
mode = 1
value = 100
[[observation]]
kind = "static"
column = "volume_ratio"
value = 1
uncertainty = 1e6
)");
  const ProgramRun run = run_fit("data.toml", {"--parameters", "material.young", "--set", "solve.dt=2e-3"});
  EXPECT_EQ(run.exit_status, 1) << run.output;
  EXPECT_NE(run.output.find("not converged"), std::string::npos) << run.output;
  EXPECT_NE(read_file(*this / "out" / "fit_steps.csv").find("non_finite at t = "), std::string::npos);
}

TEST_F(Fitting, NamesWhatDataDoNotDetermine) {
  expect_fit_refused(at_rest + "value = -0.01\n" + at_rest + "value = -0.01\n",
                     "do not determine damping.viscosity: nothing", {"material.young", "damping.viscosity"});
  expect_fit_refused(at_rest + "value = -0.01\n" + at_rest + "value = -0.01\n",
                     "do not determine material.density, material.young",
                     {"material.density", "material.young"});
}

TEST_F(Fitting, BadDataEndInOneSentence) {
  const std::string series = "[[observation]]\nkind = \"series\"\nfile = \"a.csv\"\n";
  expect_fit_refused("", "no [[observation]]");
  expect_fit_refused("", "a.csv: the file is empty", {"material.young"}, "a.csv");
  expect_fit_refused("time,total\n", "a.csv has no rows", {"material.young"}, "a.csv");
  expect_fit_refused("time,total\n0,1\n0.1,nan\n", "a.csv:3: total = 'nan' is not a finite number",
                     {"material.young"}, "a.csv");
  expect_fit_refused("time,total\n0,1\n0.1\n", "a.csv:3: 1 cells for 2 columns", {"material.young"}, "a.csv");
  expect_fit_refused("time,total\n0.1,1\n0,1.5\n", "is not later than the row before", {"material.young"},
                     "a.csv");
  expect_fit_refused("time,totle\n0,1\n0.1,2\n", "column 'totle' is unknown; did you mean 'total'?",
                     {"material.young"}, "a.csv");
  expect_fit_refused("time,total,total\n0,1,1\n0.1,2,2\n", "column 'total' is there twice",
                     {"material.young"}, "a.csv");
  expect_fit_refused(
      "[[observation]]\nkind = \"damping\"\n" + of_the_end + "from = 0.5\nuntil = 0.1\nvalue = 0.05\n",
      "is not after from");
  expect_fit_refused("time,z\n0,1\n0.1,2\n", "a displacement needs point", {"material.young"}, "a.csv");
  expect_fit_refused("time,total\n0,1\n120,2\n", "after the end of bar", {"material.young"}, "a.csv");
  expect_fit_refused(at_rest + "value = -9.8\n",
                     "is impossible for bar, which is held and 0.3 m long; give metres");
  expect_fit_refused(
      "[[observation]]\nkind = \"static\"\npoint = [50, 50, 0]\ncolumn = \"z\"\nvalue = -0.01\n",
      "from the nearest point of bar");
  expect_fit_refused(at_rest + "value = nan\n", "value = nan is not a value");
  expect_fit_refused(at_rest + "valu = 1\n", "did you mean observation.value?");
  expect_fit_refused(at_rest + "value = 0\n", "uncertainty is missing");
  expect_fit_refused(at_rest + "value = -0.01\n", "1 measured number cannot determine 2 parameters",
                     {"material.young", "material.density"});
  expect_fit_refused(at_rest + "value = 0.01\n", "of the other sign");
  expect_fit_refused("[[observation]]\nkind = \"damping\"\n" + of_the_end + "value = 5\n",
                     "0.05 for 5 percent");
  expect_fit_refused("[[observation]]\nkind = \"damping\"\nset = [\"solve.integrator=static\"]\n" +
                         of_the_end + "value = 0.05\n",
                     "needs a motion");
  expect_fit_refused(at_rest + "value = -0.01\nmode = 1\n", "it is for kind = \"frequency\"");
  expect_fit_refused("[[observation]]\nkind = \"mean\"\n", "is not a kind of observation");
  expect_fit_refused(
      "[[observation]]\nkind = \"static\"\nset = [\"solve.dt=1\"]\n" + of_the_end + "value = 1e-3\n",
      "solve.dt = 1 s is longer");
  expect_fit_refused(
      "[[observation]]\nkind = \"static\"\nset = [\"solve.dt=0.02\"]\n" + of_the_end + "value = -1e-3\n",
      "the fit cannot start");
}

TEST_F(Fitting, BadParametersEndInOneSentence) {
  const std::string data = at_rest + "value = -0.01\n";
  expect_fit_refused(data, "did you mean 'material.young'?", {"material.yung"});
  expect_fit_refused(data, "give KEY or KEY=LOW..HIGH", {"material.young=1e5"});
  expect_fit_refused(data, "'1e5x' is not a bound", {"material.young=1e5x..2e5"});
  expect_fit_refused(data, "outside the bounds", {"material.young=1e5..2e5"});
  expect_fit_refused(data, "do not ascend", {"material.young=2e5..1e5"});
  expect_fit_refused(data, "given twice", {"material.young", "material.young"});
  expect_fit_refused(data, "has no scale to vary on", {"environment.gravity.0"});
}

}  // namespace
}  // namespace mss::fit
