#include <fmt/format.h>
#define OMPI_SKIP_MPICXX  // the C interface alone
#include <mpi.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/launched_ranks.hpp"

namespace mss::cli {

namespace {

using Seconds = std::chrono::duration<double>;

/// Waits for messages. If the ranks are being ended, and none comes, another one has been lost: this one ends
/// too. It would otherwise wait for ever, since its launcher only knows its guard.
template <std::size_t count>
void finish(std::array<MPI_Request, count>& requests) {
  constexpr Seconds patience{2};  // of ranks told to end at about the same time
  constexpr int looks = 1000;     // without a look at the clock
  std::chrono::steady_clock::time_point since{};
  for (int done = 0, look = 0; done == 0; ++look) {
    MPI_Testall(int(count), requests.data(), &done, MPI_STATUSES_IGNORE);
    if (done != 0 || look % looks != 0 || !told_to_end()) continue;
    const auto now = std::chrono::steady_clock::now();
    if (since == std::chrono::steady_clock::time_point{}) since = now;
    if (now - since > patience) _exit(exit_simulation_failed);
  }
}

class MpiCommunicator final : public ConnectedCommunicator {
 public:
  MpiCommunicator() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    if (count_ != launch().count)
      throw InputError(
          fmt::format("{} processes were started, of which MPI connects {}: the launcher is of another MPI "
                      "than mss was built with; start it with that one's mpirun",
                      launch().count, count_));
  }

  int rank() const override { return rank_; }
  int count() const override { return count_; }

  void exchange(ConstBytes to_below, Bytes from_below, ConstBytes to_above, Bytes from_above) const override {
    std::array<MPI_Request, 4> requests{MPI_REQUEST_NULL, MPI_REQUEST_NULL, MPI_REQUEST_NULL,
                                        MPI_REQUEST_NULL};
    if (!is_lowest()) receive(from_below, rank_ - 1, requests[0]);
    if (!is_highest()) receive(from_above, rank_ + 1, requests[1]);
    if (!is_lowest()) send(to_below, rank_ - 1, requests[2]);
    if (!is_highest()) send(to_above, rank_ + 1, requests[3]);
    finish(requests);
    halo_bytes_ +=
        std::int64_t(is_lowest() ? 0 : to_below.size()) + std::int64_t(is_highest() ? 0 : to_above.size());
    ++exchanges_;
  }

  void pass(int from, int to, Bytes data) const override {
    std::array<MPI_Request, 1> request{MPI_REQUEST_NULL};
    if (rank_ == from) send(data, to, request[0]);
    if (rank_ == to) receive(data, from, request[0]);
    finish(request);
  }

  void broadcast(int from, Bytes data) const override {
    std::array<MPI_Request, 1> request{};
    MPI_Ibcast(data.data(), int(data.size()), MPI_BYTE, from, MPI_COMM_WORLD, request.data());
    finish(request);
  }

  double largest(double number) const override {
    double all = 0;
    std::array<MPI_Request, 1> request{};
    MPI_Iallreduce(&number, &all, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD, request.data());
    finish(request);
    return all;
  }

  void sum(std::span<double> numbers) const override {
    std::vector<double> all(numbers.size() * std::size_t(count_));
    std::array<MPI_Request, 1> request{};
    const int count = int(numbers.size());
    MPI_Iallgather(numbers.data(), count, MPI_DOUBLE, all.data(), count, MPI_DOUBLE, MPI_COMM_WORLD,
                   request.data());
    finish(request);
    std::fill(numbers.begin(), numbers.end(), 0.0);
    for (std::size_t i = 0; i < all.size(); ++i) numbers[i % numbers.size()] += all[i];
  }

  void leave() override {
    largest(0);                          // waits for all
    if (!told_to_end()) MPI_Finalize();  // it would wait for a launcher that may have ended
  }

  std::int64_t exchanges() const override { return exchanges_; }
  Costs costs() const override {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    Costs all;
    for (int rank = 0; rank < count_; ++rank) {
      const auto of_rank = [&](std::int64_t own) {
        return std::int64_t(largest(rank == rank_ ? double(own) : 0));
      };
      all.halo_bytes.push_back(of_rank(halo_bytes_));
      all.peak_memory.push_back(of_rank(usage.ru_maxrss * 1024));
    }
    return all;
  }

 private:
  static void send(ConstBytes data, int to, MPI_Request& request) {
    MPI_Isend(data.data(), int(data.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD, &request);
  }
  static void receive(Bytes data, int from, MPI_Request& request) {
    MPI_Irecv(data.data(), int(data.size()), MPI_BYTE, from, 0, MPI_COMM_WORLD, &request);
  }

  int rank_ = 0, count_ = 1;
  mutable std::int64_t halo_bytes_ = 0, exchanges_ = 0;
};

}  // namespace

std::unique_ptr<ConnectedCommunicator> connect_ranks(const std::string& kept) {
  if (launch().count == 1) return std::make_unique<ConnectedCommunicator>();
  work_under_guard(kept);
  return std::make_unique<MpiCommunicator>();
}

}  // namespace mss::cli
