#pragma once

namespace mss {

/// Most sites of a lattice. `mss run` needs some 250 bytes per site: beyond this, bodies outgrow the memory
/// of a large workstation. A variable, because tests that make bodies by the thousand lower it.
inline double most_sites = 2e8;

}  // namespace mss
