// The numbers of `mss thesis` in one table: what reference/THESIS.md quotes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "experiments/harness/table.hpp"
#include "experiments/studies/thesis/thesis.hpp"

namespace mss::studies::thesis {

namespace {

using Filter = std::vector<std::pair<std::string, std::string>>;

Table filtered(Table rows, const Filter& filter) {
  for (const auto& [column, value] : filter) rows = rows.where(column, value);
  return rows;
}

/// The largest of a column that is a number; NaN if there is none.
double largest(const Table& rows, const std::string& column) {
  double most = no_value;
  for (std::size_t r = 0; r < rows.size(); ++r) most = std::fmax(most, rows.number(r, column));
  return most;
}
double smallest(const Table& rows, const std::string& column) {
  double least = no_value;
  for (std::size_t r = 0; r < rows.size(); ++r) least = std::fmin(least, rows.number(r, column));
  return least;
}
/// The first number of a column; NaN if there is none.
double first(const Table& rows, const std::string& column) {
  return rows.size() > 0 ? rows.number(0, column) : no_value;
}

/// Collects rows of the summary.
class Summary {
 public:
  explicit Summary(const std::vector<NamedTable>& parts) : parts_(parts) {}

  const Table& part(const std::string& name) const { return find_table(parts_, name); }
  /// `missing` says why there is no number where there is none.
  void add(const std::string& item, const std::string& quantity, double value, const std::string& beside,
           double other, const std::string& missing = "not measured") {
    rows_.add({item, quantity, value, beside, other,
               std::isfinite(value) && std::isfinite(other) ? "ok" : missing});
  }
  Table take() { return std::move(rows_); }

 private:
  const std::vector<NamedTable>& parts_;
  Table rows_{{{"item"}, {"quantity"}, {"value"}, {"beside"}, {"other"}, {"status"}}};
};

void add_topologies(Summary& summary) {
  const Table &unloading = summary.part("thesis_unloading"), &directions = summary.part("thesis_directions");
  const auto springs = [&](const char* name) { return unloading.where("springs", name); };
  for (const char* name : {"no face diagonals", "one face diagonal", "edges alone"}) {
    const std::string item = name == std::string("one face diagonal") ? "Fig. 2-2"
                             : name == std::string("edges alone")     ? "2.1"
                                                                      : "Fig. 2-1";
    summary.add(item, fmt::format("mechanisms, {}", name), first(springs(name), "mechanisms"), "full",
                first(springs("full"), "mechanisms"));
    summary.add(item, fmt::format("most that remains of a deformation, {}", name),
                largest(springs(name), "share"), "full", largest(springs("full"), "share"));
  }
  const auto young = [&](const char* which, const char* direction) {
    return first(
        filtered(
            directions,
            {{"material", "calibrated"}, {"springs", which}, {"modulus", "E"}, {"direction", direction}}),
        "measured");
  };
  for (const auto& [a, b] : {std::pair{"[1 1 0]", "[1 -1 0]"}, {"[1 1 1]", "[1 1 -1]"}})
    summary.add("Fig. 2-2", fmt::format("E along {} / {}, one face diagonal", a, b),
                young("one face diagonal", a) / young("one face diagonal", b), "full",
                young("full", a) / young("full", b));
}

void add_volumes(Summary& summary) {
  const Table &figure = summary.part("thesis_figure_5_1"), &time = summary.part("thesis_volume_time"),
              &shape = summary.part("thesis_shape");
  const auto seconds = [&](const char* what) { return first(time.where("computed", what), "median"); };
  const double estimate = seconds("estimate (3-5, 3-6)");
  summary.add("3.1", "time of a cell's exact volume / of the estimate",
              seconds("exact, trilinear") / estimate, "of a step",
              seconds("step of verlet, all forces") / estimate);
  double worst = no_value;
  for (std::size_t r = 0; r < figure.size(); ++r)
    worst = std::fmax(worst, std::abs(figure.number(r, "error_of_change")));
  summary.add("3.1", "largest error of the estimate / change of volume, Fig. 5-1", worst, "of a cell",
              largest(figure, "worst_cell_error"));
  for (const std::string& name : shape.distinct("case")) {
    const Table at = shape.where("case", name).where("k_vol_over_shear", 1.0);
    summary.add(name.ends_with("1-1") ? "1-2" : "ch. 3",
                fmt::format("change of shape at k_vol = mu, {}", name), first(at, "shape_change"),
                "volume corrected", first(at, "volume_corrected"));
  }
  for (std::size_t r = 0; r < figure.size(); ++r)
    summary.add("Fig. 5-1", fmt::format("volume, {}", figure.text(r, "scene")),
                figure.number(r, "volume_ratio"), "estimate", figure.number(r, "volume_ratio_estimate"));
}

/// At the sample nearest to an angle.
double jacobian_at(const Table& twists, double cells, double guarded, double angle) {
  const Table run = twists.where("cells", cells).where("guarded", guarded);
  double nearest = no_value, found = no_value;
  for (std::size_t r = 0; r < run.size(); ++r)
    if (const double away = std::abs(run.number(r, "angle") - angle); !(away >= nearest)) {
      nearest = away;
      found = run.number(r, "min_jacobian");
    }
  return found;
}

/// Landings whose cube ends folded, at rest or still moving.
Table folded(const Table& landings) {
  Table runs(landings.columns());
  for (std::size_t r = 0; r < landings.size(); ++r) {
    const std::string& outcome = landings.text(r, "outcome");
    if (outcome == "trapped" || (outcome == "moving" && landings.number(r, "min_jacobian") <= 0))
      runs.add(landings.rows()[r]);
  }
  return runs;
}

void add_folding(Summary& summary) {
  const Table &twists = summary.part("thesis_twist"), &landings = summary.part("thesis_landing");
  for (const double n : twists.distinct_numbers("cells"))
    summary.add("Fig. 5-1", fmt::format("smallest corner volume at 60 degrees, n = {:g}", n),
                jacobian_at(twists, n, 0, 60), "fold guard", jacobian_at(twists, n, 1, 60));
  for (const std::string& name : landings.distinct("case"))
    for (const std::string& landing : landings.distinct("landing")) {
      const Table runs = filtered(landings, {{"case", name}, {"landing", landing}});
      const double from = smallest(folded(runs), "speed");
      int above = 0;
      for (std::size_t r = 0; r < runs.size(); ++r)
        above += runs.number(r, "speed") > from && runs.text(r, "outcome") == "recovered" ? 1 : 0;
      summary.add("Fig. 5-4", fmt::format("lowest speed that leaves folds, {}, {} [m/s]", name, landing),
                  from, "recover above it", above, "none of the speeds tried leaves folds");
    }
}

}  // namespace

Table summary_table(const std::vector<NamedTable>& parts) {
  Summary summary(parts);
  add_topologies(summary);
  add_volumes(summary);
  add_folding(summary);
  const Table& frames = summary.part("thesis_frames");
  for (std::size_t r = 0; r < frames.size(); ++r)
    summary.add("5.2.1", fmt::format("frames a second of mss view, n = {:g}", frames.number(r, "cells")),
                frames.number(r, "frames_per_second"), "the thesis's at n = 7", 24);
  return summary.take();
}

}  // namespace mss::studies::thesis
