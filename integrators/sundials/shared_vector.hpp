#pragma once

#include "core/base/communicator.hpp"
#include "integrators/sundials/first_order.hpp"

namespace mss::sundials {

/// A serial vector, of which the ranks each have a part: what it, and vectors cloned from it, are asked for
/// as a whole (lengths, norms, products) is that of all parts together, the same on every rank. SUNDIALS' own
/// parallel vectors would name MPI, which only the program does.
Vector shared_vector(sunindextype length, const Communicator& ranks, SUNContext context);

}  // namespace mss::sundials
