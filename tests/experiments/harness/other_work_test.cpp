// Other work on the cores, from planted readings of /proc/stat.
#include "experiments/harness/other_work.hpp"

#include <gtest/gtest.h>

#include "experiments/harness/drawings.hpp"
#include "experiments/harness/provenance.hpp"

namespace mss {
namespace {

constexpr const char* planted_ticks =
    "cpu  300 20 100 1500 60 4 6 10 200 0\n"
    "cpu0 100 0 50 800 50 0 0 0 0 0\n"
    "cpu1 200 20 50 700 10 4 6 10 200 0\n"
    "intr 621485 0 0 1\n"
    "ctxt 5\n";

TEST(OtherWork, ReadsTheCoresThatCount) {
  const auto one = core_ticks(planted_ticks, {1});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->busy, 200 + 20 + 50 + 4 + 6);  // guests' 200 are in user's
  EXPECT_EQ(one->stolen, 10);
  EXPECT_EQ(one->total, 1000);
  EXPECT_EQ(core_ticks(planted_ticks, {0, 1})->total, 2000);
  EXPECT_EQ(core_ticks(planted_ticks, {})->busy, 430);
  EXPECT_EQ(core_ticks(planted_ticks, {7})->busy, 430);  // a container may not show the core it runs on
}

TEST(OtherWork, TakesKernelsThatCountLess) {
  const auto old = core_ticks("cpu  10 0 5 85\n", {0});
  ASSERT_TRUE(old);
  EXPECT_EQ(old->busy, 15);
  EXPECT_EQ(old->total, 100);
}

TEST(OtherWork, DoesNotGuessFromAnotherText) {
  EXPECT_FALSE(core_ticks("", {}));
  EXPECT_FALSE(core_ticks("intr 1 2 3 4 5\n", {}));
  EXPECT_FALSE(core_ticks("cpu  ten 0 5 85\n", {}));
}

TEST(OtherWork, IsWhatIsBusyWithoutThisProcess) {
  const CoreTicks before{.busy = 1000, .stolen = 50, .total = 5000};
  const CoreTicks after{.busy = 1120, .stolen = 60, .total = 5200};
  EXPECT_DOUBLE_EQ(other_work(before, after, 100)->share, 0.15);
  EXPECT_DOUBLE_EQ(other_work(before, after, 100)->stolen, 0.05);
  EXPECT_DOUBLE_EQ(other_work(before, after, 0)->share, 0.65);
  EXPECT_DOUBLE_EQ(other_work(before, after, 121)->share, 0.05);  // a tick more than was counted
  EXPECT_FALSE(other_work(before, before, 0));
}

TEST(OtherWork, ReadsBackFromAProvenance) {
  EXPECT_EQ(to_json(OtherWork{.share = 0.31249, .stolen = 0.02}).dump(), R"({"share":0.312,"stolen":0.02})");
  const auto read = other_work_in({{"other_work", to_json(OtherWork{.share = 0.25, .stolen = 0.125})}});
  ASSERT_TRUE(read);
  EXPECT_EQ(read->share, 0.25);
  EXPECT_EQ(read->stolen, 0.125);
  EXPECT_FALSE(other_work_in({{"cpu", "any"}}));
  EXPECT_FALSE(other_work_in({{"other_work", to_json(std::nullopt)}}));
}

TEST(OtherWork, IsSaidAcrossChartsOfTimes) {
  const auto beside = [](double share) { return Json{{"other_work", to_json(OtherWork{.share = share})}}; };
  Chart chart;
  chart.notice = "Fits withheld.";
  EXPECT_EQ(notice_of(chart, beside(0.5)), "Fits withheld.");
  chart.times = true;
  EXPECT_EQ(notice_of(chart, beside(0.5)), "Measured beside other work (50 % of the cores). Fits withheld.");
  EXPECT_EQ(notice_of(chart, beside(0.02)), "Fits withheld.");
  EXPECT_EQ(notice_of(chart, Json::object()), "Fits withheld.");
  chart.notice = "";
  EXPECT_EQ(notice_of(chart, beside(0.5)), "Measured beside other work (50 % of the cores).");
}

/// Results of earlier versions have the load average alone, whose foot stays as it was.
TEST(OtherWork, StandsAtTheFootOfCharts) {
  Json origin = provenance();
  origin["load_average"] = {1.5, 0, 0};
  EXPECT_NE(provenance_line(origin).find(" cores, load 1.5 at the start · "), std::string::npos);
  origin["other_work"] = to_json(OtherWork{.share = 0.31});
  EXPECT_NE(provenance_line(origin).find(" cores, 31 % other work · "), std::string::npos);
  origin["other_work"] = to_json(std::nullopt);
  EXPECT_NE(provenance_line(origin).find(" cores, load 1.5 at the start · "), std::string::npos);
}

TEST(OtherWork, OfPartsIsTheMostOfThem) {
  const OtherWork little{.share = 0.1}, much{.share = 0.4};
  EXPECT_EQ(more_of(little, much)->share, 0.4);
  EXPECT_EQ(more_of(much, little)->share, 0.4);
  EXPECT_EQ(more_of(std::nullopt, little)->share, 0.1);
  EXPECT_EQ(more_of(little, std::nullopt)->share, 0.1);
  EXPECT_FALSE(more_of(std::nullopt, std::nullopt));
}

/// Whatever runs here: a share is a share, and the process that watches is none of the others.
TEST(OtherWork, WatchesTheCoresOfThisProcess) {
  const OtherWorkWatch watch;
  const auto found = other_work_now();
  if (!found) GTEST_SKIP() << "this system has no /proc/stat";
  EXPECT_GE(found->share, 0);
  EXPECT_LE(found->share, 1);
  EXPECT_LE(found->stolen, found->share);
  EXPECT_TRUE(watch.so_far());
}

}  // namespace
}  // namespace mss
