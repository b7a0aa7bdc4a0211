#pragma once

#include <filesystem>
#include <iosfwd>
#include <vector>

#include "experiments/harness/table.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss {

/// series.csv. All rows must have the same holds and planes, and there must be a row.
Table series_table(const std::vector<SeriesRow>& series);

/// particles.csv, row by row: a body may have millions of particles, too many for a Table.
void write_particles(std::ostream& stream, const std::vector<ParticleRecord>& particles);

/// The same of ranks that share a body: the lowest writes the file, all must call it with their own
/// particles.
void write_particles(const std::filesystem::path& file, const Communicator& ranks,
                     std::vector<ParticleRecord>& particles);

}  // namespace mss
