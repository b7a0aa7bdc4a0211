// Exports that are read again, mss's own methods judged like other programs, and files of numbers.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.hpp"
#include "experiments/harness/number_file.hpp"
#include "experiments/io/output.hpp"
#include "experiments/peer/report.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::peer {
namespace {

namespace fs = std::filesystem;

Exchange exported(const Scene& scene) {
  Exchange exchange = make_exchange(scene);
  Progress progress;
  add_reference(exchange, progress);
  return exchange;
}

Scene turning_cube(const std::string& solve) {
  return parse_scene(
      "[body]\ncells = [2, 2, 2]\ncell_size = 0.1\n[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.4\n"
      "[start]\nvelocity = [1, 0, 0]\nangular_velocity = [0, 0, 5]\n[solve]\nduration = 0.25\n" +
      solve);
}

TEST(Peer, JudgesItsOwnMethods) {
  const Exchange exchange = exported(turning_cube("integrator = \"velocity_verlet\"\n"));
  EXPECT_EQ(exchange.times.size(), 16U);
  const Judge judge(exchange);
  EXPECT_EQ(judge.scale().takes_energy, "");
  const Result result = run_own(exchange.scene, exchange, Progress());
  const Score score = judge.score(result);
  EXPECT_EQ(score.status, "ok");
  EXPECT_LT(score.error, 0.01);
  EXPECT_GT(score.error, 1e-6);
  EXPECT_LT(score.momentum_drift, 1e-12);
  EXPECT_LT(score.spin_drift, 1e-7);  // rk4 keeps it to some 1e-9
  EXPECT_LT(score.energy_gain + score.energy_loss, 0.01);
  EXPECT_GT(score.volume_high, 1.0005);  // it bulges
  EXPECT_GT(result.cpu_seconds, 0);
}

// Far above the limit it blows up, which is no fault of the samples.
TEST(Peer, TellsMethodsThatBlowUp) {
  const Exchange exchange = exported(turning_cube("integrator = \"verlet\"\n"));
  const Judge judge(exchange);
  Scene fast = exchange.scene;
  fast.solve.dt = exchange.spacing;
  const Score score = judge.score(run_own(fast, exchange, Progress()));
  EXPECT_TRUE(score.unstable);
  EXPECT_FALSE(score.stable);
  fast.solve.dt = exchange.spacing / 10.5;  // stable, but its steps do not meet samples
  const Score beside = judge.score(run_own(fast, exchange, Progress()));
  EXPECT_TRUE(beside.status.starts_with("samples are ")) << beside.status;
  EXPECT_FALSE(beside.stable || beside.unstable);
}

// Velocities that a program leaves out are differences of samples, by which a rigid rotation keeps its spin.
TEST(Peer, TakesDifferencesForVelocities) {
  const Exchange exchange = exported(turning_cube("integrator = \"rk4\"\n"));
  const Judge judge(exchange);
  Result result = run_own(exchange.scene, exchange, Progress());
  result.has_velocities = false;
  const Score score = judge.score(result);
  EXPECT_LT(score.momentum_drift, 1e-9);
  EXPECT_LT(score.spin_drift, 1e-3);
  EXPECT_LT(score.energy_gain, 1e-2);
}

// The folder of an export can be moved: what the scene names is in it.
TEST(Peer, ReadsExportsThatWereMoved) {
  const TemporaryDirectory directory;
  for (const char* name : {"voxel_creature", "mesh_bar"}) {
    Scene scene = load_scene(scene_file(name), {"solve.duration=0.04"});
    scene.environment.contact_surface = nullptr;
    const Exchange exchange = exported(scene);
    const fs::path made = directory.path() / "made", moved = directory.path() / "moved";
    write_export(exchange, made);
    fs::remove_all(moved);
    fs::rename(made, moved);
    const Exchange again = read_export(moved);
    EXPECT_EQ(again.scene.name, name);
    EXPECT_EQ(again.times, exchange.times);
    ASSERT_EQ(again.body->sites(), exchange.body->sites());
    ASSERT_EQ(again.reference.size(), 3U);
    for (const std::ptrdiff_t site : again.body->sites()) {
      EXPECT_EQ(again.body->mass(site), exchange.body->mass(site));
      EXPECT_EQ(again.reference.back().x.at(site), exchange.reference.back().x.at(site));
      EXPECT_EQ(again.reference.back().v.at(site), exchange.reference.back().v.at(site));
    }
  }
}

TEST(Peer, RefusesReferencesOfOtherBodies) {
  const TemporaryDirectory directory;
  write_export(exported(turning_cube("")), directory.path());
  const fs::path reference = directory.path() / "reference.csv";
  const std::string text = read_file(reference);
  write_atomically(reference, text.substr(0, text.rfind('\n', text.size() - 2) + 1));
  try {
    read_export(directory.path());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("has 431 rows, and 27 particles at 16 times make 432"),
              std::string::npos)
        << error.what();
  }
}

// A body that stays where it is has no error relative to its motion.
TEST(Peer, RefusesScenesWithoutMotion) {
  const Exchange exchange = exported(parse_scene(
      "[body]\ncells = [1, 1, 1]\ncell_size = 0.1\n[material]\ndensity = 1000\nyoung = 1e5\npoisson = "
      "0.3\n[solve]\nduration = "
      "0.1\n"));
  EXPECT_THROW(Judge{exchange}, InputError);
}

std::string refusal_of(const std::string& text, NumberFile::Rows rows = NumberFile::Rows::needed) {
  const TemporaryDirectory directory;
  const fs::path file = directory.path() / "numbers.csv";
  write_atomically(file, text);
  try {
    NumberFile(file, rows).ids("id");
  } catch (const InputError& error) {
    return std::string(error.what()).substr(file.string().size());
  }
  return "";
}

TEST(NumberFile, NamesWhatIsWrong) {
  EXPECT_EQ(refusal_of("t, id\r\n0, 1\r\n\r\n1e-3, 2\n"), "");
  EXPECT_EQ(refusal_of(""), " has no rows");
  EXPECT_EQ(refusal_of("id\n"), " has no rows");
  EXPECT_EQ(refusal_of("id\n", NumberFile::Rows::may_be_none), "");
  EXPECT_EQ(refusal_of("", NumberFile::Rows::may_be_none), " has no rows");
  EXPECT_EQ(refusal_of("t\n1\n"), ":1: column id is missing; there are t");
  EXPECT_EQ(refusal_of("id,id\n1,1\n"), ":1: column id is there twice");
  EXPECT_EQ(refusal_of("id,t\n1\n"), ":2: column t has no number");
  EXPECT_EQ(refusal_of("id,t\n1,2,3\n"), ":2: there are more cells than the 2 of the header");
  EXPECT_EQ(refusal_of("id,t\n1,\n"), ":2: t = '' is not a number");
  EXPECT_EQ(refusal_of("id\n1\n-1\n"), ":3: id = -1 is not a whole number of at least 0");
  EXPECT_EQ(refusal_of("id\nnan\n"), ":2: id = nan is not a whole number of at least 0");
}

}  // namespace
}  // namespace mss::peer
