// Ranks that share a body, here as threads: every particle and measure has the bits of a body in one process.
#include <gtest/gtest.h>

#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "core/springs/halo.hpp"
#include "integrators/integrator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// Messages under way, by who sends and who gets them.
class Post {
 public:
  void send(int from, int to, Communicator::ConstBytes data) {
    const std::lock_guard lock(mutex_);
    waiting_[{from, to}].emplace_back(data.begin(), data.end());
    arrived_.notify_all();
  }
  void receive(int from, int to, Communicator::Bytes data) {
    std::unique_lock lock(mutex_);
    auto& messages = waiting_[{from, to}];
    arrived_.wait(lock, [&] { return !messages.empty(); });
    ASSERT_EQ(messages.front().size(), data.size());
    std::copy(messages.front().begin(), messages.front().end(), data.begin());
    messages.pop_front();
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<std::pair<int, int>, std::deque<std::vector<std::byte>>> waiting_;
};

class ThreadCommunicator final : public Communicator {
 public:
  ThreadCommunicator(Post& post, int rank, int count) : post_(post), rank_(rank), count_(count) {}

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  void exchange(ConstBytes to_below, Bytes from_below, ConstBytes to_above, Bytes from_above) const override {
    if (!is_lowest()) post_.send(rank_, rank_ - 1, to_below);
    if (!is_highest()) post_.send(rank_, rank_ + 1, to_above);
    if (!is_lowest()) post_.receive(rank_ - 1, rank_, from_below);
    if (!is_highest()) post_.receive(rank_ + 1, rank_, from_above);
  }
  void pass(int from, int to, Bytes data) const override {
    if (rank_ == from) post_.send(from, to, data);
    if (rank_ == to) post_.receive(from, to, data);
  }
  void broadcast(int from, Bytes data) const override {
    for (int to = 0; to < count_; ++to)
      if (to != from) pass(from, to, data);
  }
  void sum(std::span<double> numbers) const override {
    std::vector<double> sums(numbers.size(), 0.0);
    const std::span<double> all(sums);
    if (!is_lowest()) pass(rank_ - 1, rank_, std::as_writable_bytes(all));
    for (std::size_t i = 0; i < numbers.size(); ++i) sums[i] += numbers[i];
    if (!is_highest()) pass(rank_, rank_ + 1, std::as_writable_bytes(all));
    broadcast(count_ - 1, std::as_writable_bytes(all));
    std::copy(sums.begin(), sums.end(), numbers.begin());
  }
  double largest(double number) const override {
    const Bytes bytes = std::as_writable_bytes(std::span(&number, 1));
    for (int from = 0; from < count_; ++from) {
      double other = number;
      if (from != 0) pass(from, 0, std::as_writable_bytes(std::span(&other, 1)));
      number = std::max(number, other);
    }
    broadcast(0, bytes);
    return number;
  }

 private:
  Post& post_;
  int rank_, count_;
};

/// What a rank has of the whole at the end.
struct RankPart {
  std::vector<Vec3> rest{}, x{}, v{};
  std::vector<double> mass{};
  Measures measures{};
  SpectralBound bound{};
  double total_mass = 0;
  std::size_t springs = 0;
};

struct RanksCase {
  BodyConfig body;
  Environment environment;
  std::string method;
};

template <class Real>
RankPart simulate_part(const RanksCase& c, const Communicator& ranks) {
  const Body body(c.body, ranks);
  SpringSystem<Real> system(body, c.environment, {.threads = 1 + ranks.rank() % 2});
  State<Real> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 rest = body.rest_position(site);
    state.v.set(site, Vec3(std::sin(5 * rest[1]), std::cos(7 * rest[2]), std::sin(3 * rest[0]) - 1));
  }
  system.constrain(0, state.x, state.v);
  system.give({.box = {Vec3::Constant(-9), Vec3::Constant(9)}, .impulse = {1, 2, 3}}, state.v);
  Work work;
  const auto method = find_integrator(c.method).make<Real>({.dt = 2e-4, .linear_solver = "matrix_free"});
  EXPECT_EQ(method->advance(system, state, 0.02, work), Status::ok);
  RankPart part{.measures = measure(system, state),
                .bound = system.spectral_bound(),
                .total_mass = body.total_mass(),
                .springs = body.spring_count()};
  for (const std::ptrdiff_t site : body.sites()) {
    part.rest.push_back(body.rest_position(site));
    part.x.push_back(state.x.at(site));
    part.v.push_back(state.v.at(site));
    part.mass.push_back(body.mass(site));
  }
  return part;
}

template <class Real>
std::vector<RankPart> simulate_in(int count, const RanksCase& c) {
  std::vector<RankPart> parts(static_cast<std::size_t>(count));
  Post post;
  std::vector<std::thread> threads;
  threads.reserve(std::size_t(count));
  for (int rank = 0; rank < count; ++rank)
    threads.emplace_back([&, rank] {
      parts[std::size_t(rank)] = simulate_part<Real>(c, ThreadCommunicator(post, rank, count));
    });
  for (std::thread& thread : threads) thread.join();
  return parts;
}

/// Particles one after the other, from rank to rank.
template <class Real>
void expect_same_bits(const RanksCase& c) {
  const RankPart whole = simulate_part<Real>(c, Communicator::alone());
  for (int count = 2; count <= c.body.voxels.nz() + 1; count += 2) {
    std::size_t id = 0;
    for (const RankPart& part : simulate_in<Real>(count, c)) {
      for (std::size_t p = 0; p < part.x.size(); ++p, ++id) {
        ASSERT_LT(id, whole.x.size());
        ASSERT_EQ(part.rest[p], whole.rest[id]) << count << " ranks";
        ASSERT_EQ(part.mass[p], whole.mass[id]) << count << " ranks";
        ASSERT_EQ(part.x[p], whole.x[id]) << count << " ranks, " << c.method;
        ASSERT_EQ(part.v[p], whole.v[id]) << count << " ranks, " << c.method;
      }
      for (const MeasureColumn& column : measure_columns)
        EXPECT_EQ(column.value(part.measures), column.value(whole.measures)) << column.name << ", " << count;
      EXPECT_EQ(part.bound.omega, whole.bound.omega);
      EXPECT_EQ(part.bound.damping, whole.bound.damping);
      EXPECT_EQ(part.total_mass, whole.total_mass);
      EXPECT_EQ(part.springs, whole.springs);
    }
    EXPECT_EQ(id, whole.x.size()) << count << " ranks";
  }
}

std::vector<RanksCase> cases() {
  const auto shapes = testing::test_shapes();
  std::vector<RanksCase> all;
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty})
    for (const std::size_t from_the_end : {1U, 2U, 6U}) {
      RanksCase c{testing::test_config(shapes[shapes.size() - from_the_end].voxels),
                  {.gravity = Vec3(0, 0.5, -9.81)},
                  law == ContactLaw::impulse ? "velocity_verlet" : "semi_implicit_euler"};
      const Vec3 low = c.body.origin;
      c.body.weights = {{{low, low + Vec3(0.3, 9, 9)}, 50}};
      c.environment.holds = {{.box = {low, low + Vec3(0, 9, 0.9)}, .velocity = Vec3(-0.2, 0, 0)}};
      c.environment.loads = {{{low, low + Vec3(9, 0, 9)}, Vec3(1, -2, 3)}};
      c.environment.planes = {
          {.point = low + Vec3(0, 0, 0.02), .normal = Vec3(0.1, 0, 1).normalized(), .contact = law}};
      all.push_back(c);
    }
  return all;
}

TEST(Ranks, HaveTheBitsOfOneProcess) {
  for (const RanksCase& c : cases()) {
    expect_same_bits<double>(c);
    expect_same_bits<float>(c);
  }
}

TEST(Ranks, OfPartsHaveTheBitsOfOneProcess) {
  RanksCase c = cases().front();
  c.body.weights.clear();
  testing::add_parts(c.body);
  const VoxelGrid& voxels = c.body.voxels;
  const std::size_t cells = std::size_t(voxels.nx()) * std::size_t(voxels.ny()) * std::size_t(voxels.nz());
  for (int part = 0; part < 3; ++part) c.body.contents.push_back({{part, CellFill::even(1)}});
  for (std::size_t cell = 0; cell < cells; ++cell) c.body.content_of.push_back(std::uint32_t(cell * 7 % 3));
  expect_same_bits<double>(c);
}

/// Conjugate gradients add up their products rank by rank, which rounds otherwise.
TEST(Ranks, OfImplicitMethodsAgreeToRounding) {
  for (const std::string method :
       {"backward_euler", "backward_euler_linear", "generalized_alpha", "tr_bdf2"}) {
    RanksCase c = cases().back();
    c.method = method;
    const RankPart whole = simulate_part<double>(c, Communicator::alone());
    for (const int count : {2, 3}) {
      std::size_t id = 0;
      for (const RankPart& part : simulate_in<double>(count, c))
        for (std::size_t p = 0; p < part.x.size(); ++p, ++id) {
          ASSERT_LT((part.x[p] - whole.x[id]).norm(), 1e-11) << method << ", " << count << " ranks";
          ASSERT_LT((part.v[p] - whole.v[id]).norm(), 1e-8) << method << ", " << count << " ranks";
        }
      EXPECT_EQ(id, whole.x.size());
    }
  }
}

TEST(Ranks, ExchangeTwoVectorsOfEveryParticleOfAPlane) {
  const Body body(testing::test_config(VoxelGrid::box(200, 200, 1)));
  EXPECT_EQ(Halo<double>::numbers(body.lattice()) * std::ptrdiff_t(sizeof(double)), 1'939'248);
}

TEST(Ranks, AreAtMostAsManyAsPlanes) {
  Post post;
  EXPECT_THROW(Body(testing::test_config(VoxelGrid::box(2, 2, 1)), ThreadCommunicator(post, 2, 3)),
               InputError);
}

}  // namespace
}  // namespace mss
