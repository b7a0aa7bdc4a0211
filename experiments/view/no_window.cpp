// What stands in for window.cpp in a build without the libraries that a window needs.
#include "core/base/error.hpp"
#include "experiments/view/window.hpp"

namespace mss::view {

Status show(const Scene&, const ViewOptions&) {
  throw InputError(
      "this program was built without a window; install libglfw3-dev, libimgui-dev, libstb-dev, "
      "libepoxy-dev and libpng-dev, and configure and build it again");
}

}  // namespace mss::view
