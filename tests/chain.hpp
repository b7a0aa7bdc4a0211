#pragma once

#include <cmath>
#include <numbers>

#include "tests/oscillator.hpp"

namespace mss::testing {

/// N particles on a line between two walls, joined by N + 1 equal springs whose dampers make C = beta K.
/// Modes are known: w_j = 2 sqrt(k/m) sin(j pi / (2 (N + 1))), damped by beta w_j^2. All three axes move
/// alike.
class Chain final : public System<double> {
 public:
  Chain(int particles, double beta) : beta_(beta) {
    for (int i = 0; i < particles; ++i) sites_.push_back(i);
  }

  double omega(int mode) const {
    return 2 * std::sqrt(stiffness_ / mass_) *
           std::sin(mode * std::numbers::pi / (2 * double(sites_.size() + 1)));
  }
  double largest_omega() const { return omega(int(sites_.size())); }

  std::ptrdiff_t size() const override { return std::ptrdiff_t(sites_.size()); }
  const std::vector<std::ptrdiff_t>& particles() const override { return sites_; }
  double mass(std::ptrdiff_t) const override { return mass_; }
  void force(double, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    for (int axis = 0; axis < 3; ++axis)
      for (const std::ptrdiff_t i : sites_)
        f.axis(axis)[i] = -stiffness_ * (bend(x, axis, i) + beta_ * bend(v, axis, i));
  }
  Tangents<double>* tangents() override { return &tangents_; }
  DiscreteGradient<double>* discrete_gradient() override { return &discrete_gradient_; }

 private:
  /// 2 y_i - y_{i-1} - y_{i+1}, with walls at 0.
  double bend(const Field<double>& y, int axis, std::ptrdiff_t i) const {
    const double* p = y.axis(axis);
    return 2 * p[i] - (i > 0 ? p[i - 1] : 0) - (i + 1 < size() ? p[i + 1] : 0);
  }
  double spring(const TangentCoefficients& sum) const {
    return stiffness_ * (sum.stiffness + beta_ * sum.damping);
  }

  class ChainTangents final : public Tangents<double> {
   public:
    explicit ChainTangents(const Chain& chain) : chain_(chain) {}
    const std::vector<FreeDof>& unknowns() override {
      if (unknowns_.empty()) unknowns_ = unknowns_of(chain_);
      return unknowns_;
    }
    SparseMatrix pattern() override {
      const int size = int(unknowns().size());
      std::vector<Eigen::Triplet<double>> places;
      for (int i = 0; i < size; ++i)
        for (const int j : {i - 3, i, i + 3})
          if (j >= 0 && j < size) places.emplace_back(i, j, 0.0);
      SparseMatrix matrix(size, size);
      matrix.setFromTriplets(places.begin(), places.end());
      return matrix;
    }
    void values(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                SparseMatrix& matrix) override {
      for (int row = 0; row < matrix.outerSize(); ++row)
        for (SparseMatrix::InnerIterator entry(matrix, row); entry; ++entry)
          entry.valueRef() =
              entry.col() == row ? chain_.mass_ * sum.mass + 2 * chain_.spring(sum) : -chain_.spring(sum);
    }
    void product(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                 const Field<double>& p, Field<double>& out) override {
      for (int axis = 0; axis < 3; ++axis)
        for (const std::ptrdiff_t i : chain_.sites_)
          out.axis(axis)[i] =
              chain_.mass_ * sum.mass * p.axis(axis)[i] + chain_.spring(sum) * chain_.bend(p, axis, i);
    }
    void diagonal(double, const Field<double>&, const Field<double>&, const TangentCoefficients& sum,
                  std::vector<Eigen::Matrix3d>& blocks) override {
      blocks.assign(chain_.sites_.size(),
                    (chain_.mass_ * sum.mass + 2 * chain_.spring(sum)) * Eigen::Matrix3d::Identity());
    }

   private:
    const Chain& chain_;
    std::vector<FreeDof> unknowns_;
  };

  double beta_;
  double stiffness_ = 40;
  double mass_ = 0.3;
  std::vector<std::ptrdiff_t> sites_;
  ChainTangents tangents_{*this};
  LinearDiscreteGradient discrete_gradient_;
};

}  // namespace mss::testing
