#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiments/harness/table.hpp"

namespace mss {

/// Settings of a run that its charts mention, as a table with the columns "setting" and "value", so that
/// charts can be drawn from tables alone. Values are text; numbers are in their shortest round-trip form.
Table settings_table(const std::vector<std::pair<std::string, Cell>>& settings);

/// The value of a setting in such a table. Throw InputError if there is none, or none of that type.
std::string setting_text(const Table& settings, const std::string& name);
double setting_number(const Table& settings, const std::string& name);

}  // namespace mss
