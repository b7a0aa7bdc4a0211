#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiments/harness/table.hpp"

namespace mss::studies::contact {

/// What `mss validate contact` runs of bodies that meet as chance has it.
struct RandomScenesConfig {
  std::uint64_t first_seed = 1;
  int count = 0;
};

/// A scene file of two to five bodies, of random sizes, cells, materials and damping, that fly at each other,
/// some of them under gravity and onto planes, by a random method of all that move particles. The same on
/// every machine.
std::string random_scene(std::uint64_t seed);

Table empty_random();
/// The run of a seed's scene as a row. Its status is `ok`; `gains_momentum`, more than 1e-9 of what moves
/// where no plane is; `turns`, the same of angular momentum, of explicit methods that keep it;
/// `gains_energy`, more than a hundredth of what is at play, of explicit methods at half their safe step, and
/// five hundredths of others; how the method ended; or `refused`, with its sentence in the column `reason`.
void add_random_scene(std::uint64_t seed, Table& rows);

/// How many runs of each method have which status, a line each; and the seeds of those that are out of
/// bounds.
std::string random_summary(const Table& rows);

}  // namespace mss::studies::contact
