#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace mss {

/// A number that does not exist, of a failed run for example.
inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// The value of one cell of a table.
using Cell = std::variant<std::string, std::int64_t, double>;

struct Column {
  std::string name;
  std::string unit = {};  ///< as in "s" or "N/m"; empty for names, counts and ratios
};

/// Named columns and rows, as every experiment returns them.
///
/// A number that does not exist (a failed run, nothing to fit) is a NaN or an infinity in memory and an empty
/// cell in the file. It must be explained: the table must have a column `status`, and that row's status must
/// be neither empty nor "ok".
class Table {
 public:
  explicit Table(std::vector<Column> columns);

  /// Appends a row. Throws std::logic_error if the number of cells is wrong or a missing number is
  /// not explained.
  void add(std::vector<Cell> row);

  const std::vector<Column>& columns() const { return columns_; }
  std::size_t size() const { return rows_.size(); }
  const std::vector<std::vector<Cell>>& rows() const { return rows_; }

  /// Throw std::logic_error for a column that does not exist or holds another type; number() takes integers
  /// too. Of a column that was read and is empty throughout, text() is empty and number() NaN.
  const std::string& text(std::size_t row, std::string_view column) const;
  double number(std::size_t row, std::string_view column) const;

  /// The same rows with these columns only, in this order. Throws std::logic_error for one that does not
  /// exist.
  Table select(const std::vector<std::string>& columns) const;

  /// The rows in which a column of text has a value.
  Table where(std::string_view column, std::string_view value) const;
  /// The same for a column of numbers.
  Table where(std::string_view column, double value) const;

  /// Values of a column of text, in order of first appearance.
  std::vector<std::string> distinct(std::string_view column) const;
  /// The same of a column of numbers.
  std::vector<double> distinct_numbers(std::string_view column) const;

  /// The table as CSV: a header of column names, then the rows. Numbers read back exactly (shortest
  /// round-trip form); text is quoted as RFC 4180 says where it has to be; lines end with a line feed.
  std::string csv() const;

  /// A table from what csv() made, so that its csv() is the same again. A column is of numbers if every cell
  /// of it that is not empty is one, and of text otherwise; units are not in the text. Throws InputError that
  /// names `name` and the line if a row has another number of cells than the header, or a missing number is
  /// not explained.
  static Table read(std::string_view csv, const std::string& name);

 private:
  std::size_t index(std::string_view column) const;

  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

/// Splits CSV text into rows of unquoted cells, header included. Throws InputError if a quote is left open.
std::vector<std::vector<std::string>> parse_csv(std::string_view text);

}  // namespace mss
