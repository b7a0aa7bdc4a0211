// `mss validate contact`, elastic spheres: pressed and thrown, beside the finite sphere.
#include "experiments/studies/contact/sphere.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments/studies/contact/contact.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::contact {
namespace {

Table pressed(const PressRun& run) {
  Table rows = empty_spheres();
  add_press_run(run, rows);
  return rows;
}

TEST(Sphere, TheFiniteOneIsStifferThanHertz) {
  EXPECT_DOUBLE_EQ(finite_over_hertz(0.0005), 1.010);
  EXPECT_DOUBLE_EQ(finite_over_hertz(0.01), 1.057);
  EXPECT_DOUBLE_EQ(finite_over_hertz(0.06), 1.159);
  EXPECT_NEAR(finite_over_hertz(0.0141421356), (1.057 + 1.084) / 2, 1e-6);
}

TEST(Sphere, PressesAsTheFiniteOneWhereEnoughVerticesTouch) {
  const Table rows = pressed({PressedOn::impulse, 20});
  ASSERT_EQ(rows.size(), 5U);
  for (std::size_t r = 0; r < 4; ++r) EXPECT_EQ(rows.text(r, "status"), "not_claimed");
  EXPECT_EQ(rows.text(4, "status"), "ok") << rows.csv();
  EXPECT_NEAR(rows.number(4, "force_error"), 0, 0.03);
  EXPECT_NEAR(rows.number(4, "contact_radius_over_a"), 1, 0.05);
  EXPECT_NEAR(rows.number(4, "a_over_cell"), 2, 1e-12);
}

TEST(Sphere, CompliantContactIsSofter) {
  const auto error = [](const PressRun& run) { return pressed(run).number(1, "force_error"); };
  const double hard = error({PressedOn::impulse, 10, 1, 0.01}),
               penalty = error({PressedOn::penalty, 10, 1, 0.01}),
               soft = error({PressedOn::sphere, 10, 1, 0.01}),
               stiff = error({PressedOn::sphere, 10, 8, 0.01});
  EXPECT_GT(hard - penalty, 0.1);
  EXPECT_GT(stiff - soft, 0.1);
}

TEST(Sphere, ReboundsAfterTheFiniteOnesTime) {
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty}) {
    Table rows = empty_impacts();
    add_impact_run({law, 20, 0.0016}, rows);
    add_impact_run({law, 20, 0.016}, rows);
    EXPECT_EQ(rows.text(0, "status"), "not_claimed") << rows.csv();
    for (const std::size_t r : {0U, 1U}) {
      EXPECT_NEAR(rows.number(r, "duration_error"), 0, 0.065);
      EXPECT_NEAR(rows.number(r, "restitution"), 0.996, 0.004);
    }
    const double exponent = std::log10(rows.number(1, "duration") / rows.number(0, "duration"));
    EXPECT_NEAR(exponent, -0.2175, 0.0175);
    EXPECT_NEAR(rows.number(0, "hertz_duration"), 17.75, 0.01);
  }
}

TEST(Sphere, EveryRunIsARowAndIsDrawn) {
  ContactConfig config;
  config.laws.clear();
  config.sphere = sphere_config(true);
  std::erase_if(config.sphere.pressed, [](const PressRun& run) { return run.cells > 10; });
  for (PressRun& run : config.sphere.pressed) run.deepest = 0.005;
  std::erase_if(config.sphere.impacts, [](const ImpactRun& run) { return run.speed < 0.016; });
  Journal journal;
  Progress progress;
  const ContactTables tables = measure_contact(config, 2, journal, progress);
  EXPECT_EQ(tables.spheres.size(), config.sphere.pressed.size());
  EXPECT_EQ(tables.impacts.size(), config.sphere.impacts.size());
  const std::vector<NamedTable> files = contact_files(tables);
  expect_same_drawings(find_experiment("contact"), files);
  const std::vector<NamedChart> charts = draw_contact(files).charts;
  ASSERT_EQ(charts.size(), 2U);
  EXPECT_EQ(charts[0].chart.series.size(), 1U + 2 + 2);  // the finite one, planes, stiffnesses
  EXPECT_EQ(charts[1].chart.series.size(), 2U + 2);      // Hertz, the finite one, laws
}

}  // namespace
}  // namespace mss::studies::contact
