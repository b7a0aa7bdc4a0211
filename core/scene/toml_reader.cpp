#include "core/scene/toml_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace mss {

namespace {

[[noreturn]] void fail(const std::string& message) { throw InputError(message); }

std::string read_text(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    fail(fmt::format("{}: is a directory; give the path of a scene file, such as scene.toml", file.string()));
  std::ifstream in(file);
  if (!in)
    fail(fmt::format("{}: cannot read this scene file; check its path and permissions", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Where the string ends that begins with the quotation mark at `begin`: behind its last one.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  const std::size_t marks = text.substr(begin, 3) == std::string(3, text[begin]) ? 3 : 1;
  const std::string_view mark = text.substr(begin, marks);
  for (std::size_t i = begin + marks; i < text.size(); ++i) {
    if (text[begin] == '"' && text[i] == '\\')
      ++i;
    else if (text.substr(i, marks) == mark || (marks == 1 && text[i] == '\n'))
      return std::min(text.find_first_not_of(marks == 3 ? mark.substr(0, 1) : "", i + marks), text.size());
  }
  return text.size();
}

/// Where keys with dots in them, such as a.b.c, lead more than 256 tables deep; the text's size if they do
/// not. toml++ limits brackets alone, and a table of 100,000 in each other overflows the stack when it ends.
std::size_t find_too_deep(std::string_view text) {
  constexpr std::size_t most = 256;
  std::vector<std::size_t> around;  // dots on the way to each open bracket
  std::size_t dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
    if (c == '"' || c == '\'') i = end_of_string(text, i) - 1;
    if (c == '.' && ++dots > most) return i;
    if (c == '[' || c == '{') around.push_back(dots);
    if (c == ',' || c == '\n') dots = around.empty() ? 0 : around.back();
    if ((c == ']' || c == '}') && !around.empty()) {
      dots = around.back();
      around.pop_back();
    }
  }
  return text.size();
}

toml::table parse(const std::string& text, const std::filesystem::path& file) {
  if (const std::size_t at = find_too_deep(text); at < text.size())
    fail(fmt::format(
        "{}:{}: a key leads more than 256 tables deep, and those of scenes at most two; correct the line",
        file.string(), 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n')));
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    std::string cause(error.description());
    if (!cause.empty()) cause[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(cause[0])));
    fail(fmt::format("{}:{}: this is not TOML, {}; correct the line", file.string(),
                     error.source().begin.line, cause));
  }
}

/// The value of an override as TOML; a word that is not TOML, such as verlet, is taken as a string.
toml::table parse_value(const std::string& value, const std::string& setting) {
  const bool bare = value.find_first_of("[]{}\"'\n\r") == std::string::npos && !value.empty();
  const bool deep = find_too_deep(value) < value.size() || find_too_deep(setting) < setting.size();
  try {
    toml::table parsed = deep ? toml::table() : toml::parse("value = " + value);
    if (parsed.size() == 1) return parsed;
  } catch (const toml::parse_error&) {
    if (bare) return toml::table{{"value", value}};
  }
  fail(fmt::format("--set {}: {} is not a value; give one TOML value, as in --set solve.dt=1e-4", setting,
                   value.empty() ? "nothing" : value));
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string> split_at_dots(const std::string& path) {
  std::vector<std::string> keys;
  std::istringstream in(path + ".");
  for (std::string key; std::getline(in, key, '.');) keys.push_back(trimmed(key));
  return keys;
}

std::string join(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

/// The keys as a path, a renamed one by its present name.
std::string present_path(const std::vector<std::string>& keys, const RenamedKeys& renamed) {
  std::string path = keys.front();
  const auto table = renamed.find(path);
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const bool may_be_old = k == 1 && table != renamed.end() && table->second.contains(keys[k]);
    path = join(path, may_be_old ? table->second.at(keys[k]) : keys[k]);
  }
  return path;
}

/// True if `inner` is `outer` or lies below it.
bool lies_in(const std::string& inner, const std::string& outer) {
  return inner == outer || inner.compare(0, outer.size() + 1, outer + ".") == 0;
}

/// Whether a table or the one around it is of tables alone, as [expect]: plain keys of others mean nothing
/// there.
bool lies_in_table_of_tables(const std::string& pattern, const KnownKeys& known) {
  const std::string outer = pattern.substr(0, pattern.find('.'));
  return !outer.empty() && known.contains(join(outer, known.at(outer).front()));
}

/// The known full key a user most likely meant, as a question: the same name in another table, else the
/// nearest in this one if there is one alike.
std::string suggestion(const std::string& pattern, const std::string& key, const KnownKeys& known) {
  const auto question = [](const std::string& meant) { return fmt::format("; did you mean {}?", meant); };
  if (!lies_in_table_of_tables(pattern, known))
    for (const bool at_top : {true, false})
      for (const auto& [table, keys] : known)
        if (at_top == (table.find('.') == std::string::npos) &&
            std::find(keys.begin(), keys.end(), key) != keys.end())
          return question(join(table, key));
  const std::string near = nearest(key, known.at(pattern));
  return are_alike(key, near) ? question(join(pattern, near)) : std::string();
}

bool contains(const KnownKeys& keys, const std::string& table, const std::string& key) {
  const auto entry = keys.find(table);
  return entry != keys.end() &&
         std::find(entry->second.begin(), entry->second.end(), key) != entry->second.end();
}

bool is_number(std::string_view key) {
  return !key.empty() && key.find_first_not_of("0123456789") == std::string_view::npos;
}

/// A key with # in place of a number between its first two _, as lists of known keys have it.
std::string numbered(const std::string& key) {
  const std::size_t first = key.find('_');
  const std::size_t next = first == std::string::npos ? first : key.find('_', first + 1);
  if (next == std::string::npos || !is_number(std::string_view(key).substr(first + 1, next - first - 1)))
    return key;
  return key.substr(0, first + 1) + "#" + key.substr(next);
}

/// An override makes the tables on the way to its key; they stand on no line.
bool is_made_by_override(const toml::table& table) { return table.source().begin.line == 0; }

/// What a table holds, as the user wrote it; toml++ itself sorts by name.
std::vector<std::pair<std::string, const toml::node*>> in_order_of_lines(const toml::table& table) {
  std::vector<std::pair<std::string, const toml::node*>> entries;
  for (const auto& [key, node] : table) entries.emplace_back(key.str(), &node);
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return a.second->source().begin < b.second->source().begin;
  });
  return entries;
}

}  // namespace

TomlFile::TomlFile(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                   const KnownKeys& known, const RenamedKeys& renamed)
    : TomlFile(read_text(file), file, overrides, known, renamed) {}

TomlFile::TomlFile(const std::string& text, const std::filesystem::path& file,
                   const std::vector<std::string>& overrides, const KnownKeys& known,
                   const RenamedKeys& renamed)
    : file_(file), root_(parse(text, file)) {
  rename_keys(renamed);
  for (const std::string& setting : overrides) {
    const auto equals = setting.find('=');
    const std::string path = trimmed(setting.substr(0, equals));
    const std::vector<std::string> keys = split_at_dots(path);
    if (equals == std::string::npos || std::find(keys.begin(), keys.end(), "") != keys.end())
      fail(fmt::format("--set {}: is not a setting; give table.key=value, as in --set solve.dt=1e-4",
                       setting));
    overrides_.push_back({present_path(keys, renamed), setting});
    apply(overrides_.back(), trimmed(setting.substr(equals + 1)));
    rename_keys(renamed);
  }
  check_keys(root_, "", "", known);
}

void TomlFile::rename_keys(const RenamedKeys& renamed) {
  for (const auto& [name, names] : renamed) {
    toml::node* found = root_.get(name);
    toml::table* table = found == nullptr ? nullptr : found->as_table();
    if (table == nullptr) continue;
    for (const auto& [before, now] : names) {
      toml::node* node = table->get(before);
      if (node == nullptr) continue;
      if (table->contains(now))
        reject(join(name, before), node,
               fmt::format("{0}.{1} conflicts with {0}.{2}, its present name; give one of the two", name,
                           before, now));
      table->insert_or_assign(now, std::move(*node));
      table->erase(before);
    }
  }
}

namespace {

/// A file named on the command line is looked for in the current folder first, as other programs do; in the
/// text of a scene it counts from the scene's own folder.
void find_from_here(const std::string& key, toml::node& value) {
  if (key != "mesh" && key != "voxels") return;
  auto* name = value.as_string();
  if (name == nullptr || name->get().empty()) return;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(name->get(), ignored))
    *name = std::filesystem::absolute(name->get()).string();
}

}  // namespace

void TomlFile::apply(const Override& setting, const std::string& value) {
  toml::table parsed = parse_value(value, setting.text);
  std::vector<std::string> keys = split_at_dots(setting.path);
  const std::string last = keys.back();
  keys.pop_back();
  toml::node* target = &root_;
  for (const std::string& key : keys) {
    if (toml::table* table = target->as_table(); table != nullptr && !table->contains(key))
      table->insert(key, toml::table{});
    target = descend(*target, key, setting);
  }
  toml::node& found = *parsed.get("value");
  find_from_here(last, found);
  if (toml::table* table = target->as_table()) {
    table->insert_or_assign(last, std::move(found));
  } else {
    descend(*target, last, setting);  // checks the index
    toml::array& array = *target->as_array();
    const auto position = array.begin() + std::stol(last);
    array.insert(array.erase(position), std::move(found));
  }
}

toml::node* TomlFile::descend(toml::node& from, const std::string& key, const Override& setting) {
  if (toml::table* table = from.as_table()) return table->get(key);
  toml::array* array = from.as_array();
  if (array == nullptr)
    fail(
        fmt::format("--set {}: '{}' stands below a plain value; give the key of a table", setting.text, key));
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  if (error != std::errc() || end != key.data() + key.size() || index >= array->size())
    fail(fmt::format("--set {}: '{}' is none of the {} entries there; count them from 0", setting.text, key,
                     array->size()));
  return array->get(index);
}

namespace {

/// Names one after the other that differ by their axis, as one.
std::vector<std::string> with_axes_joined(const std::vector<std::string>& names) {
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string stem = names[i].substr(0, names[i].size() - 1);
    const bool has_axes = names[i].ends_with("_x") && i + 2 < names.size() && names[i + 1] == stem + "y" &&
                          names[i + 2] == stem + "z";
    joined.push_back(has_axes ? stem + "x/y/z" : names[i]);
    if (has_axes) i += 2;
  }
  return joined;
}

/// As many as a sentence holds.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t longest = 270;
  std::string text;
  for (const std::string& name : with_axes_joined(names)) {
    if (text.size() + name.size() > longest) return text + ", ...";
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

}  // namespace

void TomlFile::check_keys(const toml::table& table, const std::string& path, const std::string& pattern,
                          const KnownKeys& known) const {
  const auto entry = known.find(pattern);
  if (entry == known.end()) return;  // a table where a plain value belongs: reading it reports that
  for (const auto& [name, node] : in_order_of_lines(table)) {
    const std::string general = numbered(name), full = join(path, name), inner = join(pattern, general);
    if (is_number(name) && is_made_by_override(table) && !pattern.empty())
      reject(
          full, node,
          fmt::format("the scene has no [[{}]]; a setting changes keys of the tables that the file has, and "
                      "adds none",
                      path));
    if (!contains(known, pattern, general))
      reject(full, node,
             fmt::format("{} is not a known {} (known: {}){}", full, node->is_table() ? "table" : "key",
                         listed(entry->second), suggestion(pattern, name, known)));
    if (const toml::table* child = node->as_table()) check_keys(*child, full, inner, known);
    if (const toml::array* children = node->as_array())
      for (std::size_t i = 0; i < children->size(); ++i)
        if (const toml::table* child = children->get(i)->as_table())
          check_keys(*child, fmt::format("{}.{}", full, i), inner, known);
  }
}

std::string TomlFile::place(const std::string& path, const toml::node* node) const {
  // An override of one element is the origin of the whole value, and one below a table that of the table it
  // made.
  const bool whole = node != nullptr && (!node->is_table() || node->source().begin.line == 0);
  const auto blamed = std::find_if(overrides_.rbegin(), overrides_.rend(), [&](const Override& o) {
    return lies_in(path, o.path) || (whole && lies_in(o.path, path));
  });
  if (blamed != overrides_.rend()) return "--set " + blamed->text;
  const auto line = node == nullptr ? 0 : node->source().begin.line;
  return line == 0 ? file_.string() : fmt::format("{}:{}", file_.string(), line);
}

void TomlFile::reject(const std::string& path, const toml::node* node, const std::string& sentence) const {
  fail(fmt::format("{}: {}", place(path, node), sentence));
}

std::string shown(const toml::node& node) {
  std::string text;
  if (const auto* value = node.as_string()) text = fmt::format("\"{}\"", value->get());
  if (const auto* value = node.as_integer()) text = fmt::format("{}", value->get());
  if (const auto* value = node.as_floating_point()) text = fmt::format("{}", value->get());
  if (const auto* value = node.as_boolean()) text = value->get() ? "true" : "false";
  if (node.is_date() || node.is_time() || node.is_date_time()) text = "a date or time";
  if (node.is_table()) text = "{...}";
  if (const toml::array* array = node.as_array()) {
    std::vector<std::string> elements;
    for (std::size_t i = 0; i < std::min<std::size_t>(array->size(), 8); ++i)
      elements.push_back(shown(*array->get(i)));
    if (array->size() > elements.size()) elements.emplace_back("...");
    text = fmt::format("[{}]", fmt::join(elements, ", "));
  }
  constexpr std::size_t longest = 80;
  if (text.size() <= longest) return text;
  std::size_t cut = longest;
  while ((static_cast<unsigned char>(text[cut]) & 0xc0) == 0x80) --cut;  // not inside a UTF-8 character
  return text.substr(0, cut) + "...";
}

TomlTable TomlTable::over(const TomlTable& below, const std::vector<std::string>& but) const {
  TomlTable both = *this;
  both.below_ = std::make_shared<const TomlTable>(below);
  both.hidden_ = but;
  return both;
}

const TomlTable& TomlTable::owner(std::string_view key) const {
  if (own(key) != nullptr || !below_) return *this;
  const bool is_hidden = std::find(hidden_.begin(), hidden_.end(), key) != hidden_.end();
  return !is_hidden && (table_ == nullptr || below_->has(key)) ? below_->owner(key) : *this;
}

TomlTable TomlTable::table(std::string_view key) const {
  const toml::node* node = find(key);
  if (node != nullptr && !node->is_table())
    reject(key, "is not a table; give it as a table of key = value pairs");
  return {*file_, node == nullptr ? nullptr : node->as_table(), path_of(key)};
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> keys;
  if (table_ == nullptr) return keys;
  for (const auto& entry : in_order_of_lines(*table_)) keys.push_back(entry.first);
  return keys;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  if (array == nullptr || !array->is_homogeneous(toml::node_type::table))
    reject(key, fmt::format("is not an array of tables; write [[{}]] above each", key));
  std::vector<TomlTable> tables;
  for (std::size_t i = 0; i < array->size(); ++i)
    tables.push_back({*file_, array->get(i)->as_table(), fmt::format("{}.{}", path_of(key), i)});
  return tables;
}

namespace {

/// A finite number, given as an integer or with a fraction.
std::optional<double> finite_number(const toml::node& node) {
  if (!node.is_number()) return {};
  // A large integer is no double to toml++.
  const double value = node.is_integer() ? double(*node.value<std::int64_t>()) : *node.value<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<double> number_within(const toml::node& node, const Quantity& quantity) {
  const std::optional<double> value = finite_number(node);
  return value && quantity.accepts(*value) ? value : std::nullopt;
}

std::optional<int> whole_within(const toml::node& node, const Quantity& quantity) {
  const std::optional<double> value = number_within(node, quantity);
  const bool fits = value && node.is_integer() && std::abs(*value) <= std::numeric_limits<int>::max();
  return fits ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

std::optional<Vec3> vector_within(const toml::node& node, const Quantity& quantity) {
  const toml::array* array = node.as_array();
  if (array == nullptr || array->size() != 3) return {};
  Vec3 vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> value = number_within(*array->get(i), quantity);
    if (!value) return {};
    vector[static_cast<Eigen::Index>(i)] = *value;
  }
  return vector;
}

}  // namespace

double TomlTable::number(std::string_view key, const Quantity& quantity) const {
  const std::optional<double> value = number_within(need(key, quantity.allowed), quantity);
  if (!value) refuse(key, quantity.noun, quantity.allowed);
  return *value;
}

double TomlTable::number(std::string_view key, const Quantity& quantity, double fallback) const {
  return has(key) ? number(key, quantity) : fallback;
}

int TomlTable::whole(std::string_view key, const Quantity& quantity, int fallback) const {
  if (!has(key)) return fallback;
  const std::optional<int> value = whole_within(*find(key), quantity);
  if (!value) refuse(key, quantity.noun, quantity.allowed);
  return *value;
}

std::array<int, 3> TomlTable::three_whole(std::string_view key, const Quantity& quantity) const {
  const toml::array* array = need(key, quantity.allowed).as_array();
  std::array<int, 3> values{};
  if (array == nullptr || array->size() != values.size()) refuse(key, quantity.noun, quantity.allowed);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::optional<int> value = whole_within(*array->get(i), quantity);
    if (!value) refuse(key, quantity.noun, quantity.allowed);
    values[i] = *value;
  }
  return values;
}

Vec3 TomlTable::vector(std::string_view key, const Quantity& quantity) const {
  const std::optional<Vec3> value = vector_within(need(key, quantity.allowed), quantity);
  if (!value) refuse(key, quantity.noun, quantity.allowed);
  return *value;
}

Vec3 TomlTable::vector(std::string_view key, const Quantity& quantity, const Vec3& fallback) const {
  return has(key) ? vector(key, quantity) : fallback;
}

Box TomlTable::box(std::string_view key) const {
  constexpr Quantity corners{"a box", "[[x, y, z], [x, y, z]] in metres, the lower corner first",
                             [](double) { return true; }};
  const toml::array* array = need(key, corners.allowed).as_array();
  if (array == nullptr || array->size() != 2) refuse(key, corners.noun, corners.allowed);
  const std::optional<Vec3> lower = vector_within(*array->get(0), corners);
  const std::optional<Vec3> upper = vector_within(*array->get(1), corners);
  if (!lower || !upper || (lower->array() > upper->array()).any()) refuse(key, corners.noun, corners.allowed);
  return {*lower, *upper};
}

std::vector<std::vector<double>> TomlTable::rows(std::string_view key, const Quantity& quantity,
                                                 std::size_t columns) const {
  const toml::array* array = need(key, quantity.allowed).as_array();
  if (array == nullptr || array->empty()) refuse(key, quantity.noun, quantity.allowed);
  std::vector<std::vector<double>> rows;
  for (const toml::node& node : *array) {
    const toml::array* row = node.as_array();
    if (row == nullptr || row->size() != columns) refuse(key, quantity.noun, quantity.allowed);
    std::vector<double>& numbers = rows.emplace_back();
    for (const toml::node& element : *row) {
      const std::optional<double> number = number_within(element, quantity);
      if (!number) refuse(key, quantity.noun, quantity.allowed);
      numbers.push_back(*number);
    }
    if (rows.size() > 1 && !(numbers[0] > rows[rows.size() - 2][0]))
      refuse(key, quantity.noun, quantity.allowed);
  }
  return rows;
}

bool TomlTable::boolean(std::string_view key, bool fallback) const {
  if (!has(key)) return fallback;
  if (!find(key)->is_boolean()) refuse(key, "a truth value", "true or false");
  return find(key)->as_boolean()->get();
}

std::string TomlTable::text(std::string_view key, std::string_view noun, std::string_view allowed) const {
  const auto* value = need(key, allowed).as_string();
  if (value == nullptr || value->get().empty()) refuse(key, noun, allowed);
  return value->get();
}

std::vector<std::string> TomlTable::texts(std::string_view key, std::string_view noun,
                                          std::string_view allowed) const {
  const toml::array* array = need(key, allowed).as_array();
  if (array == nullptr || array->empty()) refuse(key, noun, allowed);
  std::vector<std::string> texts;
  for (const toml::node& node : *array) {
    const auto* value = node.as_string();
    if (value == nullptr || value->get().empty()) refuse(key, noun, allowed);
    texts.push_back(value->get());
  }
  return texts;
}

std::size_t TomlTable::choose(std::string_view key, std::string_view noun,
                              const std::vector<std::string>& known) const {
  const auto* value = find(key)->as_string();
  const auto chosen = value == nullptr ? known.end() : std::find(known.begin(), known.end(), value->get());
  if (chosen != known.end()) return static_cast<std::size_t>(chosen - known.begin());
  const std::string near = value == nullptr ? std::string() : nearest(value->get(), known);
  const std::string hint =
      value != nullptr && are_alike(value->get(), near) ? fmt::format(" (the nearest is \"{}\")", near) : "";
  reject(key, fmt::format("is not {}; give one of \"{}\"{}", noun, fmt::join(known, "\", \""), hint));
}

void TomlTable::reject(std::string_view key, const std::string& complaint) const {
  const toml::node* node = find(key);
  const std::string value = node == nullptr ? "" : " = " + shown(*node);
  file_->reject(path_of(key), node == nullptr ? owner(key).table_ : node,
                fmt::format("{}{} {}", path_of(key), value, complaint));
}

void TomlTable::reject_missing(std::string_view key, std::string_view remedy) const {
  file_->reject(path_of(key), owner(key).table_, fmt::format("{} is missing; {}", path_of(key), remedy));
}

const toml::node& TomlTable::need(std::string_view key, std::string_view allowed) const {
  if (!has(key)) reject_missing(key, fmt::format("give {}", allowed));
  return *find(key);
}

std::string TomlTable::path_of(std::string_view key) const { return join(owner(key).path_, key); }

void TomlTable::refuse(std::string_view key, std::string_view noun, std::string_view allowed) const {
  reject(key, fmt::format("is not {}; give {}", noun, allowed));
}

}  // namespace mss
