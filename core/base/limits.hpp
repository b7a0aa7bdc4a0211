#pragma once

namespace mss {

/// Most sites of a lattice. `mss run` needs some 250 bytes per site: beyond this, bodies outgrow the memory
/// of a large workstation.
double most_sites();
/// For tests that make bodies by the thousand: fewer from now on, in all of the process.
void limit_sites(double most);

}  // namespace mss
