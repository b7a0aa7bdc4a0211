#include "core/base/record.hpp"

#include <algorithm>
#include <string>

#include "core/base/error.hpp"

namespace mss {

void Record::fail() { throw InputError("what was kept of the run is not what this program keeps"); }

void Record::keep_bytes(std::span<std::byte> bytes) {
  if (!reads_) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return;
  }
  if (bytes.size() > bytes_.size() - next_) fail();
  std::copy_n(bytes_.begin() + std::ptrdiff_t(next_), bytes.size(), bytes.begin());
  next_ += bytes.size();
}

void Record::begin(std::string_view name) {
  std::vector<char> kept(name.begin(), name.end());
  keep_one(kept);
  if (std::string_view(kept.data(), kept.size()) != name) fail();
}

}  // namespace mss
