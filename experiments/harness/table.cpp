#include "experiments/harness/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/error.hpp"

namespace mss {

namespace {

bool is_missing(const Cell& cell) {
  const double* number = std::get_if<double>(&cell);
  return number && !std::isfinite(*number);
}

void append_text(std::string& out, const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

void append_cell(std::string& out, const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell))
    append_text(out, *text);
  else if (const auto* integer = std::get_if<std::int64_t>(&cell))
    fmt::format_to(std::back_inserter(out), "{}", *integer);
  else if (!is_missing(cell))
    fmt::format_to(std::back_inserter(out), "{}", std::get<double>(cell));
}

/// A number as it would be written again, or a missing one; nothing for other text.
std::optional<Cell> number_cell(const std::string& text) {
  const char *begin = text.data(), *end = begin + text.size();
  if (text.empty()) return no_value;
  std::int64_t integer = 0;
  double real = 0;
  Cell cell = text;
  if (const auto [at, error] = std::from_chars(begin, end, integer); error == std::errc() && at == end)
    cell = integer;
  else if (const auto [place, problem] = std::from_chars(begin, end, real);
           problem == std::errc() && place == end)
    cell = real;
  std::string again;
  append_cell(again, cell);
  if (std::holds_alternative<std::string>(cell) || again != text) return {};
  return cell;
}

/// Whether a column of read cells, header first, is of numbers. One that is empty throughout is not.
bool is_numeric(const std::vector<std::vector<std::string>>& rows, std::size_t column) {
  bool any = false;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    any = any || !rows[r][column].empty();
    if (!number_cell(rows[r][column])) return false;
  }
  return any;
}

}  // namespace

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

void Table::add(std::vector<Cell> row) {
  if (row.size() != columns_.size())
    throw std::logic_error(fmt::format("a row of {} cells for {} columns", row.size(), columns_.size()));
  if (std::any_of(row.begin(), row.end(), is_missing)) {
    const auto* status = std::get_if<std::string>(&row[index("status")]);
    if (!status || status->empty() || *status == "ok")
      throw std::logic_error("a number is missing and the row's status does not say why");
  }
  rows_.push_back(std::move(row));
}

std::size_t Table::index(std::string_view column) const {
  const auto found =
      std::find_if(columns_.begin(), columns_.end(), [&](const Column& c) { return c.name == column; });
  if (found == columns_.end()) throw std::logic_error(fmt::format("the table has no column '{}'", column));
  return std::size_t(found - columns_.begin());
}

const std::string& Table::text(std::size_t row, std::string_view column) const {
  if (const auto* text = std::get_if<std::string>(&rows_.at(row)[index(column)])) return *text;
  throw std::logic_error(fmt::format("column '{}' holds numbers", column));
}

double Table::number(std::size_t row, std::string_view column) const {
  const Cell& cell = rows_.at(row)[index(column)];
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return double(*integer);
  if (const auto* real = std::get_if<double>(&cell)) return *real;
  if (std::get<std::string>(cell).empty()) return no_value;
  throw std::logic_error(fmt::format("column '{}' holds text", column));
}

Table Table::select(const std::vector<std::string>& columns) const {
  std::vector<std::size_t> places;
  std::vector<Column> selected;
  for (const std::string& name : columns) {
    places.push_back(index(name));
    selected.push_back(columns_[places.back()]);
  }
  Table table(std::move(selected));
  for (const auto& row : rows_) {
    std::vector<Cell> cells;
    cells.reserve(places.size());
    for (const std::size_t place : places) cells.push_back(row[place]);
    table.add(std::move(cells));
  }
  return table;
}

Table Table::where(std::string_view column, std::string_view value) const {
  Table table(columns_);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (text(r, column) == value) table.rows_.push_back(rows_[r]);
  return table;
}

Table Table::where(std::string_view column, double value) const {
  Table table(columns_);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (number(r, column) == value) table.rows_.push_back(rows_[r]);
  return table;
}

std::vector<std::string> Table::distinct(std::string_view column) const {
  std::vector<std::string> values;
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (std::find(values.begin(), values.end(), text(r, column)) == values.end())
      values.push_back(text(r, column));
  return values;
}

std::vector<double> Table::distinct_numbers(std::string_view column) const {
  std::vector<double> values;
  for (std::size_t r = 0; r < rows_.size(); ++r)
    if (std::find(values.begin(), values.end(), number(r, column)) == values.end())
      values.push_back(number(r, column));
  return values;
}

std::string Table::csv() const {
  std::string out;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (c > 0) out += ',';
    append_text(out, columns_[c].name);
  }
  out += '\n';
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c > 0) out += ',';
      append_cell(out, row[c]);
    }
    out += '\n';
  }
  return out;
}

Table Table::read(std::string_view csv, const std::string& name) {
  const auto rows = parse_csv(csv);
  if (rows.empty()) throw InputError(fmt::format("{} has no header", name));
  const std::size_t width = rows[0].size();
  std::vector<Column> columns;
  for (const std::string& column : rows[0]) columns.push_back({column});
  for (std::size_t r = 1; r < rows.size(); ++r)
    if (rows[r].size() != width)
      throw InputError(
          fmt::format("{}:{}: {} cells for {} columns", name, r + 1, rows[r].size(), columns.size()));
  Table table(std::move(columns));
  std::vector<std::vector<Cell>> cells(rows.size() - 1);
  for (std::size_t c = 0; c < width; ++c) {
    const bool numeric = is_numeric(rows, c);
    for (std::size_t r = 1; r < rows.size(); ++r)
      cells[r - 1].push_back(numeric ? *number_cell(rows[r][c]) : Cell(rows[r][c]));
  }
  for (std::size_t r = 0; r < cells.size(); ++r) try {
      table.add(std::move(cells[r]));
    } catch (const std::logic_error& problem) {
      throw InputError(fmt::format("{}:{}: {}", name, r + 2, problem.what()));
    }
  return table;
}

std::vector<std::vector<std::string>> parse_csv(std::string_view text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string cell;
  bool quoted = false, begun = false;  // begun: the current line holds something
  const auto end_cell = [&] { row.push_back(std::exchange(cell, {})); };
  const auto end_row = [&] {
    end_cell();
    rows.push_back(std::exchange(row, {}));
    begun = false;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"')
        cell += c;
      else if (i + 1 < text.size() && text[i + 1] == '"')
        cell += text[++i];
      else
        quoted = false;
    } else if (c == '\n') {
      end_row();
    } else if (c != '\r') {
      begun = true;
      if (c == '"')
        quoted = true;
      else if (c == ',')
        end_cell();
      else
        cell += c;
    }
  }
  if (quoted) throw InputError("the CSV text ends inside a quoted cell");
  if (begun) end_row();
  return rows;
}

}  // namespace mss
