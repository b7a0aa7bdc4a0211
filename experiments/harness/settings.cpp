#include "experiments/harness/settings.hpp"

#include <fmt/format.h>

#include <charconv>

#include "core/base/error.hpp"

namespace mss {

namespace {

std::string to_text(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) return fmt::format("{}", *integer);
  return fmt::format("{}", std::get<double>(cell));
}

}  // namespace

Table settings_table(const std::vector<std::pair<std::string, Cell>>& settings) {
  Table table({{"setting"}, {"value"}});
  for (const auto& [name, value] : settings) table.add({name, to_text(value)});
  return table;
}

std::string setting_text(const Table& settings, const std::string& name) {
  for (std::size_t r = 0; r < settings.size(); ++r)
    if (settings.text(r, "setting") == name) return to_text(settings.rows()[r].back());
  throw InputError(fmt::format("the table of settings has no '{}'", name));
}

double setting_number(const Table& settings, const std::string& name) {
  const std::string text = setting_text(settings, name);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(fmt::format("the setting '{}' is '{}', which is not a number", name, text));
  return value;
}

}  // namespace mss
