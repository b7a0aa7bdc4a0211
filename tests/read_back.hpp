#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "experiments/harness/experiment.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss {

/// Name and gnuplot program of every chart and map that has something on it.
inline std::vector<std::pair<std::string, std::string>> scripts(const Drawings& drawings) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const NamedChart& c : drawings.charts)
    if (has_points(c.chart)) all.emplace_back(c.name, gnuplot_script(c.chart, "a.svg", "a.png"));
  for (const NamedMap& m : drawings.maps)
    if (has_cells(m.chart)) all.emplace_back(m.name, gnuplot_script(m.chart, "a.svg", "a.png"));
  return all;
}

/// Expects that an experiment draws the same from its tables as from their CSV files, as `mss redraw` does,
/// and that it draws something.
inline void expect_same_drawings(const ExperimentInfo& info, const std::vector<NamedTable>& tables) {
  ASSERT_TRUE(info.draw) << info.name;
  std::vector<NamedTable> read;
  read.reserve(tables.size());
  for (const NamedTable& t : tables) read.push_back({t.name, Table::read(t.table.csv(), t.name + ".csv")});
  const auto expected = scripts(info.draw(tables)), found = scripts(info.draw(read));
  EXPECT_FALSE(expected.empty()) << info.name;
  ASSERT_EQ(found.size(), expected.size()) << info.name;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(found[i].first, expected[i].first);
    EXPECT_EQ(found[i].second, expected[i].second) << expected[i].first;
  }
}

}  // namespace mss
