#include "core/base/thread_team.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <thread>

#include "core/base/processor_quota.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

class ThreadTeamOf : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sizes, ThreadTeamOf, ::testing::Values(1, 2, 3, 8));

TEST_P(ThreadTeamOf, CallsEveryTaskOnce) {
  ThreadTeam team(GetParam());
  for (const int count : {0, 1, 2, 3, 7, 1000})
    for (int round = 0; round < 300; ++round) {
      const auto calls = std::make_unique<std::atomic<int>[]>(std::size_t(count));
      team.for_each(count, [&](std::ptrdiff_t i) { ++calls[std::size_t(i)]; });
      const bool once =
          std::all_of(calls.get(), calls.get() + count, [](const auto& calls_of) { return calls_of == 1; });
      ASSERT_TRUE(once) << count << " tasks, round " << round;
    }
}

/// How far slabs are, and whether a part began before what it needs was done.
struct Ledger {
  explicit Ledger(int slabs) : done(std::size_t(slabs)) {}
  std::vector<std::atomic<long>> done;  ///< parts
  std::atomic<int> too_early{0};

  void perform(int slab, SlabPart part, long step) {
    const auto at = std::size_t(slab);
    bool ready = done[at] == 3 * step + int(part);
    if (part == SlabPart::edge && at + 1 < done.size()) ready &= done[at + 1] >= 3 * step;
    if (part == SlabPart::seam && slab > 0) ready &= done[at - 1] >= 3 * step + 2;
    if (!ready) ++too_early;
    ++done[at];
  }
};

TEST_P(ThreadTeamOf, DoesPartsInOrder) {
  ThreadTeam team(GetParam());
  for (int round = 0; round < 300; ++round) {
    const long steps = 1 + round % 16;
    Ledger ledger(team.size());
    team.run_steps(steps, [&](int slab, SlabPart part, long step) { ledger.perform(slab, part, step); });
    ASSERT_EQ(ledger.too_early, 0) << "round " << round;
    for (const auto& done : ledger.done) ASSERT_EQ(done, 3 * steps) << "round " << round;
    std::atomic<int> calls{0};
    team.for_each(5, [&](std::ptrdiff_t) { ++calls; });  // in between, through the same slabs
    ASSERT_EQ(calls, 5);
  }
}

TEST_P(ThreadTeamOf, CountsThreadsThatWorked) {
  ThreadTeam team(GetParam());
  for (int round = 0; round < 100; ++round) team.for_each(100, [](std::ptrdiff_t) {});
  EXPECT_GE(team.threads_working(), 1);
  EXPECT_LE(team.threads_working(), team.size());
}

/// Runs loops until the helper has taken a part, in which it does `work`.
template <class Work>
void let_help(ThreadTeam& team, Work&& work) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> helped{false};
  while (!helped)
    team.for_each(6, [&](std::ptrdiff_t) {
      if (std::this_thread::get_id() == caller || helped) return;
      helped = true;
      work();
    });
}

TEST(ThreadTeam, WorksAloneAfterAHelperKeptItWaiting) {
  ThreadTeam team(2);
  bool alone = false;
  for (int trial = 0; trial < 20 && !alone;
       ++trial) {  // the caller may lose its core meanwhile, and see no wait
    let_help(team, [] { std::this_thread::sleep_for(std::chrono::milliseconds(100)); });
    alone = team.works_alone();
  }
  EXPECT_TRUE(alone);
}

TEST(ThreadTeam, EndsWheneverItIsTold) {
  for (int round = 0; round < 500; ++round)
    for (const int size : {2, 3, 16}) {
      ThreadTeam team(size);
      if (round % 2 == 0) team.for_each(size, [](std::ptrdiff_t) {});
    }
}

class Quota : public ::testing::Test {
 protected:
  Quota() { fs::create_directories(root_); }
  ~Quota() override { fs::remove_all(root_); }
  void write(const fs::path& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  double of(const std::string& membership) const {
    std::istringstream text(membership);
    return processor_quota(text, root_);
  }
  fs::path root_ = fs::path(::testing::TempDir()) /
                   ("quota_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

constexpr double unlimited = std::numeric_limits<double>::infinity();

TEST_F(Quota, IsTheLeastOfAGroupAndItsAncestors) {
  EXPECT_EQ(of("0::/a/b\n"), unlimited);
  write("a/b/cpu.max", "max 100000\n");
  EXPECT_EQ(of("0::/a/b\n"), unlimited);
  write("a/cpu.max", "150000 100000\n");
  EXPECT_EQ(of("0::/a/b\n"), 1.5);
  write("a/b/cpu.max", "50000 100000\n");
  EXPECT_EQ(of("0::/a/b\n"), 0.5);
  EXPECT_EQ(of("0::/other\n"), unlimited);
}

TEST_F(Quota, OfAContainerIsAtTheRoot) {
  write("cpu.max", "200000 100000\n");
  EXPECT_EQ(of("0::/docker/of-the-host\n"), 2);
}

TEST_F(Quota, OfVersionOneIsInTwoFiles) {
  const std::string membership = "8:pids:/a\n4:cpu,cpuacct:/a\n0::/\n";
  EXPECT_EQ(of(membership), unlimited);
  write("cpu,cpuacct/a/cpu.cfs_quota_us", "-1\n");
  write("cpu,cpuacct/a/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(of(membership), unlimited);
  write("cpu,cpuacct/a/cpu.cfs_quota_us", "300000\n");
  EXPECT_EQ(of(membership), 3);
}

TEST(AvailableCores, AreAtLeastOne) { EXPECT_GE(available_cores(), 1); }

}  // namespace

}  // namespace mss
