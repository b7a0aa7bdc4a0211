// What devices can do at most: which there are, their bandwidth, the largest body.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/base/lattice.hpp"
#include "core/device/device.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/studies/timing/devices.hpp"

namespace mss::studies::timing {

namespace {

constexpr std::ptrdiff_t largest_copied = std::ptrdiff_t{1} << 28;  // B; caches have less
constexpr int copies_in_sample = 8;

/// Whether a device has memory for what a DeviceSystem keeps of a cube: places and velocities, and the same
/// after a step, and kinds.
bool has_memory_for(const std::shared_ptr<Device>& device, int n) {
  const Lattice lattice(n, n, n);
  const std::ptrdiff_t vectors = std::ptrdiff_t(sizeof(float)) * (3 * lattice.size + 4 * (2 * lattice.plane));
  try {
    std::vector<DeviceMemory> all;
    for (int i = 0; i < 4; ++i) all.emplace_back(device, vectors);
    all.emplace_back(device, std::ptrdiff_t(sizeof(std::uint32_t)) * lattice.size);
    device->finish();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<TimedDevice> timed_devices() {
  Device::open("gpu");  // throws
  const std::vector<DeviceInfo> all = list_devices();
  std::vector<TimedDevice> cards, in_software;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].fault.empty())
      (all[i].is_software ? in_software : cards)
          .push_back({fmt::format("gpu:{}", i), all[i].name, all[i].is_software});
  const std::vector<TimedDevice> as_called = cards;
  for (TimedDevice& card : cards)
    if (std::count_if(as_called.begin(), as_called.end(),
                      [&](const TimedDevice& other) { return other.name == card.name; }) > 1)
      card.name += fmt::format(" ({})", card.choice);
  if (!cards.empty()) return cards;
  in_software.front().name += " in software";
  return {in_software.front()};
}

double copy_bandwidth(const TimedDevice& timed) {
  const auto device = Device::open(timed.choice);
  const DeviceUse use(*device);
  const std::ptrdiff_t bytes = std::min<std::ptrdiff_t>(largest_copied, device->largest_buffer());
  const DeviceMemory from(device, bytes);
  DeviceMemory to(device, bytes);
  std::vector<double> rates;
  for (int repetition = 0; repetition < 6; ++repetition) {
    device->finish();
    const double seconds = seconds_of([&] {
      for (int i = 0; i < copies_in_sample; ++i) to.copy(from);
      device->finish();
    });
    if (repetition > 0) rates.push_back(2.0 * copies_in_sample * double(bytes) / seconds);
  }
  return quartiles(rates).median;
}

int largest_cube_on(const TimedDevice& timed, int fits, int most) {
  const auto device = Device::open(timed.choice);
  const DeviceUse use(*device);
  int above = fits;
  while (above < most) {
    above = std::min(2 * above, most);
    if (!has_memory_for(device, above)) break;
    fits = above;
  }
  while (above - fits > 1) {
    const int middle = (fits + above) / 2;
    (has_memory_for(device, middle) ? fits : above) = middle;
  }
  return fits;
}

}  // namespace mss::studies::timing
