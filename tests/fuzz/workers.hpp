#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/fuzz/outcome.hpp"

namespace mss::fuzz {

/// Inputs first to end - 1, by several processes, each of which may crash or hang.
struct Campaign {
  std::uint64_t first = 0, end = 0;
  int processes = 1;
  double most_seconds = 10;               ///< of computing, an input may take
  std::size_t most_memory = 256UL << 20;  ///< more than at the start, an input may take [bytes]
};

/// Largest of all inputs, and which one that was.
struct Extreme {
  double value = 0;
  std::uint64_t index = 0;
};

struct CampaignResult {
  std::vector<Ending> endings;  ///< of each input
  Extreme bytes, seconds;
};

/// Runs `run(index, folder)` in processes that have a folder each, with sound files that inputs may name put
/// there by `prepare`. Calls `report` in this process as inputs are done, with their number so far.
CampaignResult run_campaign(
    const Campaign& campaign, const std::function<void(const std::filesystem::path& folder)>& prepare,
    const std::function<Ending(std::uint64_t index, const std::filesystem::path& folder)>& run,
    const std::function<void(std::uint64_t done)>& report);

}  // namespace mss::fuzz
