#include "tests/fuzz/memory.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <new>

namespace mss::fuzz {

namespace {

std::ptrdiff_t given = 0, most_given = 0, given_before = 0;

}  // namespace

std::size_t peak_bytes() { return std::size_t(std::max(most_given - given_before, std::ptrdiff_t{0})); }

void reset_peak() { most_given = given_before = given; }

void limit_memory(std::size_t bytes) {
  if (MSS_SANITIZED != 0) return;
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = pages * std::size_t(sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace mss::fuzz

#if MSS_SANITIZED
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "max_allocation_size_mb=512:hard_rss_limit_mb=4096";
}
#else
// Counts what is given out. One thread alone runs an input.
void* operator new(std::size_t size) {
  void* p = std::malloc(size);
  if (p == nullptr) throw std::bad_alloc();
  mss::fuzz::given += std::ptrdiff_t(malloc_usable_size(p));
  mss::fuzz::most_given = std::max(mss::fuzz::most_given, mss::fuzz::given);
  return p;
}
void operator delete(void* p) noexcept {
  mss::fuzz::given -= std::ptrdiff_t(malloc_usable_size(p));
  std::free(p);
}
void operator delete(void* p, std::size_t /*size*/) noexcept { operator delete(p); }
#endif
