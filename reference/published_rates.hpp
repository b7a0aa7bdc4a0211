#pragma once

#include <string>
#include <vector>

namespace mss::reference {

/// A row of published_rates.csv: how much a mass-spring program updates in a second, as its authors print it.
/// Nobody measured it here, and it is of their hardware.
struct PublishedRate {
  std::string program;
  int year = 0;
  double rate = 0;       ///< [1/s]
  std::string counted;   ///< what, in the authors' words, which do not say whether that is springs alone
  std::string hardware;  ///< as they name it
  std::string quoted;    ///< from the abstract
  std::string source;
};

/// All of them, in the order of the table.
const std::vector<PublishedRate>& published_rates();

}  // namespace mss::reference
