#pragma once

#include <cstddef>

namespace mss::fuzz {

/// Bytes that operator new has given out since reset_peak() at most at once, those before left out. 0 under
/// sanitizers, whose own operator new finds more.
std::size_t peak_bytes();
void reset_peak();

/// Limits the address space of this process to so many bytes more than it has, so that larger requests throw
/// std::bad_alloc. Does nothing under sanitizers, which have a limit of their own.
void limit_memory(std::size_t bytes);

}  // namespace mss::fuzz
