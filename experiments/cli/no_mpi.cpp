#include <fmt/format.h>

#include "core/base/error.hpp"
#include "experiments/cli/launched_ranks.hpp"

namespace mss::cli {

std::unique_ptr<ConnectedCommunicator> connect_ranks(const std::string&) {
  if (launch().count > 1)
    throw InputError(fmt::format(
        "{} processes were started, and this mss was built without MPI: they cannot share a body; "
        "start it without mpirun, or build it with MPI",
        launch().count));
  return std::make_unique<ConnectedCommunicator>();
}

}  // namespace mss::cli
