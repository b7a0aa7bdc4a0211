// Charts.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <set>

#include "core/base/error.hpp"
#include "experiments/harness/report.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "experiments/plot/gnuplot_commands.hpp"
#include "integrators/integrator.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

/// Ten labels, of which those in the left column may be longer.
TEST(ChartScript, HasALegendInTwoColumnsWhereTheRightOneFits) {
  Chart chart{.title = "T", .subtitle = "", .x = {.label = "x"}, .y = {.label = "y"}};
  for (int i = 0; i < 10; ++i)
    chart.series.push_back({.label = std::string(22, char('a' + i)), .points = {{1, 1}, {2, 2}}});
  const auto rows = [&] {
    const std::string script = gnuplot_script(chart, "a.svg", "a.png");
    return std::stoi(script.substr(script.find("maxrows ") + 8));
  };
  EXPECT_EQ(rows(), 5);
  chart.series[2].label = std::string(49, 'c');
  EXPECT_EQ(rows(), 5);
  chart.series[9].label = std::string(49, 'j');
  EXPECT_EQ(rows(), 10);
  for (ChartSeries& series : chart.series) series.label = "short";
  EXPECT_EQ(rows(), 4);
}

TEST(ChartScript, PlacesTheNameOfALineAboveItOrBelow) {
  Chart chart{.title = "T", .subtitle = "", .x = {.label = "x"}, .y = {.label = "y"}};
  chart.series = {{.label = "a", .points = {{1, 1}, {2, 2}}}};
  chart.lines = {{ReferenceLine::Direction::horizontal, 1, "one"}};
  EXPECT_NE(gnuplot_script(chart, "a", "b").find("left offset 0, 0.55 "), std::string::npos);
  chart.lines[0].below = true;
  EXPECT_NE(gnuplot_script(chart, "a", "b").find("left offset 0, -0.55 "), std::string::npos);
}

TEST(ChartScript, WritesANoticeBelowTheSubtitle) {
  Chart chart{.title = "T", .subtitle = "S", .x = {.label = "x"}, .y = {.label = "y"}};
  chart.series = {{.label = "a", .points = {{1, 1}, {2, 2}}}};
  const std::string without = gnuplot_script(chart, "a", "b");
  chart.notice = "Measured beside other work.";
  const std::string script = gnuplot_script(chart, "a", "b");
  EXPECT_NE(script.find("Measured beside other work."), std::string::npos);
  const auto top = [](const std::string& text) {
    return std::stod(text.substr(text.find("set tmargin at screen ") + 22));
  };
  EXPECT_LT(top(script), top(without));  // it stands where the chart began
}

TEST(ChartText, EscapesEverythingGnuplotReadsAsMarkup) {
  EXPECT_EQ(gnuplot_text("time per update"), "'time per update'");
  EXPECT_EQ(gnuplot_text("k_e^2 {a} @b & c~d"), "'k\\_e\\^2 \\{a\\} \\@b \\& c\\~d'");
  EXPECT_EQ(gnuplot_text("the thesis's \\n"), "'the thesis''s \\\\n'");
  EXPECT_EQ(gnuplot_text("two\nlines"), "'two'.\"\\n\".'lines'");
  EXPECT_EQ(gnuplot_text("`date` $x"), "'`date` $x'");  // not substituted between single quotes
}

Chart small_chart() {
  Chart chart{.title = "title of k_e {x}^2 @home & it's `date`",
              .subtitle = "subtitle",
              .x = {.label = "n_x", .logarithmic = true},
              .y = {.label = "time", .logarithmic = true, .unit = "s"}};
  chart.series = {
      {.label = "first_series", .points = {{2, 1e-6, 0.9e-6, 1.2e-6}, {20, 1e-3, 0.9e-3, 1.1e-3}}},
      {.label = "second", .points = {{2, 3e-6}, {7, std::nan("")}, {20, 2e-3}}}};
  chart.lines = {{ReferenceLine::Direction::horizontal, 1e-4, "limit_1"},
                 {ReferenceLine::Direction::vertical, 5, "limit_2"}};
  chart.marks = {{{7, 1e-5}, "mark_1"}, {{7, std::nan(""), 1e-4, 2e-4}, "mark_2"}};
  return chart;
}

TEST(ChartScript, LeavesGapsWhereThereIsNoNumber) {
  const std::string script = gnuplot_script(small_chart(), "a.svg", "it's.png");
  EXPECT_NE(script.find("$series1 << END\n2 3e-06\n20 0.002\nEND\n"), std::string::npos);
  EXPECT_NE(script.find("$bars0 << END\n2 1e-06 9e-07 1.2e-06\n"), std::string::npos);
  EXPECT_EQ(script.find("$bars1"), std::string::npos);
  EXPECT_EQ(script.find("nan"), std::string::npos);
  EXPECT_NE(script.find("set output 'it''s.png'"), std::string::npos);
}

TEST(MapChart, ShowsItsPanelsAndTheKindsThatAreThere) {
  MapChart chart{
      .title = "maps",
      .subtitle = "of two methods",
      .x = {.label = "dt", .logarithmic = true, .low = 0.1, .high = 10},
      .y = named_rows({"upper", "lower"}),
      .kinds = {"holds", "never seen", "blows up"},
      .panels = {{.title = "first_method", .cells = {{0.1, 1, 0.5, 1.5, 0, "73.5"}, {1, 10, 0.5, 1.5, 2}}},
                 {.title = "second", .line = {{1, 1}, {2, 2}}}}};
  EXPECT_TRUE(has_cells(chart));
  const fs::path stem = fs::temp_directory_path() / ("mss-map-test-" + std::to_string(getpid()));
  draw(chart, stem);
  const std::string svg = read_file(stem.string() + ".svg");
  for (const std::string word : {"first", "second", "upper", "lower", "holds", "blows up", "73.5"})
    EXPECT_NE(svg.find(word), std::string::npos) << word;
  EXPECT_EQ(svg.find("never seen"), std::string::npos);
  for (const std::string extension : {".svg", ".png"}) EXPECT_TRUE(fs::remove(stem.string() + extension));
  chart.panels[0].cells.clear();
  EXPECT_FALSE(has_cells(chart));
}

/// A long legend takes a second row, and says what places without a cell mean.
TEST(MapChart, SaysWhatABlankPlaceMeans) {
  MapChart chart{.title = "maps",
                 .subtitle = "",
                 .x = {.label = "x"},
                 .y = named_rows({"row"}),
                 .kinds = {"holds"},
                 .panels = {{.title = "one", .cells = {{0, 1, 0.5, 1.5, 0}}}}};
  const auto height_of = [](const std::string& script, const std::string& label) {
    const std::size_t line = script.rfind("set label", script.find(label));
    const std::size_t second = script.find("screen", script.find("screen", line) + 1);
    return std::stod(script.substr(second + 7));
  };
  const std::string without = gnuplot_script(chart, "a.svg", "a.png");
  EXPECT_EQ(without.find("not judged"), std::string::npos);
  chart.blank_label = "not judged" + std::string(100, '.');
  chart.line_label = "a crossing" + std::string(100, '.');
  const std::string with = gnuplot_script(chart, "a.svg", "a.png");
  ASSERT_NE(with.find("not judged"), std::string::npos);
  EXPECT_NE(with.find("fc 'white'"), std::string::npos);
  EXPECT_GT(height_of(with, "holds"), height_of(with, "a crossing"));
  EXPECT_EQ(height_of(with, "holds"), height_of(with, "not judged"));
}

TEST(MapChart, WritesShortNumbers) {
  EXPECT_EQ(short_number(0.25), ".25");
  EXPECT_EQ(short_number(-0.2), "-.2");
  EXPECT_EQ(short_number(10.5), "10.5");
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(100), "100");
  EXPECT_EQ(short_number(1000), "1e3");
  EXPECT_EQ(short_number(1e6), "1e6");
  EXPECT_EQ(short_number(1500), "1500");
}

TEST(ChartScript, DrawsCurvesWithoutMarkersWhereTheyAreDense) {
  Chart chart = small_chart();
  chart.marks.clear();
  chart.series = {{.label = "dense", .points = {{1, 1}, {2, 2}}, .marked = false}};
  const std::string script = gnuplot_script(chart, "a", "b");
  EXPECT_NE(script.find("with lines lc"), std::string::npos) << script;
  EXPECT_EQ(script.find(" pt "), std::string::npos) << script;
}

/// Those that charts may show together: all but what steps reduced bodies, which comes last.
int charted_integrators() {
  EXPECT_EQ(integrators().back().stepping, Stepping::reduced);
  return int(integrators().size()) - 1;
}

/// What gnuplot draws a series per integrator with, from `from` to " ps ".
std::vector<std::string> looks_of_integrators(bool joined, const std::string& from) {
  Chart chart = small_chart();
  chart.series.clear();
  for (int i = 0; i < charted_integrators(); ++i)
    chart.series.push_back({.label = "s", .points = {{1, 1}}, .style = i, .joined = joined});
  const std::string script = gnuplot_script(chart, "a", "b");
  const std::size_t begin = script.find("set output 'b'");
  std::vector<std::string> looks;
  for (std::size_t at = script.find(from, begin); at != std::string::npos; at = script.find(from, at + 1))
    looks.push_back(script.substr(at, script.find(" ps ", at) - at));
  return looks;
}

TEST(ChartScript, GivesEveryIntegratorItsOwnMarkerAndDash) {
  const std::vector<std::string> looks = looks_of_integrators(true, " dt ");
  EXPECT_EQ(int(looks.size()), charted_integrators());
  EXPECT_EQ(std::set<std::string>(looks.begin(), looks.end()).size(), looks.size());
}

/// Where there are no lines, those with one marker differ in grey too.
TEST(ChartScript, GivesEveryIntegratorItsOwnMarkerAndShade) {
  std::map<std::string, std::vector<double>> shades;
  int count = 0;
  for (const std::string& look : looks_of_integrators(false, "points lc '#")) {
    const auto channel = [&](std::size_t at) { return std::stoi(look.substr(at, 2), nullptr, 16); };
    const std::size_t colour = look.find('#') + 1;
    const double shade =
        0.2126 * channel(colour) + 0.7152 * channel(colour + 2) + 0.0722 * channel(colour + 4);
    std::vector<double>& others = shades[look.substr(look.find(" pt "))];
    for (const double other : others) EXPECT_GT(std::abs(shade - other), 30) << look;
    others.push_back(shade);
    ++count;
  }
  EXPECT_EQ(count, charted_integrators());
}

TEST(Chart, ShowsItsTextUnchanged) {
  if (gnuplot_version().empty()) GTEST_SKIP() << "gnuplot is not installed";
  const fs::path directory = fs::temp_directory_path() / ("mss-chart-test-" + std::to_string(getpid()));
  draw(small_chart(), directory / "it's a chart");
  const std::string svg = read_file(directory / "it's a chart.svg"),
                    png = read_file(directory / "it's a chart.png");
  fs::remove_all(directory);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  for (const std::string text :
       {"title of k_e {x}^2 @home &amp; it's `date`", "first_series", "n_x", "limit_1", "mark_2"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
}

TEST(Chart, NamesSeriesWithoutPointsInItsLegend) {
  if (gnuplot_version().empty()) GTEST_SKIP() << "gnuplot is not installed";
  Chart chart = small_chart();
  chart.series.push_back({.label = "all of it failed", .points = {{2, std::nan("")}}});
  chart.series.push_back({.label = "crosses for nothing", .lines = false});
  const fs::path directory = fs::path(::testing::TempDir()) / fmt::format("mss_empty_{}", getpid());
  draw(chart, directory / "empty");
  const std::string svg = read_file(directory / "empty.svg");
  EXPECT_NE(svg.find("all of it failed"), std::string::npos);
  EXPECT_NE(svg.find("crosses for nothing"), std::string::npos);
  fs::remove_all(directory);
}

}  // namespace
}  // namespace mss
