// What stands in for window.cpp in a build without the libraries that a window needs.
#include "core/base/error.hpp"
#include "experiments/view/window.hpp"

namespace mss::view {

Shown show(const Scene&, const ViewOptions&) {
  throw InputError(
      "this program was built without a window; install libglfw3-dev, libimgui-dev, libstb-dev, "
      "libepoxy-dev, libpng-dev and libwebp-dev, and configure and build it again");
}

}  // namespace mss::view
