#pragma once

#include "experiments/harness/json.hpp"
#include "experiments/harness/table.hpp"

namespace mss {

/// The rows of a table, as the result of a case: numbers that are missing become null.
Json rows_of(const Table& table);

/// Appends them to a table with the same columns.
void add_rows(const Json& rows, Table& table);

}  // namespace mss
