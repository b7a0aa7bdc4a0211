// What `mss check` compares tables with: every way in which a table can go wrong is planted, and named.
#include "experiments/harness/baseline.hpp"

#include <gtest/gtest.h>

namespace mss {
namespace {

const Baseline rules{
    .keys = {"model", "cells"}, .rules = {{"drift", 1e-6, 1e-12}, {"error", 0.1, 0}}, .table = {}};

const std::string table =
    "model,cells,drift,error,status\n"
    "thesis,2,0.5,0.01,ok\n"
    "thesis,4,0.25,0.0025,ok\n"
    "other,2,,,newton_stalled\n";

std::string planted(const std::string& from, const std::string& to) {
  std::string text = table;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

/// The only deviation of a planted table.
Deviation only(const std::string& now) {
  const std::vector<Deviation> all = compare(table, now, rules);
  EXPECT_EQ(all.size(), 1U);
  return all.empty() ? Deviation{} : all.front();
}

TEST(Baseline, PassesTheSameTable) { EXPECT_TRUE(compare(table, table, rules).empty()); }

TEST(Baseline, LetsNumbersMoveAsFarAsTheirRule) {
  EXPECT_TRUE(compare(table, planted("0.25,", "0.2500002,"), rules).empty());
  EXPECT_TRUE(compare(table, planted("0.0025", "0.0027"), rules).empty());
  const Deviation moved = only(planted("0.25,", "0.250001,"));
  EXPECT_EQ(moved.row, "model = thesis, cells = 4");
  EXPECT_EQ(moved.column, "drift");
  EXPECT_EQ(to_string(moved),
            "model = thesis, cells = 4: drift: was 0.25, is 0.250001; may move by 1e-06 of itself or 1e-12");
}

TEST(Baseline, HasRulesForRowsOfOneKeyBeforeThoseOfAll) {
  Baseline of_thesis = rules;
  of_thesis.rules.insert(of_thesis.rules.begin(), {"drift", 1e-2, 0, "thesis"});
  EXPECT_TRUE(compare(table, planted("0.25,", "0.251,"), of_thesis).empty());
  of_thesis.rules.front().only_of = "other";
  EXPECT_EQ(compare(table, planted("0.25,", "0.251,"), of_thesis).size(), 1U);
}

TEST(Baseline, TakesFailuresForAlike) {
  Baseline failing = rules;
  failing.rules.front().failure = 0.2;
  EXPECT_TRUE(compare(table, planted("0.5,", "0.7,"), failing).empty());
  EXPECT_EQ(compare(table, planted("0.5,", "0.1,"), failing).size(), 1U);
  EXPECT_EQ(compare(table, planted("0.5,", "inf,"), failing).size(), 1U);
  failing.rules.front().failure = 0.3;
  EXPECT_EQ(compare(table, planted("0.25,", "0.5,"), failing).size(), 1U);
}

TEST(Baseline, NamesARowThatVanishedOrAppeared) {
  EXPECT_EQ(only(planted("thesis,4,0.25,0.0025,ok\n", "")).row, "model = thesis, cells = 4");
  EXPECT_EQ(only(planted("thesis,4,0.25,0.0025,ok\n", "")).rule, "rows must not vanish");
  EXPECT_EQ(only(table + "thesis,8,0.1,0.001,ok\n").row, "model = thesis, cells = 8");
  EXPECT_EQ(only(table + "thesis,8,0.1,0.001,ok\n").rule, "rows must not appear");
}

TEST(Baseline, FindsRowsOutOfOrderAndTwice) {
  EXPECT_EQ(only("model,cells,drift,error,status\nthesis,4,0.25,0.0025,ok\nthesis,2,0.5,0.01,ok\nother,2,,,"
                 "newton_stalled\n")
                .rule,
            "rows must keep their order");
  EXPECT_EQ(only(table + "thesis,2,0.5,0.01,ok\n").rule, "keys must be unique");
}

TEST(Baseline, FindsColumnsRenamedReorderedOrGone) {
  for (const char* header :
       {"model,cells,error,drift,status", "model,cells,drift,error", "model,cells,drft,error,status"})
    EXPECT_EQ(only(planted("model,cells,drift,error,status", header)).rule,
              "columns must be the same, in the same order");
}

TEST(Baseline, AcceptsNoNumberThatIsNotFinite) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    const Deviation d = only(planted("0.25,", std::string(value) + ","));
    EXPECT_EQ(d.row, "model = thesis, cells = 4");
    EXPECT_EQ(d.rule, "must be a finite number");
  }
  EXPECT_EQ(only(planted("0.25,", ",")).rule, "must be a number, or missing, as it was");
  EXPECT_EQ(only(planted("other,2,,,", "other,2,0.5,,")).rule, "must be a number, or missing, as it was");
}

TEST(Baseline, FindsAStatusThatChanged) {
  const Deviation d = only(planted("0.0025,ok", "0.0025,non_finite"));
  EXPECT_EQ(d.column, "status");
  EXPECT_EQ(d.before, "ok");
  EXPECT_EQ(d.now, "non_finite");
}

TEST(Baseline, FindsARowCutShort) {
  EXPECT_EQ(only(planted("0.5,0.01,ok", "0.5,0.01")).rule, "rows must have a cell for every column");
}

Truth truth() {
  return {.table = "t",
          .row = "model = thesis, cells = 4",
          .column = "drift",
          .value = 0.25,
          .relative = 0,
          .absolute = 1e-3,
          .source = "a closed form"};
}

TEST(Truths, AreComparedApartFromBaselines) {
  EXPECT_TRUE(compare_with_truths({truth()}, "t", table, rules).empty());
  EXPECT_TRUE(compare_with_truths({truth()}, "another", table, rules).empty());
  Truth wrong = truth();
  wrong.value = 0.26;
  EXPECT_TRUE(compare_with_truths({wrong}, "another", table, rules).empty());
  const auto found = compare_with_truths({wrong}, "t", table, rules);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(
      to_string(found.front(), "should be"),
      "model = thesis, cells = 4: drift: should be 0.26, is 0.25; the truth, by a closed form; may be off "
      "by 0.001");
  wrong.absolute = 0.011;
  EXPECT_TRUE(compare_with_truths({wrong}, "t", table, rules).empty());
}

/// The drifts of two rows are 0.25 and 0.5: one is half the other.
TEST(Truths, MayBeAboutTheRatioOfTwoRows) {
  Truth ratio = truth();
  ratio.row = "model = thesis, cells = 4 over model = thesis, cells = 2";
  ratio.value = 0.5;
  EXPECT_TRUE(compare_with_truths({ratio}, "t", table, rules).empty());
  ratio.value = 0.502;
  const auto found = compare_with_truths({ratio}, "t", table, rules);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().now, "0.5");
  ratio.value = 0.5;
  ratio.row = "model = thesis, cells = 4 over model = other, cells = 5";
  EXPECT_EQ(compare_with_truths({ratio}, "t", table, rules).size(), 1U);
  ratio.row = "model = thesis, cells = 4 over model = other, cells = 2";  // has no number there
  EXPECT_EQ(compare_with_truths({ratio}, "t", table, rules).size(), 1U);
}

TEST(Truths, WithoutTheirRowOrNumberAreNotMet) {
  Truth gone = truth();
  gone.row = "model = thesis, cells = 5";
  EXPECT_EQ(compare_with_truths({gone}, "t", table, rules).size(), 1U);
  gone = truth();
  gone.column = "drfit";
  EXPECT_EQ(compare_with_truths({gone}, "t", table, rules).size(), 1U);
  EXPECT_EQ(compare_with_truths({truth()}, "t", planted("0.25,", "nan,"), rules).size(), 1U);
  EXPECT_EQ(compare_with_truths({truth()}, "t", planted("0.25,", ","), rules).size(), 1U);
}

}  // namespace
}  // namespace mss
