// `mss validate contact`: the law `impulse` does what it is asked, the thesis's does not, and the table says
// so.
#include "experiments/studies/contact/contact.hpp"

#include <gtest/gtest.h>

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

/// What one law makes of everything asked, by the thesis's method.
Table rows_of(ContactLaw law) {
  Progress progress;
  ContactConfig config = contact_config({.quick = true, .integrators = {"verlet"}});
  config.laws = {law};
  config.degrees = {0, 45};
  return measure_contact(config, progress).rows;
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

TEST(Contact, KeepsFinishedRowsWhenStopped) {
  struct Stopper final : Progress {
    bool stopped() const override { return ++asked > 3; }
    mutable int asked = 0;
  } progress;
  const ContactTables tables =
      measure_contact(contact_config({.quick = true, .integrators = {"verlet"}}), progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.rows.size(), 3U);
}

}  // namespace
}  // namespace mss::studies::contact
