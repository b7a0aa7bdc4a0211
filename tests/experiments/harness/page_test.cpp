// The page of `mss reproduce`, made from reports of two small studies.
#include "experiments/harness/page.hpp"

#include <gtest/gtest.h>

#include <set>

#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "tests/matches.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

TEST(Page, EncodesAndEscapes) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("M"), "TQ==");
  EXPECT_EQ(base64("Ma"), "TWE=");
  EXPECT_EQ(base64("Man"), "TWFu");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
  EXPECT_EQ(html_text("<a href=\"x\"> & y"), "&lt;a href=&quot;x&quot;&gt; &amp; y");
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

using testing::matches;

/// A study with three charts, and one that was interrupted and has none.
class PageOfTwo : public ::testing::Test {
 protected:
  void SetUp() override {
    Report whole{.name = "whole", .question = "is 1 < 2 & \"so on\"?", .command = "mss whole --quick"};
    whole.caption = "held <fixed>";
    whole.summary = "fit: a < b\n";
    whole.seconds = 406;
    whole.tables = {{"whole", 12}, {"whole_other", 3}};
    whole.outcomes = {{"ok", 6}, {"blows_up", 3}, {"stalls", 1}, {"refused", 1}, {"<odd>", 1}};
    whole.charts = {{"whole", "Time & size", "cube of <1> m", "whole"},
                    {"whole_7_cells", "Error", "bars: quartiles", "whole_other", "beside <other> work"},
                    {"whole_8", "Error", "two halves: a tie", "whole"}};
    Report part{.name = "part", .question = "how far?", .command = "mss part"};
    part.status = Status::interrupted;
    part.chart_problem = "part: there are too few rows for a chart";
    part.tables = {{"part", 0}};
    for (Report* report : {&whole, &part}) {
      report->directory = scratch_.path() / report->name;
      report->provenance = provenance();
      for (const auto& [name, rows] : report->tables) write(*report, name + ".csv", "x\n");
      write(*report, "meta.json", "{}");
    }
    for (const DrawnChart& chart : whole.charts) {
      write(whole, chart.name + ".svg", svg(chart.name));
      write(whole, chart.name + ".png", "png");
    }
    reports_ = {whole, part};
    write_page(reports_, scratch_.path() / "index.html");
    page_ = read_file(scratch_.path() / "index.html");
  }

  static void write(const Report& report, const std::string& name, const std::string& text) {
    write_atomically(report.directory / name, text);
  }

  static std::string svg(const std::string& name) {
    return "<svg viewBox=\"0 0 1200 950\"><title>" + name + "</title></svg>";
  }

  /// The figure of a chart.
  std::string figure(const std::string& chart) const {
    const std::size_t begin = page_.find("<figure id=\"chart-" + chart + "\"");
    return begin == std::string::npos ? "" : page_.substr(begin, page_.find("</figure>", begin) - begin);
  }

  TemporaryDirectory scratch_;
  std::vector<Report> reports_;
  std::string page_;
};

TEST_F(PageOfTwo, EveryChartHasItsCaptionDataAndCommand) {
  for (const Report& report : reports_)
    for (const DrawnChart& chart : report.charts) {
      const std::string shown = figure(chart.name);
      ASSERT_FALSE(shown.empty()) << chart.name;
      EXPECT_EQ(count(shown, "<h3>" + html_text(chart.title)), 1U);
      EXPECT_EQ(count(shown, "aria-label=\"Chart: " + html_text(chart.title)), 1U);
      EXPECT_EQ(count(shown, html_text(chart.subtitle)), 1U);
      EXPECT_EQ(count(shown, report.command + " --out " + report.name), 1U);
      EXPECT_EQ(count(shown, "viewBox=\"0 0 1200 950\""), 1U);
      for (const std::string& file : {chart.table + ".csv", chart.name + ".svg", chart.name + ".png"})
        EXPECT_NE(shown.find("href=\"" + report.name + "/" + file + "\""), std::string::npos) << file;
      EXPECT_EQ(count(page_, base64(svg(chart.name))), 1U) << "a chart is embedded once";
    }
}

TEST_F(PageOfTwo, OpensWithWhichMethodWhen) {
  const std::size_t at = page_.find("<h2>Which method when</h2>");
  ASSERT_NE(at, std::string::npos);
  EXPECT_LT(at, page_.find("Find a study"));
  EXPECT_LT(page_.find("Find a study"), page_.find("<section"));
  EXPECT_GE(count(page_.substr(at, page_.find("Find a study") - at), "<li><strong>"), 5U);
}

TEST(Page, LinksFindingsToStudiesThatAreThere) {
  EXPECT_EQ(html_of_markdown("**A & b**: [4](frames/f.csv#a) of `x<1`, [5](timing/t.csv#b)", {"frames"}),
            "<strong>A &amp; b</strong>: <a href=\"#frames\">4</a> of <code>x&lt;1</code>, 5");
  EXPECT_EQ(html_of_markdown("a [b] * c", {}), "a [b] * c");
}

TEST_F(PageOfTwo, NoticesStandAboveTheirSubtitles) {
  EXPECT_NE(figure("whole_7_cells").find("beside &lt;other&gt; work</strong></p>\n<p>bars: quartiles</p>"),
            std::string::npos);
  EXPECT_EQ(count(figure("whole_8"), "<strong"), 0U);
}

TEST_F(PageOfTwo, TitlesTellChartsApart) {
  for (const char* title : {"Time &amp; size</", "Error: 7 cells</", "Error: 8</"})
    EXPECT_EQ(count(page_, title), 3U) << title;  // twice in the contents, over the chart
}

TEST_F(PageOfTwo, AllLinksLeadSomewhere) {
  const std::vector<std::string> ids = matches(page_, " id=\"([^\"]*)\"");
  const std::set<std::string> distinct(ids.begin(), ids.end());
  EXPECT_EQ(ids.size(), distinct.size());
  int anchors = 0, files = 0;
  for (const std::string& target : matches(page_, "href=\"([^\"]*)\"")) {
    if (target.starts_with("data:")) continue;
    if (target.starts_with("#")) {
      EXPECT_TRUE(distinct.contains(target.substr(1))) << target;
      ++anchors;
    } else {
      EXPECT_TRUE(fs::exists(scratch_.path() / target)) << target;
      ++files;
    }
  }
  EXPECT_GE(anchors, 2 * 5 + 3);  // contents twice; cards and a thumbnail
  EXPECT_GE(files, 12 + 5);       // of the charts; all tables and records
}

TEST_F(PageOfTwo, SaysHowStudiesWent) {
  for (const char* text :
       {"2 studies with 3 charts, in 7&nbsp;min.", "Not complete: part.", "Without charts: part.",
        "12 rows: 6 ok, 3 blows_up, 1 stalls, 2 of other outcomes", "1 refused, 1 &lt;odd&gt;",
        "interrupted after 0&nbsp;s; the rows so far are kept",
        "no chart: part: there are too few rows for a chart"})
    EXPECT_NE(page_.find(text), std::string::npos) << text;
  EXPECT_EQ(page_.find("All ran to their end"), std::string::npos);
  write_page({reports_.front()}, scratch_.path() / "index.html");
  EXPECT_NE(read_file(scratch_.path() / "index.html").find("All ran to their end."), std::string::npos);
}

TEST_F(PageOfTwo, NeedsNothingElseAndShowsNoPathOfTheMachine) {
  for (const char* part : {"<script", "http:", "https:", "@import", " src=", "<odd>", "<fixed>", "<1>",
                           "1 < 2", "a < b", "{", "NaN"})
    EXPECT_EQ(page_.substr(page_.find("</style>")).find(part), std::string::npos) << part;
  EXPECT_EQ(page_.find(scratch_.path().string()), std::string::npos);
  EXPECT_EQ(page_.find(fs::current_path().string()), std::string::npos);
}

}  // namespace
}  // namespace mss
