#pragma once

#include <iosfwd>
#include <vector>

#include "experiments/harness/table.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss {

/// series.csv.
Table series_table(const std::vector<Measures>& series);

/// particles.csv, row by row: a body may have millions of particles, too many for a Table.
void write_particles(std::ostream& stream, const std::vector<ParticleRecord>& particles);

}  // namespace mss
