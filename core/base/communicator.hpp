#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace mss {

/// Planes [first, last) of a lattice.
struct PlaneRange {
  int first, last;
};

/// What connects ranks: processes, numbered from 0, that share one body, each with a slab of its planes. This
/// class is of a process alone, which has all of them; another one connects several
/// (experiments/cli/mpi_ranks.cpp).
///
/// All functions but the first ones are collective: every rank must call them in the same order.
class Communicator {
 public:
  using Bytes = std::span<std::byte>;
  using ConstBytes = std::span<const std::byte>;

  Communicator() = default;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;
  virtual ~Communicator() = default;

  /// A process alone.
  static const Communicator& alone() {
    static const Communicator ranks;
    return ranks;
  }

  virtual int rank() const { return 0; }
  virtual int count() const { return 1; }
  bool are_several() const { return count() > 1; }
  bool is_lowest() const { return rank() == 0; }
  bool is_highest() const { return rank() + 1 == count(); }

  /// The planes of this rank, of as many: the slabs are as equal as whole planes can be.
  PlaneRange share_of(int planes) const {
    const auto bound = [&](int r) { return int(std::int64_t(planes) * r / count()); };
    return {bound(rank()), bound(rank() + 1)};
  }

  /// Sends to the ranks below and above and receives as much from each. The lowest rank ignores what is
  /// below, the highest what is above.
  virtual void exchange(ConstBytes /*to_below*/, Bytes /*from_below*/, ConstBytes /*to_above*/,
                        Bytes /*from_above*/) const {}
  /// One message from one rank to another one; both call it, and others may.
  virtual void pass(int /*from*/, int /*to*/, Bytes /*data*/) const {}
  /// Every rank gets what rank `from` has.
  virtual void broadcast(int /*from*/, Bytes /*data*/) const {}
  /// The largest of all ranks' numbers.
  virtual double largest(double number) const { return number; }

  /// Replaces numbers by their sums over all ranks, added from the lowest up.
  virtual void sum(std::span<double> /*numbers*/) const {}
  double sum(double number) const {
    sum(std::span(&number, 1));
    return number;
  }

  bool all(bool here) const { return largest(here ? 0 : 1) == 0; }

  /// Runs add() on one rank after the other, from the lowest planes up; each goes on with the `sums` of the
  /// one below, and at the end all have those of the last. So sums over particles or cells have the bits of a
  /// process alone. `Sums` is a number, a struct of numbers, or something with contiguous numbers: data(),
  /// size().
  template <class Sums, class Add>
  void add_in_order(Sums& sums, Add&& add) const {
    const Bytes bytes = bytes_of(sums);
    if (!is_lowest()) pass(rank() - 1, rank(), bytes);
    add();
    if (!is_highest()) pass(rank(), rank() + 1, bytes);
    broadcast(count() - 1, bytes);
  }

 private:
  template <class Sums>
  static Bytes bytes_of(Sums& sums) {
    if constexpr (requires { std::span(sums.data(), std::size_t(sums.size())); }) {
      return std::as_writable_bytes(std::span(sums.data(), std::size_t(sums.size())));
    } else {
      static_assert(std::is_trivially_copyable_v<Sums>);
      return std::as_writable_bytes(std::span(&sums, 1));
    }
  }
};

}  // namespace mss
