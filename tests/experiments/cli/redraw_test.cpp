// `mss redraw` from outside: the same pictures from the tables alone, or one sentence and nothing written.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "experiments/harness/json.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "tests/read_back.hpp"

namespace mss::cli {
namespace {

namespace fs = std::filesystem;

/// A small experiment that has been run.
class Redraw : public ::testing::Test {
 protected:
  void SetUp() override {
    if (gnuplot_version().empty()) GTEST_SKIP() << "gnuplot is not installed";
    const ProgramRun run = run_program({MSS_PROGRAM, "energy", "--quick", "--integrators",
                                        "explicit_euler,verlet", "--out", directory().string()});
    ASSERT_EQ(run.exit_status, 0) << run.output;
  }

  fs::path directory() const { return scratch_.path() / "energy"; }

  ProgramRun redraw() const { return run_program({MSS_PROGRAM, "redraw", directory().string()}); }

  /// Expects exit status 2, one sentence with `part` in it, and the picture as it was.
  void expect_refused(const std::string& part) const {
    const ProgramRun run = redraw();
    EXPECT_EQ(run.exit_status, 2) << run.output;
    EXPECT_EQ(run.output.rfind("mss: ", 0), 0U) << run.output;
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
    EXPECT_NE(run.output.find(part), std::string::npos) << run.output;
    EXPECT_EQ(read_file(directory() / "energy.svg"), "old");
  }

  TemporaryDirectory scratch_;
};

TEST_F(Redraw, DrawsTheSamePicturesAgain) {
  const std::string svg = read_file(directory() / "energy.svg"), png = read_file(directory() / "energy.png");
  // The picture shows the commit and machine of the run, whichever program draws it.
  Json meta = Json::parse(read_file(directory() / "meta.json"));
  EXPECT_NE(svg.find(meta["provenance"]["commit"].get<std::string>().substr(0, 7)), std::string::npos);
  for (const char* picture : {"energy.svg", "energy.png"}) write_atomically(directory() / picture, "old");
  write_atomically(directory() / "notes.txt", "kept");
  const ProgramRun run = redraw();
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("energy.svg"), std::string::npos) << run.output;
  EXPECT_EQ(read_file(directory() / "energy.svg"), svg);
  EXPECT_EQ(read_file(directory() / "energy.png"), png);
  EXPECT_EQ(read_file(directory() / "notes.txt"), "kept");

  meta["provenance"]["commit"] = "0123456789";
  meta["provenance"]["cpu"] = "an abacus";
  write_atomically(directory() / "meta.json", meta.dump());
  EXPECT_EQ(redraw().exit_status, 0);
  const std::string moved = read_file(directory() / "energy.svg");
  EXPECT_NE(moved.find("commit 0123456"), std::string::npos);
  EXPECT_NE(moved.find("an abacus"), std::string::npos);
}

TEST_F(Redraw, RefusesIncompleteResultsInOneSentence) {
  write_atomically(directory() / "energy.svg", "old");
  const std::string rows = read_file(directory() / "energy.csv"), meta = read_file(directory() / "meta.json");
  write_atomically(directory() / "energy.csv", rows.substr(0, rows.find('\n') + 1));
  expect_refused("energy.csv has 0 rows");
  write_atomically(directory() / "energy.csv", "x" + rows.substr(rows.find(',')));
  expect_refused("no column 'integrator'");
  write_atomically(directory() / "energy.csv", rows + "cut,short\n");
  expect_refused("2 cells for 6 columns");
  fs::remove(directory() / "energy.csv");
  expect_refused("energy.csv cannot be read");
  write_atomically(directory() / "energy.csv", rows);

  Json other = Json::parse(meta);
  other["experiment"] = "enrgy";
  write_atomically(directory() / "meta.json", other.dump());
  expect_refused("did you mean 'energy'");
  other = Json::parse(meta);
  other["provenance"].erase("cpu");
  write_atomically(directory() / "meta.json", other.dump());
  expect_refused("cpu");
  write_atomically(directory() / "meta.json", meta.substr(0, meta.size() / 2));
  expect_refused("meta.json is not the record of an experiment");
  fs::remove(directory() / "meta.json");
  expect_refused("has no meta.json");
}

/// Whether a text beside the results shows a picture.
bool is_shown(const std::string& picture) {
  for (const char* text : {"README.md", "results/README.md", "reference/THESIS.md"})
    if (read_file(fs::path(MSS_SOURCE_DIR) / text).find(picture) != std::string::npos) return true;
  return false;
}

/// Committed results can be drawn again: the charts there are, of those that their tables make, the ones that
/// a text shows.
TEST(Results, HaveTheTablesOfTheirCharts) {
  int directories = 0;
  for (const ExperimentInfo& info : experiments()) {
    const fs::path directory = fs::path(MSS_SOURCE_DIR) / "results" / info.name;
    if (!fs::exists(directory)) continue;
    ++directories;
    const auto drawn = scripts(info.draw(read_results(directory).tables));
    EXPECT_FALSE(drawn.empty()) << info.name;
    std::size_t shown = 0;
    for (const auto& [name, script] : drawn) {
      const bool is = is_shown(info.name + "/" + name + ".png");
      EXPECT_EQ(fs::exists(directory / (name + ".svg")), is) << info.name << ": " << name;
      EXPECT_EQ(fs::exists(directory / (name + ".png")), is) << info.name << ": " << name;
      shown += is ? 1 : 0;
    }
    EXPECT_GT(shown, 0U) << info.name;
    const auto pictures = std::count_if(fs::directory_iterator(directory), fs::directory_iterator(),
                                        [](const auto& entry) { return entry.path().extension() == ".svg"; });
    EXPECT_EQ(std::size_t(pictures), shown) << info.name;
  }
  EXPECT_GE(directories, 11);
}

}  // namespace
}  // namespace mss::cli
