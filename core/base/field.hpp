#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>

namespace mss {

using Vec3 = Eigen::Vector3d;

/// Array over lattice sites, aligned to a cache line.
template <class Real>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::ptrdiff_t size) : size_(size), data_(allocate(size)) { fill(Real(0)); }
  AlignedArray(const AlignedArray& other) : size_(other.size_), data_(allocate(other.size_)) {
    std::copy_n(other.data(), size_, data());
  }
  AlignedArray(AlignedArray&& other) noexcept
      : size_(std::exchange(other.size_, 0)), data_(std::move(other.data_)) {}
  AlignedArray& operator=(const AlignedArray& other) {
    if (this == &other) return *this;
    if (size_ != other.size_) *this = AlignedArray(other.size_);
    std::copy_n(other.data(), size_, data());
    return *this;
  }
  AlignedArray& operator=(AlignedArray&& other) noexcept {
    size_ = std::exchange(other.size_, 0);
    data_ = std::move(other.data_);
    return *this;
  }
  ~AlignedArray() = default;

  Real* data() { return data_.get(); }
  const Real* data() const { return data_.get(); }
  /// See Field::ghosts().
  Real* storage() const { return data_.get(); }
  std::ptrdiff_t size() const { return size_; }
  Real& operator[](std::ptrdiff_t i) { return data_.get()[i]; }
  const Real& operator[](std::ptrdiff_t i) const { return data_.get()[i]; }
  void fill(Real value) { std::fill_n(data_.get(), size_, value); }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Free {
    void operator()(Real* p) const { ::operator delete(p, alignment); }
  };
  using Block = std::unique_ptr<Real, Free>;
  static Block allocate(std::ptrdiff_t size) {
    return Block(
        static_cast<Real*>(::operator new(static_cast<std::size_t>(size) * sizeof(Real), alignment)));
  }

  std::ptrdiff_t size_ = 0;
  Block data_;
};

/// A vector at every lattice site: three coordinates, each contiguous (structure of arrays).
/// Sites without a particle carry values too; they have no mass and no springs, so they change nothing.
template <class Real>
class Field {
 public:
  Field() = default;
  explicit Field(std::ptrdiff_t sites) : stride_(padded(sites)), data_(3 * stride_) {}

  /// Numbers held, padding included; 0 for a field never given a size.
  std::ptrdiff_t size() const { return data_.size(); }

  Real* axis(int a) { return data_.data() + a * stride_; }
  /// For ghost planes (springs/halo.hpp): what is in them is no part of the field, so that who exchanges them
  /// may overwrite them in the fields of others.
  Real* ghosts(int a) const { return data_.storage() + a * stride_; }
  const Real* axis(int a) const { return data_.data() + a * stride_; }

  Vec3 at(std::ptrdiff_t site) const {
    return {double(axis(0)[site]), double(axis(1)[site]), double(axis(2)[site])};
  }
  void set(std::ptrdiff_t site, const Vec3& value) {
    for (int a = 0; a < 3; ++a) axis(a)[site] = static_cast<Real>(value[a]);
  }

  /// All coordinates of all sites as one Eigen array, for whole-field arithmetic.
  auto array() { return Eigen::Map<Eigen::Array<Real, Eigen::Dynamic, 1>>(data_.data(), data_.size()); }
  auto array() const {
    return Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>(data_.data(), data_.size());
  }

 private:
  /// Keeps the three coordinate streams off the same cache sets: equal low address bits would evict each
  /// other.
  static std::ptrdiff_t padded(std::ptrdiff_t sites) {
    constexpr std::ptrdiff_t page = 4096 / sizeof(Real);
    constexpr std::ptrdiff_t line = 64 / sizeof(Real);
    const std::ptrdiff_t whole = (sites + line - 1) / line * line;
    if (whole < page) return whole;
    return (whole + page - 1) / page * page + 11 * line;
  }

  std::ptrdiff_t stride_ = 0;
  AlignedArray<Real> data_;
};

}  // namespace mss
