#pragma once

#include <toml++/toml.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/environment/environment.hpp"

namespace mss {

/// What a number has to be: the test, and the words of "... is not {noun}; give {allowed}".
struct Quantity {
  std::string_view noun;     ///< "a density"
  std::string_view allowed;  ///< "a positive number of kg/m^3"
  bool (*accepts)(double);   ///< called with finite numbers only
};

/// The tables of a format with their keys; "" is the top level, and tables in an array ("hold") share one
/// entry. A # between _ stands for any whole number: hold_#_x for hold_0_x, hold_1_x, ...
using KnownKeys = std::map<std::string, std::vector<std::string>, std::less<>>;

/// What keys of tables at the top level were called before, and are called now, by table.
using RenamedKeys = std::map<std::string, std::map<std::string, std::string, std::less<>>, std::less<>>;

/// A parsed TOML file, with the line or command-line override that every value came from.
class TomlFile {
 public:
  /// Reads `file`, then applies `overrides` in order, each "table.key=value"; 0, 1, ... count the tables of
  /// an array. Throws InputError for what is not TOML, and for every key that is not known. Renamed keys are
  /// accepted, but not suggested, and then have their present names, also in what is rejected.
  TomlFile(const std::filesystem::path& file, const std::vector<std::string>& overrides,
           const KnownKeys& known, const RenamedKeys& renamed = {});
  /// The same of a text that `file` would hold.
  TomlFile(const std::string& text, const std::filesystem::path& file,
           const std::vector<std::string>& overrides, const KnownKeys& known,
           const RenamedKeys& renamed = {});

  const toml::table& root() const { return root_; }
  const std::filesystem::path& file() const { return file_; }

  /// Throws InputError "{file:line or override}: {sentence}", naming the origin of `node`, whose full key is
  /// `path`.
  [[noreturn]] void reject(const std::string& path, const toml::node* node,
                           const std::string& sentence) const;

 private:
  struct Override {
    std::string path;
    std::string text;  ///< as the user gave it
  };
  void rename_keys(const RenamedKeys& renamed);
  void apply(const Override& setting, const std::string& value);
  toml::node* descend(toml::node& from, const std::string& key, const Override& setting);
  void check_keys(const toml::table& table, const std::string& path, const std::string& pattern,
                  const KnownKeys& known) const;
  std::string place(const std::string& path, const toml::node* node) const;

  std::filesystem::path file_;
  toml::table root_;
  std::vector<Override> overrides_;
};

/// A value as an error sentence shows it: on one line and not too long.
std::string shown(const toml::node& node);

/// Typed access to one table of a TomlFile, which must outlive it. A table that is absent reads as an empty
/// one. Everything here throws InputError for a value of the wrong type or outside what is allowed, and,
/// where there is no fallback, for a missing one.
class TomlTable {
 public:
  explicit TomlTable(const TomlFile& file) : file_(&file), table_(&file.root()) {}

  bool has(std::string_view key) const { return find(key) != nullptr; }
  bool is_array(std::string_view key) const { return has(key) && find(key)->is_array(); }
  bool is_text(std::string_view key) const { return has(key) && find(key)->is_string(); }
  const std::string& path() const { return path_; }
  std::vector<std::string> keys() const;

  /// This table and, of the keys that it lacks, another's, but for some.
  TomlTable over(const TomlTable& below, const std::vector<std::string>& but = {}) const;

  /// The table under `key`, or an empty one.
  TomlTable table(std::string_view key) const;
  /// The tables of the array under `key`: `[[key]]`.
  std::vector<TomlTable> tables(std::string_view key) const;

  double number(std::string_view key, const Quantity& quantity) const;
  double number(std::string_view key, const Quantity& quantity, double fallback) const;
  int whole(std::string_view key, const Quantity& quantity, int fallback) const;
  std::array<int, 3> three_whole(std::string_view key, const Quantity& quantity) const;
  Vec3 vector(std::string_view key, const Quantity& quantity) const;
  Vec3 vector(std::string_view key, const Quantity& quantity, const Vec3& fallback) const;
  Box box(std::string_view key) const;
  /// At least one row of so many numbers, whose first ones ascend.
  std::vector<std::vector<double>> rows(std::string_view key, const Quantity& quantity,
                                        std::size_t columns) const;
  bool boolean(std::string_view key, bool fallback) const;
  /// A text that is not empty; `noun` and `allowed` as in Quantity.
  std::string text(std::string_view key, std::string_view noun, std::string_view allowed) const;
  /// At least one such text.
  std::vector<std::string> texts(std::string_view key, std::string_view noun, std::string_view allowed) const;

  /// One of a few names, given as (name, value) pairs.
  template <class Value>
  Value choice(std::string_view key, std::string_view noun,
               const std::vector<std::pair<std::string, Value>>& names, Value fallback) const {
    if (!has(key)) return fallback;
    std::vector<std::string> known;
    known.reserve(names.size());
    for (const auto& [name, value] : names) known.push_back(name);
    return names[choose(key, noun, known)].second;
  }

  /// "{path.key} = {what was found} {complaint}", or "{path.key} is missing; {remedy}".
  [[noreturn]] void reject(std::string_view key, const std::string& complaint) const;
  [[noreturn]] void reject_missing(std::string_view key, std::string_view remedy) const;

 private:
  TomlTable(const TomlFile& file, const toml::table* table, std::string path)
      : file_(&file), table_(table), path_(std::move(path)) {}

  const toml::node* own(std::string_view key) const { return table_ == nullptr ? nullptr : table_->get(key); }
  /// The table that has a key, or would.
  const TomlTable& owner(std::string_view key) const;
  const toml::node* find(std::string_view key) const { return owner(key).own(key); }
  const toml::node& need(std::string_view key, std::string_view allowed) const;
  std::size_t choose(std::string_view key, std::string_view noun,
                     const std::vector<std::string>& known) const;
  std::string path_of(std::string_view key) const;
  [[noreturn]] void refuse(std::string_view key, std::string_view noun, std::string_view allowed) const;

  const TomlFile* file_;
  const toml::table* table_;                  ///< null: absent
  std::string path_;                          ///< full key, "" at the top level
  std::shared_ptr<const TomlTable> below_{};  ///< has what this lacks, but for `hidden_`
  std::vector<std::string> hidden_{};
};

}  // namespace mss
