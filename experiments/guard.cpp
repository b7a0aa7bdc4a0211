#include "experiments/guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

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

/// The number a cell holds; empty if it holds something else.
std::optional<double> number(const std::string& cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// What one cell deviates by from its rule, in words; empty: by nothing.
std::string broken(const std::string& before, const std::string& now, const ColumnRule* rule) {
  if (const auto value = number(now); value && !std::isfinite(*value)) return "must be a finite number";
  if (rule == nullptr) return before == now ? "" : "must be the same";
  const auto a = number(before), b = number(now);
  if (!a || !b) return before == now ? "" : "must be a number, or missing, as it was";
  const double most = std::max(rule->relative * std::abs(*a), rule->absolute);
  if (std::abs(*b - *a) <= most) return "";
  return fmt::format("may move by {:.1g} of itself or {:.1g}", rule->relative, rule->absolute);
}

class Comparison {
 public:
  Comparison(std::string_view baseline, std::string_view now, const Guard& guard)
      : guard_(guard), before_(baseline), now_(now) {}

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

  bool is_key(const std::string& column) const {
    return std::find(guard_.keys.begin(), guard_.keys.end(), column) != guard_.keys.end();
  }

  std::string key(const Cells& row) const {
    std::string text;
    for (std::size_t i = 0; i < std::min(row.size(), before_.header.size()); ++i)
      if (is_key(before_.header[i]))
        text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", before_.header[i], row[i]);
    return text;
  }

  std::map<std::string, const Cells*> by_key(const std::vector<Cells>& rows) {
    std::map<std::string, const Cells*> all;
    for (const Cells& row : rows)
      if (!all.emplace(key(row), &row).second)
        add(key(row), "", "one row", "two", "rows must have names of their own");
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
      if (is_key(column)) continue;
      const auto rule = std::find_if(guard_.rules.begin(), guard_.rules.end(),
                                     [&](const ColumnRule& r) { return r.column == column; });
      const std::string why = broken(before[i], now[i], rule == guard_.rules.end() ? nullptr : &*rule);
      if (!why.empty()) add(key(now), column, before[i], now[i], why);
    }
  }

  const Guard& guard_;
  Parsed before_, now_;
  std::vector<Deviation> deviations_;
};

}  // namespace

std::vector<Deviation> compare(std::string_view baseline, std::string_view now, const Guard& guard) {
  return Comparison(baseline, now, guard).run();
}

std::string to_string(const Deviation& d) {
  const auto shown = [](const std::string& cell) { return cell.empty() ? std::string("nothing") : cell; };
  std::string place = d.row.empty() ? "the table" : d.row;
  if (!d.column.empty()) place += ": " + d.column;
  return fmt::format("{}: was {}, is {}; {}", place, shown(d.before), shown(d.now), d.rule);
}

}  // namespace mss
