#include "experiments/simulation/vibrations.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"

namespace mss {

namespace {

constexpr int rigid_motions = 6;

/// Mass, centre and momenta of the particles of one section.
struct Section {
  double mass = 0;
  Vec3 first_moment = Vec3::Zero();
  Vec3 momentum = Vec3::Zero();
};

std::size_t long_axis(const Body& body) {
  const std::array<int, 3> cells = body.config().voxels.size();
  return std::size_t(std::max_element(cells.begin(), cells.end()) - cells.begin());
}

/// Kinetic energies, doubled, of sections that move as a whole.
struct SectionEnergies {
  double sideways = 0, along = 0, turning = 0, all = 0;
};

SectionEnergies energies_of_sections(const Body& body, const Field<double>& shape) {
  const std::size_t axis = long_axis(body);
  std::vector<Section> sections(std::size_t(body.lattice().cells[axis] + 1));
  const auto section_of = [&](std::ptrdiff_t site) {
    return std::size_t(body.lattice().coordinates(site)[axis]);
  };
  SectionEnergies energies;
  for (const std::ptrdiff_t site : body.sites()) {
    Section& section = sections[section_of(site)];
    const double mass = body.mass(site);
    section.mass += mass;
    section.first_moment += mass * body.rest_position(site);
    section.momentum += mass * shape.at(site);
    energies.all += mass * shape.at(site).squaredNorm();
  }
  std::vector<double> spin(sections.size()), inertia(sections.size());
  for (const std::ptrdiff_t site : body.sites()) {
    const std::size_t s = section_of(site);
    const Vec3 along = Vec3::Unit(Eigen::Index(axis));
    const Vec3 arm = along.cross(body.rest_position(site) - sections[s].first_moment / sections[s].mass);
    spin[s] += body.mass(site) * arm.dot(shape.at(site));
    inertia[s] += body.mass(site) * arm.squaredNorm();
  }
  for (std::size_t s = 0; s < sections.size(); ++s) {
    if (sections[s].mass == 0) continue;
    const double along = std::pow(sections[s].momentum[Eigen::Index(axis)], 2) / sections[s].mass;
    energies.along += along;
    energies.sideways += sections[s].momentum.squaredNorm() / sections[s].mass - along;
    if (inertia[s] > 0) energies.turning += spin[s] * spin[s] / inertia[s];
  }
  return energies;
}

SectionMotion motion_of(const Body& body, const Field<double>& shape) {
  const SectionEnergies energies = energies_of_sections(body, shape);
  if (energies.sideways > energies.all / 2) return SectionMotion::bending;
  if (energies.turning > energies.all / 2) return SectionMotion::torsion;
  if (energies.along > energies.all / 2) return SectionMotion::longitudinal;
  return SectionMotion::other;
}

/// Sum of m a.b over particles.
double product(const std::vector<double>& masses, const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < masses.size(); ++i) sum += masses[i] * a[i].dot(b[i]);
  return sum;
}

/// Likenesses of one vibration to others, added up over those of equal frequency.
std::vector<double> added_up(const std::vector<Mode>& modes, const std::vector<double>& likeness) {
  constexpr double equal = 1e-4;  // of a frequency: equal ones come with errors of the search and of fills
  std::vector<double> sums(modes.size());
  for (std::size_t first = 0; first < modes.size();) {
    std::size_t end = first;
    while (end < modes.size() && modes[end].omega <= modes[first].omega * (1 + equal)) ++end;
    const auto from = likeness.begin() + std::ptrdiff_t(first), to = likeness.begin() + std::ptrdiff_t(end);
    std::fill(sums.begin() + std::ptrdiff_t(first), sums.begin() + std::ptrdiff_t(end),
              std::accumulate(from, to, 0.0));
    first = end;
  }
  return sums;
}

/// A vibration of each body, and how alike they are.
struct LikePair {
  double likeness, own;  ///< added up, and without others of equal frequency
  std::size_t fine, coarse;
};

/// The most alike first; none has two partners.
std::vector<Partner> matched_up(std::vector<LikePair> pairs, std::size_t fine, std::size_t coarse) {
  std::sort(pairs.begin(), pairs.end(), [](const LikePair& a, const LikePair& b) {
    return std::tie(a.likeness, a.own) > std::tie(b.likeness, b.own);
  });
  std::vector<Partner> all(fine);
  std::vector<bool> has_partner(fine), is_partner(coarse);
  for (const LikePair& pair : pairs) {
    if (has_partner[pair.fine] || is_partner[pair.coarse]) continue;
    has_partner[pair.fine] = is_partner[pair.coarse] = true;
    all[pair.fine] = {pair.coarse, pair.likeness};
  }
  return all;
}

}  // namespace

const char* to_string(SectionMotion motion) {
  switch (motion) {
    case SectionMotion::bending:
      return "bending";
    case SectionMotion::torsion:
      return "torsion";
    case SectionMotion::longitudinal:
      return "longitudinal";
    case SectionMotion::other:
      break;
  }
  return "other";
}

Vibrations slowest_vibrations(const Scene& scene, int count) {
  if (is_refined(scene))
    throw InputError(
        fmt::format("{}: these vibrations are of bodies with cells of one size; leave "
                    "[[refine]] and body.refinement out",
                    scene.file.string()));
  Environment holds;
  holds.holds = scene.environment.holds;
  Vibrations slow{.body = std::make_unique<const Body>(scene.body), .modes = {}, .motions = {}};
  const std::string model = reduction_named(scene.model) ? spring_model : scene.model;
  const auto system = make_system<double>(model, *slow.body, holds, scene.solve.threads);
  if (unknowns_of(*system).empty()) return slow;
  Work work;
  Modes found = slowest_modes(*system, system->undeformed_state(),
                              count + (holds.holds.empty() ? rigid_motions : 0), work);
  if (found.status != Status::ok)
    throw InputError(fmt::format("{}: the vibrations of its body in cells of {:.4g} m were not found: {}",
                                 scene.file.string(), scene.body.cell_size, to_string(found.status)));
  std::erase_if(found.modes, [](const Mode& mode) { return mode.omega == 0; });
  slow.modes = std::move(found.modes);
  for (const Mode& mode : slow.modes) slow.motions.push_back(motion_of(*slow.body, mode.shape));
  return slow;
}

std::vector<Partner> partners(const Vibrations& fine, const Vibrations& coarse) {
  TriangleMesh particles;
  std::vector<double> masses;
  for (const std::ptrdiff_t site : coarse.body->sites()) {
    particles.vertices.push_back(coarse.body->rest_position(site));
    masses.push_back(coarse.body->mass(site));
  }
  const BodyConfig& cells = fine.body->config();
  const EmbeddedSurface points(particles, cells.voxels, cells.cell_size, cells.origin);
  std::vector<std::vector<Vec3>> shapes;
  for (const Mode& mode : coarse.modes) {
    std::vector<Vec3>& shape = shapes.emplace_back();
    for (const std::ptrdiff_t site : coarse.body->sites()) shape.push_back(mode.shape.at(site));
  }
  std::vector<LikePair> pairs;
  for (std::size_t f = 0; f < fine.size(); ++f) {
    const std::vector<Vec3> shape = points.interpolate(fine.modes[f].shape);
    const double size = product(masses, shape, shape);
    std::vector<double> likeness;
    for (const std::vector<Vec3>& other : shapes) {
      const double cosine = product(masses, shape, other);
      likeness.push_back(cosine * cosine / (size * product(masses, other, other)));
    }
    const std::vector<double> sums = added_up(coarse.modes, likeness);
    for (std::size_t c = 0; c < coarse.size(); ++c) pairs.push_back({sums[c], likeness[c], f, c});
  }
  return matched_up(std::move(pairs), fine.size(), coarse.size());
}

}  // namespace mss
