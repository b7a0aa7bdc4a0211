#include "core/bodies/bodies_tangents.hpp"

#include <algorithm>

namespace mss {

template <class Real>
const std::vector<FreeDof>& BodiesTangents<Real>::unknowns() {
  if (unknowns_.empty()) unknowns_ = unknowns_of(system_);
  return unknowns_;
}

template <class Real>
void BodiesTangents<Real>::build() {
  if (!of_body_.empty()) return;
  unknowns();
  number_.assign(3 * std::size_t(system_.size()), -1);
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    number_[3 * std::size_t(unknowns_[i].site) + std::size_t(unknowns_[i].axis)] = int(i);
  bodies_ = SparseMatrix(Eigen::Index(unknowns_.size()), Eigen::Index(unknowns_.size()));
  Eigen::Index row = 0, numbers = 0;
  for (const auto& part : system_.parts_) {
    of_body_.push_back(part->system->tangents()->pattern());
    numbers += of_body_.back().nonZeros();
  }
  bodies_.reserve(numbers);
  for (const SparseMatrix& matrix : of_body_) {
    const Eigen::Index first = row;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i, ++row) {
      bodies_.startVec(row);
      for (SparseMatrix::InnerIterator entry(matrix, i); entry; ++entry)
        bodies_.insertBackByOuterInner(row, first + entry.col()) = 0;
    }
  }
  bodies_.finalize();
}

template <class Real>
SparseMatrix BodiesTangents<Real>::pattern() {
  build();
  std::fill_n(bodies_.valuePtr(), bodies_.nonZeros(), 0.0);
  return bodies_;
}

template <class Real>
void BodiesTangents<Real>::load(const Field<Real>& x, const Field<Real>& v) {
  system_.load_state(x, v);
  if (system_.forces_) system_.forces_->template find<Real>(system_.positions());
}

template <class Real>
void BodiesTangents<Real>::values(double t, const Field<Real>& x, const Field<Real>& v,
                                  const TangentCoefficients& sum, SparseMatrix& matrix) {
  build();
  load(x, v);
  double* next = bodies_.valuePtr();
  for (std::size_t i = 0; i < of_body_.size(); ++i) {
    auto& part = *system_.parts_[i];
    part.system->tangents()->values(t, part.state.x, part.state.v, sum, of_body_[i]);
    next = std::copy_n(of_body_[i].valuePtr(), of_body_[i].nonZeros(), next);
  }
  matrix = bodies_;
  if (!system_.forces_ || !system_.forces_->touches()) return;
  std::vector<Eigen::Triplet<double, int>> entries;
  system_.forces_->for_each_stiffness(
      [&](std::span<const ContactForces::Carrier> carriers, const Eigen::Matrix3d& block) {
        for (const auto& a : carriers)
          for (const auto& b : carriers)
            for (int i = 0; i < 9; ++i) {
              const int row = number_[3 * std::size_t(site_of(a)) + std::size_t(i % 3)],
                        column = number_[3 * std::size_t(site_of(b)) + std::size_t(i / 3)];
              if (row >= 0 && column >= 0)
                entries.emplace_back(row, column, sum.stiffness * a.weight * b.weight * block(i % 3, i / 3));
            }
      });
  SparseMatrix contact(matrix.rows(), matrix.cols());
  contact.setFromTriplets(entries.begin(), entries.end());
  matrix = SparseMatrix(bodies_ + contact);
}

template <class Real>
void BodiesTangents<Real>::product(double t, const Field<Real>& x, const Field<Real>& v,
                                   const TangentCoefficients& sum, const Field<Real>& p, Field<Real>& out) {
  load(x, v);
  system_.for_each_part([&](auto& part, const Level& level) {
    if (part.p.size() == 0) part.p = Field<Real>(part.system->size());
    copy_level(p, level, part.p);
    part.system->tangents()->product(t, part.state.x, part.state.v, sum, part.p, part.a);
    copy_level(level, part.a, out);
  });
  if (!system_.forces_) return;
  system_.forces_->for_each_stiffness(
      [&](std::span<const ContactForces::Carrier> carriers, const Eigen::Matrix3d& block) {
        Vec3 moved = Vec3::Zero();
        for (const auto& carrier : carriers) moved += carrier.weight * p.at(site_of(carrier));
        const Vec3 given = sum.stiffness * block * moved;
        for (const auto& carrier : carriers)
          out.set(site_of(carrier), out.at(site_of(carrier)) + carrier.weight * given);
      });
}

template <class Real>
void BodiesTangents<Real>::diagonal(double t, const Field<Real>& x, const Field<Real>& v,
                                    const TangentCoefficients& sum, std::vector<Eigen::Matrix3d>& blocks) {
  load(x, v);
  blocks.clear();
  std::vector<std::size_t> first;
  std::vector<Eigen::Matrix3d> of_body;
  for (const auto& part : system_.parts_) {
    first.push_back(blocks.size());
    part->system->tangents()->diagonal(t, part->state.x, part->state.v, sum, of_body);
    blocks.insert(blocks.end(), of_body.begin(), of_body.end());
  }
  if (!system_.forces_) return;
  system_.forces_->for_each_stiffness(
      [&](std::span<const ContactForces::Carrier> carriers, const Eigen::Matrix3d& block) {
        for (const auto& [body, site, weight] : carriers)
          blocks[first[std::size_t(body)] +
                 std::size_t(system_.levels_[std::size_t(body)].body.particle(site))] +=
              sum.stiffness * weight * weight * block;
      });
}

template class BodiesTangents<float>;
template class BodiesTangents<double>;

}  // namespace mss
