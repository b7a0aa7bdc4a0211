// Whether a scene's boxes have particles of its body.
#include "core/scene/scene_boxes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/error.hpp"
#include "core/body/body.hpp"
#include "core/refinement/refined_body.hpp"

namespace mss {

namespace {

/// Calls visit(place, box) for every box of particles that something acts on.
void for_each_box(const Scene& scene,
                  const std::function<void(const PlaceOfBox& place, const Box& box)>& visit) {
  const auto each = [&](PlaceOfBox place, const auto& all) {
    for (place.index = 0; place.index < all.size(); ++place.index) visit(place, all[place.index].box);
  };
  const auto each_without_surface = [&](PlaceOfBox place, const auto& all) {
    for (place.index = 0; place.index < all.size(); ++place.index)
      if (!all[place.index].surface) visit(place, all[place.index].box);
  };
  each_without_surface({.table = "hold"}, scene.environment.holds);
  each_without_surface({.table = "load"}, scene.environment.loads);
  each({.table = "strike"}, scene.environment.strikes);
  if (scene.others.empty()) return each({.table = "weight"}, scene.body.weights);
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    each({.table = "weight", .body = b}, bodies[b]->body.weights);
}

/// Which boxes have particles of a scene's bodies, whose lattices are made only if there is a box.
class Particles {
 public:
  explicit Particles(const Scene& scene) : scene_(scene) {
    if (!scene.auto_refinement)
      refined_ = refined_body(scene);  // chosen cells have all of a body's particles
  }

  /// Of all bodies, or of one.
  bool any_in(const Box& box, std::optional<std::size_t> of = {}) {
    if (refined_) {
      const std::vector<std::ptrdiff_t> sites = select(refined_->levels(), box);
      return std::any_of(sites.begin(), sites.end(),
                         [&](std::ptrdiff_t site) { return refined_->mass(site) > 0; });
    }
    if (bodies_.empty())
      for (const SceneBody* one : bodies_of(scene_))
        bodies_.push_back(std::make_unique<const Body>(one->body));
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if ((!of || b == *of) && !bodies_[b]->select(box.lower, box.upper).empty()) return true;
    return false;
  }
  /// Of a box without one.
  std::string complaint() const {
    return scene_.others.empty()
               ? fmt::format("contains no particle; give one that does, {}", extent_at_rest(scene_.body))
               : std::string("contains no particle; give one that does");
  }

 private:
  const Scene& scene_;
  std::vector<std::unique_ptr<const Body>> bodies_;
  std::unique_ptr<const RefinedBody> refined_;
};

}  // namespace

std::string to_string(const PlaceOfBox& place) {
  return place.body ? fmt::format("body.{}.{}.{}", *place.body, place.table, place.index)
                    : fmt::format("{}.{}", place.table, place.index);
}

std::string extent_at_rest(const BodyConfig& config) {
  const Vec3 lower = config.origin;
  const Vec3 upper =
      lower + config.cell_size * Vec3(config.voxels.nx(), config.voxels.ny(), config.voxels.nz());
  return fmt::format("the body at rest spans [{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}]", lower[0],
                     lower[1], lower[2], upper[0], upper[1], upper[2]);
}

void find_empty_boxes(
    const Scene& scene,
    const std::function<void(const PlaceOfBox& place, const std::string& complaint)>& report) {
  Particles particles(scene);
  for_each_box(scene, [&](const PlaceOfBox& place, const Box& box) {
    if (!particles.any_in(box, place.body)) report(place, particles.complaint());
  });
}

void check_boxes(const Scene& scene) {
  find_empty_boxes(scene, [&](const PlaceOfBox& place, const std::string& complaint) {
    throw InputError(fmt::format("{}: {}.box {}", scene.file.string(), to_string(place), complaint));
  });
}

void check_expected_boxes(const Scene& scene) {
  Particles particles(scene);
  for (const Expectation& e : scene.expectations)
    if (e.quantity == mean_displacement && !e.on_surface && !particles.any_in(e.box))
      throw InputError(
          fmt::format("{}: expect.{}.box {}", scene.file.string(), e.quantity, particles.complaint()));
}

}  // namespace mss
