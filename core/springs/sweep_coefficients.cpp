#include "core/springs/sweep_coefficients.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include "core/forces/fold_guard.hpp"

namespace mss {

static_assert(springs_per_site == int(spring_slots.size()) && weights_per_lane == spring_groups);

template <class Real>
SweepCoefficients<Real>::SweepCoefficients(const Body& body, const SweepBlocks& blocks,
                                           const SweepKernel<Real>& kernel)
    : body_(body),
      lanes_(kernel.lanes),
      rsqrt_scale_(kernel.rsqrt_scale),
      own_dampings_(!body.kinds().damping_time()),
      cell_weights_(has_cell_weights()),
      interior_(interior_coefficients()) {
  build_dictionary(blocks);
}

template <class Real>
InteriorCoefficients<Real> SweepCoefficients<Real>::interior_coefficients() const {
  InteriorCoefficients<Real> c{};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const double k = body_.kinds().interior_stiffness(s);
    c.stiffness[s] = static_cast<Real>(k);
    c.rest_pull[s] = static_cast<Real>(k * body_.rest_length(spring_slots[s].kind) / rsqrt_scale_);
    c.rest_length[s] = static_cast<Real>(body_.rest_length(spring_slots[s].kind) / rsqrt_scale_);
    c.damping[s] = static_cast<Real>(k * body_.kinds().damping_time().value_or(0) /
                                     (double(rsqrt_scale_) * double(rsqrt_scale_)));
  }
  c.volume = static_cast<Real>(body_.kinds().interior_volume() / (64 * body_.cell_volume()));
  c.guard = static_cast<Real>(
      guarded_corner_stiffness(body_.kinds().interior_fold_guard(), body_.config().cell_size));
  return c;
}

/// Whether k_vol and k_g have weights of their own, beside those of the body diagonals.
template <class Real>
bool SweepCoefficients<Real>::has_cell_weights() const {
  const std::vector<SiteWeights>& all = body_.kinds().weights();
  return std::any_of(all.begin(), all.end(), [](const SiteWeights& w) {
    return w.volume != w.spring.back() || w.fold_guard != w.spring.back();
  });
}

/// Blocks with equal sites share an entry: a large box has a few dozen.
template <class Real>
void SweepCoefficients<Real>::build_dictionary(const SweepBlocks& blocks) {
  const Lattice& lattice = body_.lattice();
  const auto width = std::size_t(lanes_);
  std::map<std::vector<std::uint32_t>, std::uint32_t> entry_of;
  std::vector<std::uint32_t> kinds(width);
  entry_.reserve(blocks.before(lattice.planes()) + 2);
  for (int k = 0; k < lattice.planes(); ++k)
    for (const BlockRun& run : blocks.of(k))
      for (std::ptrdiff_t first = run.first; first < run.last; first += lanes_) {
        const std::ptrdiff_t site = lattice.plane * k + first;
        for (std::size_t lane = 0; lane < width; ++lane)
          kinds[lane] = body_.kind(site + std::ptrdiff_t(lane));
        entry_.push_back(entry_of.try_emplace(kinds, std::uint32_t(entry_of.size())).first->second);
      }

  entry_.insert(entry_.end(), 2, 0);  // a sweep looks ahead

  content_.assign(entry_of.size(), 0);
  whole_content_ = content_of_all_kinds();
  const std::size_t per_lane =
      weights_per_lane + (own_dampings_ ? springs_per_site : 0U) + (cell_weights_ ? 2U : 0U);
  dictionary_ = AlignedArray<Real>(std::ptrdiff_t(entry_of.size() * width * per_lane));
  for (const auto& [lane_kinds, entry] : entry_of) {
    Real* coefficients = dictionary_.data() + std::size_t(entry) * width * per_lane;
    std::uint32_t content = 0;
    for (std::size_t lane = 0; lane < width; ++lane)
      content |= fill_lane(lane_kinds[lane], coefficients + lane);
    content_[entry] = content;
  }
}

template <class Real>
std::uint32_t SweepCoefficients<Real>::content_of(const SiteElements& e) {
  std::uint32_t content = (e.volume != 0 ? block_volumes : 0U) | (e.fold_guard != 0 ? block_guards : 0U);
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    if (e.stiffness[s] == 0) continue;
    const auto of = spring_slots[s].kind;
    content |= of == SpringSlot::Class::edge   ? block_edges
               : of == SpringSlot::Class::face ? block_faces
                                               : block_bodies;
  }
  return content;
}

/// Of the whole body, so that all ranks sweep with the same code.
template <class Real>
std::uint32_t SweepCoefficients<Real>::content_of_all_kinds() const {
  std::uint32_t content = 0;
  for (std::uint32_t kind = 0; kind < body_.kinds().weights().size(); ++kind)
    content |= content_of(body_.kinds().elements(kind));
  return content;
}

/// Writes one lane of a block's coefficients and returns its contents.
template <class Real>
std::uint32_t SweepCoefficients<Real>::fill_lane(std::uint32_t kind, Real* coefficients) const {
  const std::ptrdiff_t width = lanes_;
  const double scale2 = double(rsqrt_scale_) * double(rsqrt_scale_);
  const SiteWeights& weights = body_.kinds().weights()[kind];
  const SiteElements e = body_.kinds().elements(kind);
  for (const double weight : weights.spring) {
    *coefficients = static_cast<Real>(weight);
    coefficients += width;
  }
  for (std::size_t s = 0; own_dampings_ && s < spring_slots.size(); ++s) {
    *coefficients = static_cast<Real>(e.damping[s] / scale2);
    coefficients += width;
  }
  if (cell_weights_) {
    coefficients[0] = static_cast<Real>(weights.volume);
    coefficients[width] = static_cast<Real>(weights.fold_guard);
  }
  return content_of(e);
}

template <class Real>
void SweepCoefficients<Real>::describe(std::size_t first_block, bool springs, SweepPlane<Real>& p) const {
  p.entry = entry_.data() + first_block;
  p.dictionary = dictionary_.data();
  p.entry_size = dictionary_.size() / std::ptrdiff_t(content_.size());
  p.own_dampings = own_dampings_;
  const std::ptrdiff_t of_bodies = std::ptrdiff_t(lanes_) * (weights_per_lane - 1);
  p.volume_weight = cell_weights_ ? p.entry_size - 2 * lanes_ : of_bodies;
  p.guard_weight = cell_weights_ ? p.entry_size - lanes_ : of_bodies;
  p.content = content_.data();
  p.interior = interior_;
  if (!springs) {
    std::fill(std::begin(p.interior.stiffness), std::end(p.interior.stiffness), Real(0));
    std::fill(std::begin(p.interior.rest_pull), std::end(p.interior.rest_pull), Real(0));
  }
  p.rest_volume = static_cast<Real>(body_.cell_volume());
  p.guarded_length = static_cast<Real>(guarded_length(body_.config().cell_size));
}

template <class Real>
Sweep<Real> SweepCoefficients<Real>::force_sweep(const Sweeps<Real>& sweeps) const {
  if (own_dampings_) return sweeps.own_dampings.for_content(whole_content_);
  return (body_.config().is_damped() ? sweeps.weighted_dampers : sweeps.undamped).for_content(whole_content_);
}

template class SweepCoefficients<float>;
template class SweepCoefficients<double>;

}  // namespace mss
