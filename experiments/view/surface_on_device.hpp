#pragma once

#include "core/device/device_system.hpp"
#include "experiments/view/drawn_surface.hpp"
#include "experiments/view/picture.hpp"

namespace mss::view {

/// The vertices of a drawn surface on the device that steps its body, whose shaders do what update() does on
/// the processor.
class SurfaceOnDevice {
 public:
  SurfaceOnDevice(const DrawnSurface& surface, const DrawnSurface::Motion& motion,
                  const std::shared_ptr<Device>& device);

  /// Whether shaders find it; the others need positions on the processor.
  static bool knows(DisplayedQuantity quantity) {
    return quantity == DisplayedQuantity::stretch || quantity == DisplayedQuantity::speed;
  }
  /// Moves the vertices to where the body is and gives them their values; returns the largest of all
  /// particles'. Of quantities that it knows.
  template <class Real>
  double update(DeviceSystem<Real>& body, DisplayedQuantity quantity);

  /// A SurfaceVertex each, in the order of the surface.
  unsigned vertices() const { return vertices_.id(); }

 private:
  std::ptrdiff_t entry_count_, vertex_count_;
  DeviceMemory sites_, values_, largest_;
  DeviceMemory first_share_, entries_, weights_;
  DeviceMemory first_face_, faces_at_, faces_;
  DeviceMemory vertices_;
};

}  // namespace mss::view
