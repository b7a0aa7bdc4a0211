// `mss validate contact`: the law `impulse` obeys the coefficients it is given, the thesis's does not, and
// the table shows it.
#include "experiments/studies/contact/contact.hpp"

#include <gtest/gtest.h>

#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::contact {
namespace {

/// The rows of one study, body and law, in the order of the table.
std::vector<std::size_t> find(const Table& rows, const std::string& study, const std::string& body,
                              const std::string& law) {
  std::vector<std::size_t> found;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "study") == study && rows.text(r, "body") == body && rows.text(r, "law") == law)
      found.push_back(r);
  return found;
}

double worst(const Table& rows, const std::string& study, const std::string& body, const std::string& law) {
  double error = 0;
  for (const std::size_t r : find(rows, study, body, law)) {
    EXPECT_EQ(rows.text(r, "status"), "ok") << rows.csv();
    error = std::max(error, rows.number(r, "error"));
  }
  EXPECT_FALSE(find(rows, study, body, law).empty());
  return error;
}

ContactTables measure(const ContactConfig& config) {
  Progress progress;
  Journal journal;
  return measure_contact(config, 2, journal, progress);
}

/// All rows of one law by the thesis's method.
Table rows_of(ContactLaw law) {
  ContactConfig config = contact_config({.quick = true, .integrators = {"verlet"}});
  config.robustness = {};
  config.laws = {law};
  config.degrees = {0, 45};
  config.floor = {};
  return measure(config).rows;
}

TEST(Contact, ImpulseObeysItsLaws) {
  const Table rows = rows_of(ContactLaw::impulse);
  EXPECT_LT(worst(rows, "bounce", "particle", "impulse"), 1e-3);
  for (const char* body : {"particle", "block"}) {
    EXPECT_LT(worst(rows, "stop", body, "impulse"), 0.01);
    EXPECT_LT(worst(rows, "slope", body, "impulse"), 0.01);
  }
  EXPECT_LT(worst(rows, "rest", "thesis's cube", "impulse"), 1e-10);
  EXPECT_LT(worst(rows, "depth", "thesis's cube", "impulse"), 1e-3);
  EXPECT_LT(worst(rows, "flight", "thesis's cube", "impulse"), 1e-6);
}

TEST(Contact, TheThesissLawMissesAndIsShownTo) {
  const Table rows = rows_of(ContactLaw::thesis);
  EXPECT_GT(worst(rows, "stop", "particle", "thesis"), 0.5);
  EXPECT_GT(worst(rows, "slope", "particle", "thesis"), 0.5);
  EXPECT_LT(worst(rows, "bounce", "particle", "thesis"), 0.11);
  EXPECT_GT(worst(rows, "rest", "thesis's cube", "thesis"), 1e-10);
}

TEST(Contact, PenaltyStopsPushesButSinks) {
  const Table rows = rows_of(ContactLaw::penalty);
  EXPECT_LT(worst(rows, "stop", "particle", "penalty"), 0.01);
  EXPECT_LT(worst(rows, "stop", "block", "penalty"), 0.01);
  EXPECT_GT(worst(rows, "depth", "thesis's cube", "penalty"), 1e-3);
}

TEST(Contact, DrawsFromItsFiles) {
  ContactConfig config = contact_config({.quick = true, .integrators = {"velocity_verlet", "verlet"}});
  config.robustness = {};
  config.restitutions = {0.2, 0.6};
  config.degrees = {0, 45};
  config.slope_frictions = {0.2};
  config.rest_seconds = 0.5;
  config.floor = {};
  const std::vector<NamedTable> tables = contact_files(measure(config));
  expect_same_drawings(find_experiment("contact"), tables);
  EXPECT_EQ(charted_integrator(find_table(tables, "contact")), "verlet");
  const std::vector<NamedChart> charts = draw_contact(tables).charts;
  ASSERT_EQ(charts.size(), 3U);
  EXPECT_EQ(charts[0].chart.y.names.size(), 5U);
  ASSERT_EQ(charts[0].chart.series.size(), 3U);
  // The worst of the charted method's particles and blocks, each pushed and on the slope, and of bounces.
  for (const ChartSeries& law : charts[0].chart.series) EXPECT_LE(law.points.size(), 5U);
  EXPECT_EQ(charts[1].chart.series.size(), 6U);  // three laws for a particle and for a block
  EXPECT_EQ(charts[1].chart.series[0].points.size(), config.frictions.size());
  EXPECT_EQ(charts[2].chart.series[0].points.size(), 5U);  // every tenth of fifty samples
}

TEST(Contact, KeepsFinishedRowsWhenStopped) {
  StopAfter progress(4);
  Journal journal;
  const ContactTables tables =
      measure_contact(contact_config({.quick = true, .integrators = {"verlet"}}), 1, journal, progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_GT(tables.rows.size(), 0U);
  EXPECT_LT(tables.rows.size(), 20U);
}

}  // namespace
}  // namespace mss::studies::contact
