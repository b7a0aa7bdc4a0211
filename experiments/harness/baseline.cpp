#include "experiments/harness/baseline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

using Cells = std::vector<std::string>;

struct Parsed {
  Cells header;
  std::vector<Cells> rows;
  explicit Parsed(std::string_view csv) {
    std::vector<Cells> all = parse_csv(csv);
    if (all.empty()) return;
    header = std::move(all.front());
    rows.assign(std::make_move_iterator(all.begin() + 1), std::make_move_iterator(all.end()));
  }
};

std::string joined(const Cells& cells) { return fmt::format("{}", fmt::join(cells, ",")); }

/// The number in a cell; empty if there is none.
std::optional<double> number(const std::string& cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// The condition that a cell does not meet, in words; empty if it meets all.
std::string violation(const std::string& before, const std::string& now, const ColumnRule* rule) {
  if (const auto value = number(now); value && !std::isfinite(*value)) return "must be a finite number";
  if (rule == nullptr) return before == now ? "" : "must be the same";
  const auto a = number(before), b = number(now);
  if (!a || !b) return before == now ? "" : "must be a number, or missing, as it was";
  const double most = std::max(rule->relative * std::abs(*a), rule->absolute);
  if (std::abs(*b - *a) <= most || (*a > rule->failure && *b > rule->failure)) return "";
  return fmt::format("may move by {:.1g} of itself or {:.1g}", rule->relative, rule->absolute);
}

bool is_key(const std::string& column, const Baseline& baseline) {
  return std::find(baseline.keys.begin(), baseline.keys.end(), column) != baseline.keys.end();
}

/// What identifies a row: "cells = 4, model = x".
std::string key_of(const Cells& header, const Cells& row, const Baseline& baseline) {
  std::string text;
  for (std::size_t i = 0; i < std::min(row.size(), header.size()); ++i)
    if (is_key(header[i], baseline))
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", header[i], row[i]);
  return text;
}

class Comparison {
 public:
  Comparison(std::string_view before, std::string_view now, const Baseline& baseline)
      : baseline_(baseline), before_(before), now_(now) {}

  std::vector<Deviation> run() {
    if (before_.header != now_.header) {
      add("", "", joined(before_.header), joined(now_.header), "columns must be the same, in the same order");
      return std::move(deviations_);
    }
    const auto before = by_key(before_.rows), now = by_key(now_.rows);
    for (const Cells& row : before_.rows)
      if (!now.contains(key(row))) add(key(row), "", "a row", "none", "rows must not vanish");
    std::vector<std::string> kept;  // keys in both tables, in the baseline's order
    for (const Cells& row : before_.rows)
      if (now.contains(key(row))) kept.push_back(key(row));
    auto expected = kept.begin();
    bool in_order = true;
    for (const Cells& row : now_.rows) {
      const auto found = before.find(key(row));
      if (found == before.end()) {
        add(key(row), "", "none", "a row", "rows must not appear");
        continue;
      }
      if (in_order && expected != kept.end() && *expected++ != key(row)) {
        add(key(row), "", "another place", "here", "rows must keep their order");
        in_order = false;  // once is enough
      }
      compare_rows(*found->second, row);
    }
    return std::move(deviations_);
  }

 private:
  void add(std::string row, std::string column, std::string before, std::string now, std::string rule) {
    deviations_.push_back(
        {std::move(row), std::move(column), std::move(before), std::move(now), std::move(rule)});
  }

  std::string key(const Cells& row) const { return key_of(before_.header, row, baseline_); }

  std::map<std::string, const Cells*> by_key(const std::vector<Cells>& rows) {
    std::map<std::string, const Cells*> all;
    for (const Cells& row : rows)
      if (!all.emplace(key(row), &row).second) add(key(row), "", "one row", "two", "keys must be unique");
    return all;
  }

  void compare_rows(const Cells& before, const Cells& now) {
    if (before.size() != now.size() || before.size() != before_.header.size()) {
      add(key(now), "", fmt::format("{} cells", before.size()), fmt::format("{} cells", now.size()),
          "rows must have a cell for every column");
      return;
    }
    for (std::size_t i = 0; i < before.size(); ++i) {
      const std::string& column = before_.header[i];
      if (is_key(column, baseline_)) continue;
      const auto rule =
          std::find_if(baseline_.rules.begin(), baseline_.rules.end(), [&](const ColumnRule& r) {
            return r.column == column && (r.only_of.empty() || r.only_of == now.front());
          });
      const std::string why = violation(before[i], now[i], rule == baseline_.rules.end() ? nullptr : &*rule);
      if (!why.empty()) add(key(now), column, before[i], now[i], why);
    }
  }

  const Baseline& baseline_;
  Parsed before_, now_;
  std::vector<Deviation> deviations_;
};

}  // namespace

std::vector<Deviation> compare(std::string_view before, std::string_view now, const Baseline& baseline) {
  return Comparison(before, now, baseline).run();
}

std::vector<Truth> read_truths(const std::filesystem::path& file) {
  const std::vector<Cells> rows = parse_csv(read_file(file));
  const Cells header{"table", "row", "column", "value", "relative", "absolute", "source"};
  if (rows.empty() || rows.front() != header)
    throw InputError(fmt::format("{}: line 1: the columns are not {}", file.string(), joined(header)));
  std::vector<Truth> truths;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    const Cells& row = rows[r];
    std::array<double, 3> numbers{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = row.size() == header.size() ? number(row[3 + i]) : std::nullopt;
      if (!value || !std::isfinite(*value))
        throw InputError(
            fmt::format("{}: row {} has no finite number under {}; give table, row, column, three "
                        "numbers and a source",
                        file.string(), r, header[3 + i]));
      numbers[i] = *value;
    }
    truths.push_back({row[0], row[1], row[2], numbers[0], numbers[1], numbers[2], row[6]});
  }
  return truths;
}

namespace {

/// The cell of a row, by its keys, and a column; "nothing" if there is none.
std::string cell_at(const Parsed& table, const Baseline& baseline, const std::string& keys,
                    const std::string& column_name) {
  const auto row = std::find_if(table.rows.begin(), table.rows.end(),
                                [&](const Cells& r) { return key_of(table.header, r, baseline) == keys; });
  const auto column = std::find(table.header.begin(), table.header.end(), column_name);
  const auto place = std::size_t(column - table.header.begin());
  if (row == table.rows.end() || column == table.header.end() || place >= row->size()) return "nothing";
  return (*row)[place];
}

/// What a truth is about: a cell, or the ratio of two.
std::string found_by(const Truth& truth, const Parsed& table, const Baseline& baseline) {
  const std::size_t over = truth.row.find(truth_ratio);
  std::string above = cell_at(table, baseline, truth.row.substr(0, over), truth.column);
  if (over == std::string::npos) return above;
  const std::string below =
      cell_at(table, baseline, truth.row.substr(over + truth_ratio.size()), truth.column);
  const auto a = number(above), b = number(below);
  return a && b ? fmt::format("{}", *a / *b) : "nothing";
}

}  // namespace

std::vector<Deviation> compare_with_truths(const std::vector<Truth>& truths, const std::string& table,
                                           std::string_view now, const Baseline& baseline) {
  const Parsed parsed(now);
  std::vector<Deviation> wrong;
  for (const Truth& truth : truths) {
    if (truth.table != table) continue;
    const std::string found = found_by(truth, parsed, baseline), right = fmt::format("{}", truth.value);
    if (found == "nothing") {
      wrong.push_back({truth.row, truth.column, right, found, "the truth, by " + truth.source});
      continue;
    }
    const auto value = number(found);
    const double most = std::max(truth.relative * std::abs(truth.value), truth.absolute);
    if (value && std::abs(*value - truth.value) <= most) continue;
    wrong.push_back({truth.row, truth.column, right, found,
                     fmt::format("the truth, by {}; may be off by {:.2g}", truth.source, most)});
  }
  return wrong;
}

std::string to_string(const Deviation& d, std::string_view introduction) {
  const auto shown = [](const std::string& cell) { return cell.empty() ? std::string("nothing") : cell; };
  std::string place = d.row.empty() ? "the table" : d.row;
  if (!d.column.empty()) place += ": " + d.column;
  return fmt::format("{}: {} {}, is {}; {}", place, introduction, shown(d.before), shown(d.now), d.rule);
}

}  // namespace mss
