#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/scene/scene.hpp"

namespace mss {

/// A hash of 64 bits after Fowler, Noll and Vo's FNV-1a, of eight bytes at a time where there are so many.
class Digest {
 public:
  void add(std::span<const std::byte> bytes) {
    std::size_t i = 0;
    for (; i + sizeof(std::uint64_t) <= bytes.size(); i += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::copy_n(bytes.begin() + std::ptrdiff_t(i), sizeof word,
                  std::as_writable_bytes(std::span(&word, 1)).begin());
      mix(word);
    }
    for (; i < bytes.size(); ++i) mix(std::to_integer<std::uint64_t>(bytes[i]));
  }
  template <class Number>
  void add(const Number& number) {
    add(std::as_bytes(std::span(&number, 1)));
  }
  std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  void mix(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x100000001b3U;
    hash_ ^= hash_ >> 32U;
  }
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

/// The digest of a solid's cells, and of the mesh that planes touch.
std::string digest_of(const std::vector<Level>& levels, const Scene& scene);

}  // namespace mss
