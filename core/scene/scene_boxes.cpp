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

/// Calls visit(table, index, box) for every box of particles that something acts on.
void for_each_box(
    const Scene& scene,
    const std::function<void(std::string_view table, std::size_t index, const Box& box)>& visit) {
  const auto each = [&](std::string_view table, const auto& all) {
    for (std::size_t i = 0; i < all.size(); ++i) visit(table, i, all[i].box);
  };
  const auto each_without_surface = [&](std::string_view table, const auto& all) {
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!all[i].surface) visit(table, i, all[i].box);
  };
  each_without_surface("hold", scene.environment.holds);
  each_without_surface("load", scene.environment.loads);
  each("strike", scene.environment.strikes);
  each("weight", scene.body.weights);
}

/// Which boxes have particles of a scene's body, whose lattice is made only if there is a box.
class Particles {
 public:
  explicit Particles(const Scene& scene) : scene_(scene) {
    if (!scene.auto_refinement)
      refined_ = refined_body(scene);  // chosen cells have all of a body's particles
  }

  bool any_in(const Box& box) {
    if (!refined_) {
      if (!body_) body_.emplace(scene_.body);
      return !body_->select(box.lower, box.upper).empty();
    }
    const std::vector<std::ptrdiff_t> sites = select(refined_->levels(), box);
    return std::any_of(sites.begin(), sites.end(),
                       [&](std::ptrdiff_t site) { return refined_->mass(site) > 0; });
  }
  /// Of a box without one.
  std::string complaint() const {
    return fmt::format("contains no particle; give one that does, {}", extent_at_rest(scene_.body));
  }

 private:
  const Scene& scene_;
  std::optional<Body> body_;
  std::unique_ptr<const RefinedBody> refined_;
};

}  // namespace

std::string extent_at_rest(const BodyConfig& config) {
  const Vec3 lower = config.origin;
  const Vec3 upper =
      lower + config.cell_size * Vec3(config.voxels.nx(), config.voxels.ny(), config.voxels.nz());
  return fmt::format("the body at rest spans [{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}]", lower[0],
                     lower[1], lower[2], upper[0], upper[1], upper[2]);
}

void find_empty_boxes(const Scene& scene, const std::function<void(std::string_view table, std::size_t index,
                                                                   const std::string& complaint)>& report) {
  Particles particles(scene);
  for_each_box(scene, [&](std::string_view table, std::size_t index, const Box& box) {
    if (!particles.any_in(box)) report(table, index, particles.complaint());
  });
}

void check_boxes(const Scene& scene) {
  find_empty_boxes(scene, [&](std::string_view table, std::size_t index, const std::string& complaint) {
    throw InputError(fmt::format("{}: {}.{}.box {}", scene.file.string(), table, index, complaint));
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
