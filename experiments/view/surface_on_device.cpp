#include "experiments/view/surface_on_device.hpp"

#include <bit>
#include <cstddef>

namespace mss::view {

namespace {

constexpr int floats_to(std::size_t bytes) { return int(bytes / sizeof(float)); }

/// Where each of some lists would begin if they were one, and where the last ends.
template <class Item>
std::vector<std::int32_t> firsts_of(const std::vector<std::vector<Item>>& lists) {
  std::vector<std::int32_t> firsts{0};
  for (const auto& list : lists) firsts.push_back(firsts.back() + std::int32_t(list.size()));
  return firsts;
}

/// That one list.
template <class T, class Item, class Part>
std::vector<T> joined(const std::vector<std::vector<Item>>& lists, Part&& part) {
  std::vector<T> all;
  for (const auto& list : lists)
    for (const Item& item : list) all.push_back(T(part(item)));
  return all;
}

}  // namespace

SurfaceOnDevice::SurfaceOnDevice(const DrawnSurface& surface, const DrawnSurface::Motion& motion,
                                 const std::shared_ptr<Device>& device)
    : entry_count_(std::ptrdiff_t(surface.sites().size())),
      vertex_count_(std::ptrdiff_t(surface.vertices().size())) {
  using Share = DrawnSurface::Motion::Share;
  const DeviceUse use(*device);
  sites_ = memory_of(device, std::vector<std::int32_t>(surface.sites().begin(), surface.sites().end()));
  values_ = DeviceMemory(device, entry_count_ * std::ptrdiff_t(sizeof(float)));
  largest_ = DeviceMemory(device, sizeof(float));
  first_share_ = memory_of(device, firsts_of(motion.shares));
  entries_ = memory_of(device, joined<std::int32_t>(motion.shares, [](const Share& s) { return s.entry; }));
  weights_ = memory_of(device, joined<float>(motion.shares, [](const Share& s) { return s.weight; }));
  first_face_ = memory_of(device, firsts_of(motion.faces_at));
  faces_at_ =
      memory_of(device, joined<std::int32_t>(motion.faces_at, [](std::uint32_t face) { return face; }));
  faces_ = memory_of(device, motion.faces);
  vertices_ = memory_of(device, surface.vertices());
}

template <class Real>
double SurfaceOnDevice::update(DeviceSystem<Real>& body, DisplayedQuantity quantity) {
  const DeviceUse use(body.device());
  constexpr int stride = floats_to(sizeof(SurfaceVertex));
  largest_.clear();
  const bool speed = quantity == DisplayedQuantity::speed;
  body.program(speed ? std::vector<std::string>{"SPEED"} : std::vector<std::string>{},
               {"neighbours", "surface_values"})
      .bind(0, body.x())
      .bind(1, body.v())
      .bind(2, sites_)
      .bind(3, values_)
      .bind(4, largest_)
      .run(entry_count_);
  body.program({}, {"surface_points"})
      .set("vertex_stride", stride)
      .set("value_place", floats_to(offsetof(SurfaceVertex, value)))
      .bind(0, body.x())
      .bind(2, sites_)
      .bind(3, values_)
      .bind(4, first_share_)
      .bind(5, entries_)
      .bind(6, weights_)
      .bind(7, vertices_)
      .run(vertex_count_);
  body.program({}, {"surface_normals"})
      .set("vertex_stride", stride)
      .set("normal_place", floats_to(offsetof(SurfaceVertex, normal)))
      .bind(4, first_face_)
      .bind(5, faces_at_)
      .bind(6, faces_)
      .bind(7, vertices_)
      .run(vertex_count_);
  std::uint32_t bits = 0;
  largest_.read(&bits, 0, sizeof(bits));
  return double(std::bit_cast<float>(bits));
}

template double SurfaceOnDevice::update(DeviceSystem<float>&, DisplayedQuantity);
template double SurfaceOnDevice::update(DeviceSystem<double>&, DisplayedQuantity);

}  // namespace mss::view
