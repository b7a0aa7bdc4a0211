#include "experiments/harness/number_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Calls take(cell) for each cell of a line.
template <class Take>
void for_each_cell(std::string_view line, Take&& take) {
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    take(without_blanks(line.substr(begin, end - begin)));
    begin = end + 1;
  }
}

}  // namespace

NumberFile::NumberFile(std::filesystem::path file, Rows rows) : file_(std::move(file)) {
  const std::string text = read_file(file_);
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = without_blanks(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    ++number;
    if (line.empty()) continue;
    if (!names_.empty()) {
      add_row(line, number);
      continue;
    }
    for_each_cell(line, [&](std::string_view name) {
      if (std::find(names_.begin(), names_.end(), name) != names_.end())
        throw InputError(fmt::format("{}:{}: column {} is there twice", file_.string(), number, name));
      names_.emplace_back(name);
    });
    columns_.resize(names_.size());
  }
  if (names_.empty() || (lines_.empty() && rows == Rows::needed))
    throw InputError(fmt::format("{} has no rows", file_.string()));
}

void NumberFile::add_row(std::string_view line, std::size_t number) {
  std::size_t column = 0;
  for_each_cell(line, [&](std::string_view cell) {
    if (column == names_.size())
      throw InputError(fmt::format("{}:{}: there are more cells than the {} of the header", file_.string(),
                                   number, names_.size()));
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size())
      throw InputError(
          fmt::format("{}:{}: {} = '{}' is not a number", file_.string(), number, names_[column], cell));
    columns_[column++].push_back(value);
  });
  if (column != names_.size())
    throw InputError(fmt::format("{}:{}: column {} has no number", file_.string(), number, names_[column]));
  lines_.push_back(number);
}

bool NumberFile::has(std::string_view name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

const std::vector<double>& NumberFile::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end())
    throw InputError(fmt::format("{}:1: column {} is missing; there are {}", file_.string(), name,
                                 fmt::join(names_, ", ")));
  return columns_[std::size_t(found - names_.begin())];
}

std::vector<std::size_t> NumberFile::ids(std::string_view name) const {
  constexpr double most = 1e15;  // which doubles count without gaps
  std::vector<std::size_t> ids;
  ids.reserve(rows());
  for (const double value : column(name)) {
    if (!(value >= 0 && value < most && value == std::floor(value)))
      throw InputError(fmt::format("{}:{}: {} = {:g} is not a whole number of at least 0", file_.string(),
                                   line(ids.size()), name, value));
    ids.push_back(std::size_t(value));
  }
  return ids;
}

}  // namespace mss
