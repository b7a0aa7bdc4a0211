#include "tests/experiments/harness/figures.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <regex>
#include <stdexcept>

#include "experiments/harness/table.hpp"

namespace mss {

namespace {

using Rows = std::vector<std::vector<std::string>>;

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t at; (at = text.find(separator, from)) != std::string::npos; from = at + separator.size())
    parts.push_back(text.substr(from, at - from));
  parts.push_back(text.substr(from));
  return parts;
}

std::optional<double> number_in(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::size_t index_of(const Rows& table, const std::string& column) {
  const std::vector<std::string>& names = table.front();
  const auto found = std::find(names.begin(), names.end(), column);
  if (found == names.end())
    throw std::invalid_argument(
        fmt::format("there is no column '{}', only {}", column, fmt::join(names, ", ")));
  return std::size_t(found - names.begin());
}

bool compares(const std::string& cell, const std::string& relation, const std::string& value) {
  const auto a = number_in(cell), b = number_in(value);
  if (relation == "=") return a && b ? *a == *b : cell == value;
  if (!a || !b) return false;
  if (relation == ">=") return *a >= *b;
  if (relation == "<=") return *a <= *b;
  return relation == ">" ? *a > *b : *a < *b;
}

bool meets(const Rows& table, const std::vector<std::string>& row, const std::string& condition) {
  static const std::regex form("([A-Za-z0-9_]+)(!=|>=|<=|=|>|<)(.*)");
  std::smatch part;
  if (!std::regex_match(condition, part, form))
    throw std::invalid_argument(fmt::format("'{}' is no condition", condition));
  const std::string& cell = row[index_of(table, part[1])];
  const bool unequal = part[2] == "!=";
  const std::vector<std::string> values = split(part[3], "|");
  return unequal != std::any_of(values.begin(), values.end(), [&](const std::string& value) {
           return compares(cell, unequal ? "=" : part[2].str(), value);
         });
}

/// Rows, without the header, that meet all conditions.
Rows rows_where(const Rows& table, const std::string& conditions) {
  Rows rows;
  const std::vector<std::string> all =
      conditions.empty() ? std::vector<std::string>{} : split(conditions, "; ");
  for (std::size_t r = 1; r < table.size(); ++r)
    if (std::all_of(all.begin(), all.end(),
                    [&](const std::string& condition) { return meets(table, table[r], condition); }))
      rows.push_back(table[r]);
  return rows;
}

double aggregate(const std::string& name, std::vector<double> values) {
  if (std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); }))
    return std::nan("");
  std::sort(values.begin(), values.end());
  if (name == "min") return values.front();
  if (name == "max") return values.back();
  if (name == "median") return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

/// Of "[min|max|median|sum of] column,column [where conditions]", row by row.
std::vector<double> values_of(const Rows& table, const std::string& term) {
  static const std::regex of_all("(?:(min|max|median|sum) of )?(.*)");
  std::smatch part;
  std::regex_match(term, part, of_all);
  const std::vector<std::string> parts = split(part[2], " where ");
  std::vector<double> values;
  for (const std::vector<std::string>& row : rows_where(table, parts.size() > 1 ? parts[1] : ""))
    for (const std::string& column : split(parts[0], ","))
      values.push_back(number_in(row[index_of(table, column)]).value_or(std::nan("")));
  if (values.empty()) throw std::invalid_argument(fmt::format("no row for '{}'", term));
  return part[1].matched ? std::vector{aggregate(part[1], std::move(values))} : values;
}

std::vector<double> quotient(std::vector<double> values, const std::vector<double>& divisors) {
  if (divisors.size() != 1 && divisors.size() != values.size())
    throw std::invalid_argument(fmt::format("{} values over {}", values.size(), divisors.size()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] /= divisors[divisors.size() == 1 ? 0 : i];
  return values;
}

/// The numbers that a title asks for.
std::vector<double> evaluate(const std::string& title, const Rows& table) {
  static const std::regex form("(?:(min|max|median|sum) (?!of ))?(abs )?(?:([-+.0-9e]+) )?(.*)");
  if (title == "count" || title.starts_with("count where "))
    return {double(rows_where(table, title.size() > 5 ? title.substr(12) : "").size())};
  std::smatch part;
  std::regex_match(title, part, form);
  static const std::regex two("(.*) (over|off) (.*)");
  std::smatch of_two;
  const std::string terms = part[4];
  const bool is_ratio = std::regex_match(terms, of_two, two);
  std::vector<double> values = values_of(table, is_ratio ? of_two[1].str() : terms);
  if (is_ratio) values = quotient(std::move(values), values_of(table, of_two[3]));
  if (is_ratio && of_two[2] == "off")
    for (double& value : values) value -= 1;
  if (part[2].matched)
    for (double& value : values) value = std::abs(value);
  if (part[3].matched)
    for (double& value : values) value *= number_in(part[3]).value();
  return part[1].matched ? std::vector{aggregate(part[1], std::move(values))} : values;
}

/// A number as a text shows it, and half a unit of its last digit.
struct Shown {
  double value, tolerance;
};
std::vector<Shown> numbers_in(std::string text) {
  static const std::regex thousands("(\\d),(?=\\d{3}(?!\\d))"),
      form("(-?\\d+(?:\\.(\\d+))?)(?:e([-+]?\\d+))?");
  text = std::regex_replace(text, thousands, "$1");
  std::vector<Shown> all;
  for (std::sregex_iterator at(text.begin(), text.end(), form), end; at != end; ++at) {
    const double power = (*at)[3].matched ? std::stod((*at)[3]) : 0;
    all.push_back({std::stod((*at)[0]), 0.5 * std::pow(10, power - double((*at)[2].length()))});
  }
  return all;
}

bool is_shown_as(double value, const Shown& shown) {
  return std::abs(value - shown.value) <= shown.tolerance * (1 + 1e-9) + 1e-12 * std::abs(value);
}

}  // namespace

std::vector<Figure> figures_in(const std::string& markdown) {
  static const std::regex form(
      "\\[((?:[^\\[\\]]|\\[[^\\[\\]]*\\])*)\\]\\(([^() ]+\\.csv)\\s+\"([^\"]*)\"\\)");
  std::vector<Figure> figures;
  for (std::sregex_iterator at(markdown.begin(), markdown.end(), form), end; at != end; ++at) {
    const auto line = 1 + std::count(markdown.begin(), markdown.begin() + at->position(), '\n');
    std::string title = (*at)[3], shown = (*at)[1];
    for (std::string* text : {&title, &shown}) std::replace(text->begin(), text->end(), '\n', ' ');
    figures.push_back({int(line), shown, (*at)[2], title});
  }
  return figures;
}

std::string problem_with(const Figure& figure, const std::string& csv) try {
  std::vector<double> values = evaluate(figure.title, parse_csv(csv));
  const std::vector<Shown> shown = numbers_in(figure.shown);
  const bool is_range = shown.size() == 2 && figure.shown.find(" to ") != std::string::npos;
  if (is_range)
    values = {*std::min_element(values.begin(), values.end()),
              *std::max_element(values.begin(), values.end())};
  const bool same =
      shown.size() == values.size() && std::equal(values.begin(), values.end(), shown.begin(), is_shown_as);
  if (same) return {};
  return fmt::format("line {}: '{}' is shown, and {} says {:.6g} ({})", figure.line, figure.shown,
                     figure.table, fmt::join(values, ", "), figure.title);
} catch (const std::invalid_argument& error) {
  return fmt::format("line {}: '{}' is shown, but in {} {} ({})", figure.line, figure.shown, figure.table,
                     error.what(), figure.title);
}

}  // namespace mss
