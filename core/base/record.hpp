#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/field.hpp"

namespace mss {

/// What objects must keep to go on in another process as if they had not stopped: numbers, bit for bit, in
/// the order in which they are told. An object lists them once, in `void remember(Record&)`: where a record
/// is made the calls write, where one is read they set what the object has.
class Record {
 public:
  /// One to be made.
  Record() = default;
  /// One to be read.
  explicit Record(std::vector<std::byte> bytes) : bytes_(std::move(bytes)), reads_(true) {}

  bool reads() const { return reads_; }
  std::vector<std::byte> take_bytes() { return std::move(bytes_); }
  /// Whether all has been read.
  bool at_end() const { return next_ == bytes_.size(); }

  /// Numbers, vectors and matrices of a fixed size, containers of these, and objects with remember().
  template <class... Things>
  void keep(Things&... things) {
    (keep_one(things), ...);
  }

  /// A field with that many sites, or without a size.
  template <class Real>
  void keep_field(Field<Real>& field, std::ptrdiff_t sites) {
    bool has_size = field.size() > 0;
    keep_one(has_size);
    if (reads_) field = has_size ? Field<Real>(sites) : Field<Real>();
    if (has_size) keep_values(std::span(field.axis(0), std::size_t(field.size())));
  }

  /// Numbers in place, as many as there are.
  template <class Number>
  void keep_values(std::span<Number> numbers) {
    std::uint64_t size = numbers.size();
    keep_one(size);
    if (size != numbers.size()) fail();
    keep_bytes(std::as_writable_bytes(numbers));
  }

  /// What comes next. Throws InputError where a record that is read has something else.
  void begin(std::string_view name);

 private:
  /// Throws InputError: the record is not of this program.
  [[noreturn]] static void fail();
  void keep_bytes(std::span<std::byte> bytes);

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void keep_one(Number& number) { keep_bytes(std::as_writable_bytes(std::span(&number, 1))); }
  template <class Thing>
  requires requires(Thing& thing, Record& record) { thing.remember(record); }
  void keep_one(Thing& thing) { thing.remember(*this); }
  template <class Number, int rows, int columns>
  void keep_one(Eigen::Matrix<Number, rows, columns>& matrix) {
    static_assert(rows > 0 && columns > 0);
    keep_values(std::span(matrix.data(), std::size_t(matrix.size())));
  }
  template <class Thing>
  void keep_one(std::vector<Thing>& things) {
    std::uint64_t size = things.size();
    keep_one(size);
    if (reads_ && size > bytes_.size()) fail();  // before memory is asked for
    if (reads_) things.resize(std::size_t(size));
    if constexpr (std::is_arithmetic_v<Thing>)
      keep_bytes(std::as_writable_bytes(std::span(things)));
    else
      for (Thing& thing : things) keep_one(thing);
  }
  template <class Thing>
  void keep_one(std::optional<Thing>& thing) {
    bool is_there = thing.has_value();
    keep_one(is_there);
    if (reads_ && !is_there) thing.reset();
    if (reads_ && is_there) thing.emplace();
    if (is_there) keep_one(*thing);
  }
  template <class Key, class Thing>
  void keep_one(std::map<Key, Thing>& things) {
    std::uint64_t size = things.size();
    keep_one(size);
    if (!reads_)
      for (auto& [key, thing] : things) {
        Key copy = key;
        keep(copy, thing);
      }
    else
      things.clear();
    for (std::uint64_t i = 0; reads_ && i < size; ++i) {
      Key key{};
      keep_one(key);
      keep_one(things[key]);
    }
  }

  std::vector<std::byte> bytes_;
  bool reads_ = false;
  std::size_t next_ = 0;  ///< byte to be read
};

}  // namespace mss
