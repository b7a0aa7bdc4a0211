#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/harness/baseline.hpp"
#include "experiments/peer/score.hpp"

namespace mss::peer {

/// What a result may be off by; nothing: whatever it is.
struct Limits {
  std::optional<double> error{}, volume{}, momentum{}, spin{}, energy{};  ///< shares
  std::optional<double> penetration{};                                    ///< [m]
  std::optional<double> cpu_ms{};                                         ///< of a frame of 1/60 s [ms]
};

/// Throws InputError for a limit on what the scene does not have, as penetration where there are no planes.
void check_limits(const Limits& limits, const Judge& judge);

enum class CheckState { met, missed, not_checked };

/// One thing that a result has to meet.
struct Check {
  std::string name;  ///< "samples", "held", a limit, or "expect " and a quantity
  CheckState state = CheckState::missed;
  std::string words;  ///< as in "error 5.3 %, at most 5 %", or why it is not checked
};

/// All of a result. First that its samples are complete and finite; if so, that held particles stay within
/// 1e-3 of a cell, the limits, and the scene's [expect]: what samples do not show of it, or the reference
/// misses, is not checked.
std::vector<Check> checks_of(const Judge& judge, const Result& result, const Score& score,
                             const Limits& limits);

bool is_missed(const std::vector<Check>& checks);
/// "missed" if one is; else "met", or "complete" where no limit was given and nothing of [expect] was
/// checked.
std::string verdict_of(const std::vector<Check>& checks);
/// Those of a state, in words.
std::string in_words(const std::vector<Check>& checks, CheckState state);

}  // namespace mss::peer
