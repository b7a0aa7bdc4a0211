// `mss redraw` from outside: the same pictures from the tables alone, or one sentence and nothing written.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <variant>

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

TEST_F(Redraw, MakesThePageOfSeveralStudiesAgain) {
  const fs::path root = directory().parent_path();
  for (const char* picture : {"energy.svg", "energy.png"}) fs::remove(directory() / picture);
  const ProgramRun run = run_program({MSS_PROGRAM, "redraw", root.string()});
  EXPECT_EQ(run.exit_status, 0) << run.output;
  EXPECT_TRUE(fs::exists(directory() / "energy.png"));
  const std::string page = read_file(root / "index.html");
  for (const std::string part :
       {"1 study with 2 charts,", "mss energy --quick --integrators explicit_euler,verlet --out energy",
        "href=\"energy/energy.csv\">Data: energy.csv", "What it printed"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find(root.string()), std::string::npos);

  const std::string rows = read_file(directory() / "energy.csv");
  Json meta = Json::parse(read_file(directory() / "meta.json"));
  meta["tables"]["energy.csv"]["rows"] = 0;
  write_atomically(directory() / "energy.csv", rows.substr(0, rows.find('\n') + 1));
  write_atomically(directory() / "meta.json", meta.dump());
  const ProgramRun empty = run_program({MSS_PROGRAM, "redraw", root.string()});
  EXPECT_EQ(empty.exit_status, 2) << empty.output;
  EXPECT_NE(read_file(root / "index.html").find("Without charts: energy."), std::string::npos);
}

/// Whether a text shows a study's picture: its own page, or one beside the results.
bool is_shown(const std::string& study, const std::string& picture) {
  const fs::path root = MSS_SOURCE_DIR;
  const std::string path = study + "/" + picture;
  for (const char* text : {"README.md", "results/README.md", "reference/THESIS.md"})
    if (read_file(root / text).find(path) != std::string::npos) return true;
  return read_file(root / "results" / study / "README.md").find("](" + picture + ")") != std::string::npos;
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
      const bool is = is_shown(info.name, name + ".png");
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

/// The same tables with the numbers of a column, floating-point ones, 1 percent larger.
std::vector<NamedTable> nudged(std::vector<NamedTable> tables, const std::string& name, std::size_t column) {
  for (NamedTable& named : tables) {
    if (named.name != name) continue;
    Table moved(named.table.columns());
    for (std::vector<Cell> row : named.table.rows()) {
      if (double* number = std::get_if<double>(&row[column])) *number *= 1.01;
      if (auto* number = std::get_if<std::int64_t>(&row[column])) *number += *number / 100 + 1;
      moved.add(row);
    }
    named.table = std::move(moved);
  }
  return tables;
}

/// The charts that change with a table.
std::set<std::string> charts_of(const ExperimentInfo& info, const std::vector<NamedTable>& tables,
                                const std::string& table) {
  const auto before = scripts(info.draw(tables));
  std::set<std::string> changed;
  for (std::size_t column = find_table(tables, table).columns().size(); column-- > 0;) try {
      const auto after = scripts(info.draw(nudged(tables, table, column)));
      for (const auto& script : before)
        if (std::find(after.begin(), after.end(), script) == after.end()) changed.insert(script.first);
    } catch (const std::exception&) {  // what it looked up is no longer there
    }
  return changed;
}

/// What the page names as a chart's table.
TEST(Results, ChartsChangeWithTheTablesNamedAsTheirs) {
  for (const ExperimentInfo& info : experiments()) {
    const fs::path directory = fs::path(MSS_SOURCE_DIR) / "results" / info.name;
    if (!fs::exists(directory)) continue;
    const std::vector<NamedTable> tables = read_results(directory).tables;
    std::map<std::string, std::set<std::string>> charts;  // by table
    const auto note = [&](const auto& all) {
      for (const auto& drawn : all)
        charts[drawn.table.empty() ? table_of(drawn.name, tables) : drawn.table].insert(drawn.name);
    };
    const Drawings drawings = info.draw(tables);
    note(drawings.charts);
    note(drawings.maps);
    for (const auto& [table, of_table] : charts) {
      ASSERT_FALSE(table.empty()) << info.name;
      const std::set<std::string> changed = charts_of(info, tables, table);
      for (const std::string& chart : of_table)
        EXPECT_TRUE(changed.contains(chart)) << chart << " is not drawn from " << table;
    }
  }
}

}  // namespace
}  // namespace mss::cli
