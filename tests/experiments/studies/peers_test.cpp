// `mss peers` without engines; tests/reference/peers_test.py has those.
#include "experiments/studies/peers/peers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "experiments/io/output.hpp"
#include "experiments/simulation/moving_body.hpp"

namespace mss::studies::peers {
namespace {

Family own_family(const std::string& integrator, const Setting& setting) {
  return {.name = integrator, .adapter = Adapter::own, .settings = {setting}, .options = {integrator}};
}

/// Nothing on the PATH for as long as it lives.
class EmptyPath {
 public:
  EmptyPath() : before_(std::getenv("PATH")) { setenv("PATH", "/nonexistent", 1); }
  ~EmptyPath() { setenv("PATH", before_.c_str(), 1); }
  EmptyPath(const EmptyPath&) = delete;
  EmptyPath& operator=(const EmptyPath&) = delete;

 private:
  std::string before_;
};

PeersTables measure(const std::vector<Family>& families) {
  Progress progress;
  return measure_peers({.families = families, .quick = true}, progress);
}

TEST(Peers, ThePeriodIsTheTimeBetweenTwoPassagesDownwards) {
  std::vector<double> times, values, dying;
  for (int i = 0; i < 100; ++i) {
    times.push_back(i / 60.0);
    const double phase = 2 * std::numbers::pi * times.back() / 0.37;
    values.push_back(-1 + std::cos(phase));
    dying.push_back(-1 + std::exp(-0.2 * phase) * std::cos(phase));
  }
  EXPECT_NEAR(period_of(times, values, -1), 0.37, 2e-4);
  EXPECT_NEAR(period_of(times, values, -0.7), 0.37, 2e-3);
  EXPECT_NEAR(period_of(times, dying, -1), 0.37, 2e-3);
  times.resize(20), values.resize(20);  // less than a period
  EXPECT_TRUE(std::isnan(period_of(times, values, -1)));
}

TEST(Peers, EnginesThatAreNotInstalledHaveARowThatSaysSo) {
  const EmptyPath path;
  const PeersTables measured =
      measure({own_family("verlet", {0}),
               {.name = "Jolt", .adapter = Adapter::jolt, .settings = {{1, 5}, {1, 20}}},
               {.name = "CalculiX", .adapter = Adapter::calculix, .settings = {{1}}}});
  ASSERT_EQ(measured.status, Status::ok);
  ASSERT_EQ(measured.tables.size(), 4u);
  for (const NamedTable& named : measured.tables) {
    const Table& rows = named.table;
    ASSERT_EQ(rows.size(), 3u) << named.name;  // one for Jolt, whatever it would be tried with
    EXPECT_EQ(rows.text(0, "status"), "ok") << named.name;
    EXPECT_EQ(rows.text(1, "status"), "Node.js is not installed") << named.name;
    EXPECT_EQ(rows.text(2, "status"), "Python is not installed") << named.name;
  }
}

TEST(Peers, MethodsThatConvergeComeToRestWhereTheLatticeDoes) {
  const TemporaryDirectory folder;
  const PeerScene scene = peer_scenes(true, folder.path())[0];
  Scene longer = scene.scene;
  longer.solve.duration = scene.rest_seconds;
  const peer::Exchange exchange = peer::make_exchange(longer, longer.solve.duration);
  State<double> truth = exchange.start;
  Work work;
  ASSERT_EQ(find_integrator("static").make<double>({})->advance(*exchange.system, truth, 0, work),
            Status::ok);
  for (const Family& family : {own_family("verlet", {0}), own_family("xpbd", {200, 1})}) {
    const State<double> rest = rest_here(family, family.settings[0], exchange, scene.drag);
    double worst = 0;
    for (const std::ptrdiff_t site : exchange.body->sites())
      worst = std::max(worst, (rest.x.at(site) - truth.x.at(site)).norm());
    EXPECT_LT(worst, 0.01 * std::abs(scene.displacement)) << family.name;
  }
}

TEST(Peers, ChartsShowWhatWasMeasured) {
  const PeersTables measured = measure({own_family("verlet", {0}), own_family("xpbd", {10, 1})});
  const Drawings drawings = draw_peers(measured.tables);
  std::vector<std::string> names;
  for (const NamedChart& chart : drawings.charts) names.push_back(chart.name);
  EXPECT_EQ(names, (std::vector<std::string>{"peers", "peers_period_cantilever_2", "peers_spin",
                                             "peers_volume", "peers_penetration"}));
  const Table& rows = measured.tables[0].table;
  ASSERT_EQ(drawings.charts[0].chart.series.size(), 3u);  // two families and the scale of WebAssembly's price
  EXPECT_NEAR(drawings.charts[0].chart.series[0].points.at(0).y, 100 * std::abs(rows.number(0, "tip_error")),
              1e-9);
}

}  // namespace
}  // namespace mss::studies::peers
