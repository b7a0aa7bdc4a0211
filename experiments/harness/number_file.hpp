#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mss {

/// A CSV file of numbers under a header of names, which another program may have written. NaN and infinities
/// are read as what they are.
class NumberFile {
 public:
  enum class Rows { needed, may_be_none };
  /// Throws InputError naming file and line if it cannot be read, has no header, no rows where they are
  /// needed, a row has another number of cells than the header, a name is there twice, or a cell is no
  /// number.
  explicit NumberFile(std::filesystem::path file, Rows rows = Rows::needed);

  const std::filesystem::path& file() const { return file_; }
  std::size_t rows() const { return columns_.front().size(); }
  const std::vector<std::string>& names() const { return names_; }
  /// Line of a row in the file, the header's is 1.
  std::size_t line(std::size_t row) const { return lines_[row]; }

  bool has(std::string_view name) const;
  /// By row. Throws InputError if the column is missing.
  const std::vector<double>& column(std::string_view name) const;
  /// The same of whole numbers that are not negative. Throws InputError naming the line for others.
  std::vector<std::size_t> ids(std::string_view name) const;

 private:
  void add_row(std::string_view line, std::size_t number);

  std::filesystem::path file_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
  std::vector<std::size_t> lines_;
};

}  // namespace mss
