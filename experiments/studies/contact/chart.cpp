// What `mss validate contact` draws.
#include <fmt/format.h>

#include "experiments/studies/contact/contact.hpp"

namespace mss::studies::contact {

namespace {

/// What a body makes of a law, by what it is asked: `shown` of what was asked and seen.
ChartSeries answers(const Table& rows, const ContactConfig& config, const std::string& study, ContactLaw law,
                    const std::string& body, double (*shown)(double asked, double seen)) {
  ChartSeries series{.label = fmt::format("{}, {}", to_string(law), body)};
  const std::string method = charted_integrator(config);
  int failed = 0;
  std::string why;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != study || rows.text(r, "law") != to_string(law) ||
        rows.text(r, "body") != body || rows.text(r, "integrator") != method || rows.number(r, "angle") != 0)
      continue;
    const double asked = rows.number(r, "asked");
    if (rows.text(r, "status") == "ok") {
      series.points.push_back({asked, shown(asked, rows.number(r, "value"))});
    } else {
      ++failed;
      why = rows.text(r, "status");
    }
  }
  if (failed > 0) series.label += fmt::format(" ({} failed: {})", failed, why);
  return series;
}

void add_answers(Chart& chart, const Table& rows, const ContactConfig& config, const std::string& study,
                 const std::vector<std::string>& bodies, double (*shown)(double asked, double seen)) {
  for (const std::string& body : bodies)
    for (const ContactLaw law : config.laws)
      chart.series.push_back(answers(rows, config, study, law, body, shown));
}

Chart bounce_chart(const Table& rows, const ContactConfig& config) {
  Chart chart{.title = "Restitution: by how much bounces miss what is asked",
              .subtitle = fmt::format(
                  "a particle dropped from 1 m; seen in its last bounce above 1 cm, at most the fourth; {}",
                  charted_integrator(config)),
              .x = {.label = "restitution asked"},
              .y = {.label = "restitution seen less what is asked"}};
  add_answers(chart, rows, config, "bounce", {"particle"},
              [](double asked, double seen) { return seen - asked; });
  return chart;
}

Chart stop_chart(const Table& rows, const ContactConfig& config) {
  Chart chart{.title = "Friction: how far a push goes",
              .subtitle = fmt::format("2 m/s along an edge on level ground; by the law v^2 / (2 mu g); {}",
                                      charted_integrator(config)),
              .x = {.label = "friction asked, mu", .low = 0},
              .y = {.label = "distance / the law's", .low = 0, .high = 1.2}};
  add_answers(chart, rows, config, "stop", {"particle", "block"},
              [](double asked, double seen) { return asked / seen; });
  return chart;
}

Chart slope_chart(const Table& rows, const ContactConfig& config) {
  Chart chart{.title = "A slope of tan = 0.5: who sticks, who slides how far",
              .subtitle = fmt::format("in one second; by the law 1/2 g (sin - mu cos) t^2 up to mu = 0.5; {}",
                                      charted_integrator(config)),
              .x = {.label = "friction, mu"},
              .y = {.label = "distance [m]", .low = 0}};
  ChartSeries law{.label = "by the law"};
  const double most = config.slope_frictions.empty() ? 1 : config.slope_frictions.back();
  for (const double mu : {0.0, 0.5, std::max(0.5, most)}) law.points.push_back({mu, expected_slide(mu)});
  chart.series.push_back(std::move(law));
  add_answers(chart, rows, config, "slope", {"particle", "block"}, [](double, double seen) { return seen; });
  return chart;
}

Chart rest_chart(const Table& rest, const ContactConfig& config) {
  constexpr double nothing = 1e-35;
  Chart chart{.title = "Coming to rest",
              .subtitle = fmt::format("the thesis's cube, dropped spinning; e = 0.5, mu = 0.4; {}",
                                      charted_integrator(config)),
              .x = {.label = "time [s]"},
              .y = {.label = "kinetic energy / its peak", .logarithmic = true}};
  for (const ContactLaw law : config.laws) {
    ChartSeries series{.label = to_string(law)};
    for (std::size_t r = 0; r < rest.size(); ++r)
      if (rest.text(r, "law") == to_string(law) && rest.number(r, "kinetic_over_peak") > nothing)
        series.points.push_back({rest.number(r, "t"), rest.number(r, "kinetic_over_peak")});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<NamedChart> contact_charts(const ContactTables& tables, const ContactConfig& config) {
  if (tables.rows.size() == 0) return {};
  return {{"contact", bounce_chart(tables.rows, config)},
          {"contact_stop", stop_chart(tables.rows, config)},
          {"contact_slope", slope_chart(tables.rows, config)},
          {"contact_rest", rest_chart(tables.rest, config)}};
}

}  // namespace mss::studies::contact
