#include "core/base/limits.hpp"

#include <algorithm>
#include <atomic>

namespace mss {

namespace {

std::atomic<double> most{2e8};

}  // namespace

double most_sites() { return most; }

void limit_sites(double fewer) { most = std::min<double>(most, fewer); }

}  // namespace mss
