// In place of device.cpp where libepoxy, through which it finds OpenGL, was not there.
#include "core/base/error.hpp"
#include "core/device/device.hpp"

namespace mss {

namespace {

[[noreturn]] void refuse() {
  throw InputError(
      "this program was built without devices: install libepoxy, which packages.txt names, and build it "
      "again, "
      "or give device = \"cpu\"");
}

}  // namespace

std::vector<DeviceInfo> list_devices() { refuse(); }

std::shared_ptr<Device> Device::open(const std::string&) { refuse(); }

}  // namespace mss
