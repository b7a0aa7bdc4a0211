// Figures in texts are those of the tables that they link to.
#include "tests/experiments/harness/figures.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "experiments/harness/experiment.hpp"
#include "experiments/io/output.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

constexpr const char* table =
    "body,cells,error,seconds,status\nbeam,4,0.0763,2e-6,ok\nbeam,8,0.0221,9e-6,ok\n"
    "\"bar, long\",8,1003,4e-3,ok\nbeam,16,,,stalled\n";

std::string problem(const std::string& shown, const std::string& title) {
  const auto figures = figures_in("Seen: [" + shown + "](a/b.csv \"" + title + "\").");
  if (figures.size() != 1) return "no figure";
  return problem_with(figures.front(), table);
}

TEST(Figures, AreFoundInATable) {
  EXPECT_EQ(problem("7.6 and 2.2", "100 error where body=beam; cells<=8"), "");
  EXPECT_EQ(problem("2 us [9]", "1e6 seconds where body=beam; cells=4|8"), "");
  EXPECT_EQ(problem("2.2 to 7.6", "100 error where body=beam; status=ok"), "");
  EXPECT_EQ(problem("1,003", "error where body=bar, long"), "");
  EXPECT_EQ(problem("0.0763 in 2e-6 s", "error,seconds where cells=4"), "");
  EXPECT_EQ(problem("4.5", "seconds where body=beam; cells=8 over seconds where cells=4"), "");
  EXPECT_EQ(problem("350 percent", "100 seconds where body=beam; cells=8 off seconds where cells=4"), "");
  EXPECT_EQ(problem("50 percent", "abs 100 cells where cells=4 off cells where body=beam; cells=8"), "");
  EXPECT_EQ(problem("2000", "max of seconds where status=ok over min of seconds where status=ok"), "");
  EXPECT_EQ(problem("3", "count where body=beam"), "");
  EXPECT_EQ(problem("1", "count where status!=ok"), "");
  EXPECT_EQ(problem("0.08", "max error where body=beam; cells<16"), "");
}

TEST(Figures, ThatAreNotInTheTableAreNamed) {
  EXPECT_NE(problem("7.7", "100 error where cells=4").find("7.63"), std::string::npos);
  EXPECT_NE(problem("7.60", "100 error where cells=4"), "");             // a digit more than is true
  EXPECT_NE(problem("2.2", "100 error where body=beam; cells<=8"), "");  // one number, two values
  EXPECT_NE(problem("2.2 to 7.7", "100 error where body=beam; cells<16"), "");
  EXPECT_NE(problem("0", "error where cells=16"), "");  // a failed run has no number
  EXPECT_NE(problem("7.6", "100 eror where cells=4").find("no column 'eror'"), std::string::npos);
  EXPECT_NE(problem("7.6", "100 error where cells=5").find("no row"), std::string::npos);
  EXPECT_NE(problem("7.6", "100 error where cells").find("no condition"), std::string::npos);
  EXPECT_NE(problem("2", "count where body=beam"), "");
}

/// Checks all figures of a text, whose links are relative to `directory`; returns how many there are.
std::size_t expect_figures(const std::string& text, const fs::path& directory) {
  const auto figures = figures_in(text);
  for (const Figure& figure : figures) {
    const fs::path file = directory / figure.table;
    if (fs::exists(file))
      EXPECT_EQ(problem_with(figure, read_file(file)), "");
    else
      ADD_FAILURE() << "line " << figure.line << ": there is no " << figure.table;
  }
  return figures.size();
}

TEST(Figures, OfTheFrontPageAreThoseOfItsTables) {
  const fs::path root = MSS_SOURCE_DIR;
  EXPECT_GT(expect_figures(read_file(root / "README.md"), root), 0U);
}

TEST(Figures, OfTheThesisPageAreThoseOfItsTables) {
  const fs::path directory = fs::path(MSS_SOURCE_DIR) / "reference";
  EXPECT_GT(expect_figures(read_file(directory / "THESIS.md"), directory), 0U);
}

/// The section of results/README.md about a study.
std::string section_of(const std::string& text, const std::string& study) {
  const std::size_t from = text.find("\n## " + study + ":");
  return from == std::string::npos ? "" : text.substr(from, text.find("\n## ", from + 1) - from);
}

TEST(Figures, OfTheResultsAreThoseOfTheirTables) {
  const fs::path directory = fs::path(MSS_SOURCE_DIR) / "results";
  const std::string text = read_file(directory / "README.md");
  expect_figures(text, directory);
  for (const ExperimentInfo& info : experiments())
    EXPECT_FALSE(figures_in(section_of(text, info.name)).empty()) << "no figure is about " << info.name;
}

}  // namespace
}  // namespace mss
