// Pictures that `mss view --shot` and `--record` make, from outside. Needs a screen: see with_display.sh.
#include <gtest/gtest.h>
#include <png.h>
#include <webp/demux.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <vector>

#include "core/mesh/shapes.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/view/colour_map.hpp"

namespace mss::view {
namespace {

namespace fs = std::filesystem;

/// A picture as it is on disk.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  explicit Picture(const fs::path& file) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0) << file;
    image.format = PNG_FORMAT_RGB;
    pixels.resize(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0) << file;
    width = int(image.width);
    height = int(image.height);
  }

  Colour at(int x, int y) const {
    const std::uint8_t* p = &pixels[3 * std::size_t(y * width + x)];
    return {float(p[0]) / 255, float(p[1]) / 255, float(p[2]) / 255};
  }
};

double distance(const Colour& a, const Colour& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// A picture of a scene, in a directory of the test's own.
class Shot : public ::testing::Test {
 protected:
  Shot() { fs::create_directories(root_); }
  ~Shot() override { fs::remove_all(root_); }
  Shot(const Shot&) = delete;
  Shot& operator=(const Shot&) = delete;

  fs::path file(const std::string& name) const { return root_ / name; }
  ProgramRun take(const std::string& name, std::vector<std::string> more) const {
    std::vector<std::string> arguments{MSS_PROGRAM, "view", "--shot", file(name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

 private:
  fs::path root_ =
      fs::path(::testing::TempDir()) /
      ("mss_shot_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

/// A table of lines alone cannot be told from the ground.
TEST_F(Shot, ShowsObstaclesAsFaces) {
  std::ofstream(file("table.toml"))
      << "[body]\ncells = [2, 2, 2]\ncell_size = 0.05\norigin = [-0.05, -0.05, 0.1]\n"
         "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n"
         "[[obstacle]]\nshape = \"box\"\nsize = [0.8, 0.8, 0.1]\ncentre = [0, 0, 0]\n"
         "[solve]\nduration = 1\n";
  const ProgramRun run = take("a.png", {file("table.toml").string(), "--plain"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const Picture picture(file("a.png"));
  int top = 0;  // pixels of its upper face
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (distance(picture.at(x, y), {0.826F, 0.826F, 0.845F}) < 0.02) ++top;
  EXPECT_GT(top, picture.width * picture.height / 20);
}

TEST_F(Shot, ShowsBodyPanelAndColourBar) {
  const ProgramRun run = take("a.png", {"voxel_creature", "--frames", "30"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const Picture picture(file("a.png"));
  ASSERT_EQ(picture.width, 1280);
  ASSERT_EQ(picture.height, 800);
  const Colour background = picture.at(330, 10);
  EXPECT_GT(distance(picture.at(750, 310), background), 0.3);  // the body, in the middle of its place
  // The colour bar from bottom to top; its frame and ticks are beside this column.
  for (const double share : {0.02, 0.25, 0.5, 0.75, 0.98})
    EXPECT_LT(distance(picture.at(1204, int(std::lround(600 - 536 * share))), map_colour(share)), 0.03)
        << share;
}

// Nothing but the body on the ground: the edges of the picture are of the ground's greys, and the body is in
// the middle.
TEST_F(Shot, IsOfTheBodyAloneIfPlain) {
  const ProgramRun run = take("a.png", {"fig5_1_twist", "--frames", "60", "--plain", "--size", "640x480"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const Picture picture(file("a.png"));
  ASSERT_EQ(picture.width, 640);
  ASSERT_EQ(picture.height, 480);
  int left = picture.width, right = 0, top = picture.height, bottom = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Colour c = picture.at(x, y);
      if (std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]}) < 0.15F) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  EXPECT_NEAR((left + right) / 2.0, 320, 10);
  EXPECT_NEAR((top + bottom) / 2.0, 240, 10);
  EXPECT_NEAR(std::max((right - left) / 640.0, (bottom - top) / 480.0), 0.85, 0.02);
}

TEST_F(Shot, IsTheSameEveryTimeAndMovesOn) {
  for (const char* name : {"a.png", "b.png"})
    ASSERT_EQ(take(name, {"fig5_1_twist", "--frames", "20", "--size", "800x500"}).exit_status, 0);
  ASSERT_EQ(take("c.png", {"fig5_1_twist", "--size", "800x500"}).exit_status, 0);
  EXPECT_EQ(Picture(file("a.png")).width, 800);
  EXPECT_EQ(read_file(file("a.png")), read_file(file("b.png")));
  EXPECT_NE(Picture(file("a.png")).pixels, Picture(file("c.png")).pixels);
}

// A ball of few cells is drawn round: its outline fills pi / 4 of the square around it.
TEST_F(Shot, ShowsTheSurfaceOfAMesh) {
  write_obj(file("ball.obj"), icosphere(0.5, 8));
  std::ofstream(file("ball.toml")) << "[body]\nmesh = \"ball.obj\"\ncells_across = 4\n"
                                      "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n"
                                      "[solve]\nduration = 1\n";
  const ProgramRun run = take("a.png", {file("ball.toml").string(), "--frames", "1"});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const Picture picture(file("a.png"));
  int area = 0, left = picture.width, right = 0, top = picture.height, bottom = 0;
  for (int y = 0; y < 600; ++y)
    for (int x = 330; x < 1180; ++x) {
      const Colour c = picture.at(x, y);
      if (std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]}) < 0.15F) continue;  // grey: the ground
      ++area;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  ASSERT_GT(area, 10000);
  EXPECT_NEAR(double(right - left) / (bottom - top), 1, 0.05);  // perspective
  EXPECT_NEAR(area / double((right - left + 1) * (bottom - top + 1)), 0.7854, 0.012);
}

TEST_F(Shot, IsTakenOfAFailureToo) {
  const ProgramRun run = take("a.png", {"fig5_1_twist", "--frames", "600", "--set", "solve.dt=0.02"});
  EXPECT_EQ(run.exit_status, 3);
  EXPECT_NE(run.output.find("the simulation failed: non_finite"), std::string::npos) << run.output;
  EXPECT_EQ(Picture(file("a.png")).height, 800);
}

TEST_F(Shot, GoesNowhereIfItCannotBeWritten) {
  const ProgramRun run = run_program({MSS_PROGRAM, "view", "cantilever", "--shot", "/dev/null/a.png"});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_NE(run.output.find("/dev/null cannot be written"), std::string::npos) << run.output;
}

/// Whether the device that draws can take steps, as software does.
bool says_too_old(const ProgramRun& run) {
  return run.exit_status == 2 && run.output.find("OpenGL 4.3") != std::string::npos;
}

// The device draws where it has the body, the processor what it has computed: pixels differ where an edge is
// on the border of another pixel by rounding.
TEST_F(Shot, IsTheSameOfABodyOnADevice) {
  write_obj(file("ball.obj"), icosphere(0.5, 8));
  std::ofstream(file("ball.toml")) << "[body]\nmesh = \"ball.obj\"\ncells_across = 5\n"
                                      "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n"
                                      "[environment]\ngravity = [0, 0, -9.81]\n"
                                      "[[hold]]\nbox = [[-1, -1, -1], [1, 1, -0.3]]\n"
                                      "[solve]\nintegrator = \"semi_implicit_euler\"\nduration = 1\n";
  for (const std::string& of : {file("ball.toml").string(), std::string("voxel_creature")}) {
    for (const char* device : {"cpu", "gpu"}) {
      const ProgramRun run =
          take(std::string(device) + ".png", {of, "--frames", "12", "--plain", "--size", "800x500", "--set",
                                              std::string("solve.device='") + device + "'"});
      if (says_too_old(run)) GTEST_SKIP() << run.output;
      ASSERT_EQ(run.exit_status, 0) << run.output;
    }
    const Picture here(file("cpu.png")), there(file("gpu.png"));
    int coloured = 0, other = 0;
    for (int y = 0; y < here.height; ++y)
      for (int x = 0; x < here.width; ++x) {
        const Colour c = here.at(x, y);
        if (std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]}) > 0.15F) ++coloured;
        if (distance(c, there.at(x, y)) > 0.02) ++other;
      }
    EXPECT_GT(coloured, 20000) << of;
    EXPECT_LT(other, coloured / 1000) << of;
  }
}

TEST_F(Shot, SaysWhereADeviceIsTooOldOrAnother) {
  const std::vector<std::string> more{"view", "free_cube", "--shot", file("a.png").string(), "--set"};
  std::vector<std::string> old{"env", "MESA_GL_VERSION_OVERRIDE=3.3", MSS_PROGRAM};
  old.insert(old.end(), more.begin(), more.end());
  old.emplace_back("solve.device='gpu'");
  const ProgramRun run = run_program(old);
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_NE(run.output.find("OpenGL 4.3"), std::string::npos) << run.output;
  old.back() = "solve.device='cpu'";  // which needs no more than that
  EXPECT_EQ(run_program(old).exit_status, 0);
  const ProgramRun second = take("b.png", {"free_cube", "--set", "solve.device='gpu:0'"});
  EXPECT_EQ(second.exit_status, 2);
  EXPECT_NE(second.output.find("in a window"), std::string::npos) << second.output;
}

/// An animated WebP as it is on disk.
struct Film {
  int width = 0, height = 0, loops = -1;
  std::vector<std::vector<std::uint8_t>> frames;  ///< red, green, blue and opacity of each pixel
  std::vector<int> ends;                          ///< [ms]

  explicit Film(const fs::path& file) {
    const std::string bytes = read_file(file);
    const WebPData data{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
    const std::unique_ptr<WebPAnimDecoder, decltype(&WebPAnimDecoderDelete)> decoder(
        WebPAnimDecoderNew(&data, nullptr), WebPAnimDecoderDelete);
    WebPAnimInfo info{};
    EXPECT_TRUE(decoder && WebPAnimDecoderGetInfo(decoder.get(), &info)) << file;
    width = int(info.canvas_width);
    height = int(info.canvas_height);
    loops = int(info.loop_count);
    while (decoder && WebPAnimDecoderHasMoreFrames(decoder.get()) != 0) {
      std::uint8_t* pixels = nullptr;
      EXPECT_NE(WebPAnimDecoderGetNext(decoder.get(), &pixels, &ends.emplace_back()), 0) << file;
      frames.emplace_back(pixels, pixels + 4 * std::size_t(width * height));
    }
  }
};

/// Mean difference of a frame's colours from those of a picture [of 255].
double difference(const std::vector<std::uint8_t>& frame, const Picture& picture) {
  double sum = 0;
  for (std::size_t pixel = 0; 4 * pixel < frame.size(); ++pixel)
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::abs(int(frame[4 * pixel + c]) - int(picture.pixels[3 * pixel + c]));
  return sum / (0.75 * double(frame.size()));
}

const std::vector<std::string> falling{"free_cube", "--rate", "20", "--frames", "5", "--size", "160x120"};

/// What arguments have before others.
std::vector<std::string> recorded(const std::string& file, std::vector<std::string> more) {
  more.insert(more.begin(), {MSS_PROGRAM, "view", "--record", file});
  return more;
}

// Every frame of a WebP is the PNG of its number, as well as so few bits can say it, and no other.
TEST_F(Shot, RecordsFramesThatDiffer) {
  const ProgramRun run = run_program(recorded(file("a.webp").string(), falling));
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_NE(run.output.find("a.webp, 5 frames"), std::string::npos) << run.output;
  ASSERT_EQ(run_program(recorded(file("a.png").string(), falling)).exit_status, 0);
  const Film film(file("a.webp"));
  EXPECT_EQ(film.width, 160);
  EXPECT_EQ(film.height, 120);
  EXPECT_EQ(film.loops, 0);  // for ever
  EXPECT_EQ(film.ends, (std::vector{50, 100, 150, 200, 250}));
  ASSERT_EQ(film.frames.size(), 5U);
  for (int of = 0; of < 5; ++of) {
    std::vector<double> apart;
    for (const auto& frame : film.frames)
      apart.push_back(difference(frame, Picture(file("a_000" + std::to_string(of) + ".png"))));
    EXPECT_LT(apart[std::size_t(of)], 4) << of;
    for (int other = 0; other < 5; ++other)
      if (other != of) {
        EXPECT_GT(apart[std::size_t(other)], apart[std::size_t(of)] + 0.2) << of << " " << other;
      }
  }
  EXPECT_FALSE(fs::exists(file("a_0005.png")));
}

// The simulation that is drawn is not the one whose bodies were measured first.
TEST_F(Shot, RecordsSeveralBodies) {
  for (const char* scene : {"stack_of_three", "drum"}) {
    const ProgramRun run = run_program(
        recorded(file("a_%d.png").string(), {scene, "--frames", "3", "--rate", "4", "--size", "160x120"}));
    ASSERT_EQ(run.exit_status, 0) << run.output;
    EXPECT_NE(Picture(file("a_0.png")).pixels, Picture(file("a_2.png")).pixels) << scene;
  }
}

TEST_F(Shot, RecordsAsManyFramesAsTheSceneHas) {
  const std::vector<std::string> whole{"free_cube", "--rate", "10", "--set", "solve.duration=0.3"};
  ASSERT_EQ(run_program(recorded(file("a_%d.png").string(), whole)).exit_status, 0);
  EXPECT_EQ(Picture(file("a_3.png")).width, 480);  // 0, 0.1, 0.2 and 0.3 s
  EXPECT_EQ(Picture(file("a_0.png")).height, 360);
  EXPECT_FALSE(fs::exists(file("a_4.png")));
  ASSERT_EQ(run_program(recorded(file("frames/").string(), whole)).exit_status, 0);
  EXPECT_EQ(read_file(file("frames/frame_0003.png")), read_file(file("a_3.png")));
}

TEST_F(Shot, RecordsTheWindowWhereThereIsRoom) {
  std::vector<std::string> window = falling;
  window.back() = "800x500";
  ASSERT_EQ(run_program(recorded(file("all_%d.png").string(), window)).exit_status, 0);
  window.emplace_back("--plain");
  ASSERT_EQ(run_program(recorded(file("plain_%d.png").string(), window)).exit_status, 0);
  const Picture all(file("all_4.png")), plain(file("plain_4.png"));
  EXPECT_EQ(all.width, 800);
  EXPECT_NE(all.pixels, plain.pixels);
}

/// The mean difference of two pictures of one size [of 255].
double difference(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(int(a.pixels[i]) - int(b.pixels[i]));
  return sum / double(a.pixels.size());
}

// The reference, given back as a result, looks as the scene does.
TEST_F(Shot, RecordsWhatAnotherProgramMadeOfAScene) {
  const std::string scene = file("scene").string(), result = file("result").string();
  ASSERT_EQ(run_program(
                {MSS_PROGRAM, "peer", "export", "cantilever", "--set", "solve.duration=0.2", "--out", scene})
                .exit_status,
            0);
  fs::create_directories(result);
  fs::copy_file(scene + "/reference.csv", result + "/samples.csv");
  std::ofstream(result + "/cost.json")
      << R"({"engine": "copy", "version": "1", "step": 0.01, "iterations": null, "precision": "double",
            "wall_seconds": 0, "cpu_seconds": 0, "threads": 1})";
  const std::vector<std::string> more{"--rate", "20", "--frames", "5", "--size", "160x120"};
  const auto record = [&](const std::string& name, std::vector<std::string> what) {
    what.insert(what.end(), more.begin(), more.end());
    return run_program(recorded(file(name + "_%d.png").string(), what));
  };
  const ProgramRun run = record("shown", {scene, "--result", result});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  ASSERT_EQ(record("simulated", {scene + "/scene.toml"}).exit_status, 0);
  const Picture start(file("shown_0.png")), end(file("shown_4.png")), truth(file("simulated_4.png"));
  EXPECT_GT(difference(start, end), 1);
  EXPECT_LT(difference(end, truth), 0.1 * difference(start, end));
  // A result in which nothing moves is not simulated: every sample has the positions of the first.
  const std::string still = file("still").string();
  fs::copy(result, still);
  std::ifstream reference(scene + "/reference.csv");
  std::ofstream samples(still + "/samples.csv");
  std::map<std::string, std::string> first;  // the rest of a line, by particle
  for (std::string line; std::getline(reference, line);) {
    const std::size_t id = line.find(',') + 1, rest = line.find(',', id);
    const std::string& at = first.try_emplace(line.substr(id, rest - id), line.substr(rest)).first->second;
    samples << line.substr(0, rest) << at << "\n";
  }
  samples.close();
  ASSERT_EQ(record("still", {scene, "--result", still}).exit_status, 0);
  EXPECT_EQ(Picture(file("still_0.png")).pixels, Picture(file("still_4.png")).pixels);
  const ProgramRun set = record("a", {scene, "--result", result, "--set", "solve.dt=1e-4"});
  EXPECT_EQ(set.exit_status, 2);
  EXPECT_NE(set.output.find("without --set"), std::string::npos) << set.output;
  EXPECT_EQ(run_program({MSS_PROGRAM, "view", scene, "--result", result}).exit_status, 2);  // no picture
}

TEST_F(Shot, RecordsUntilAFailure) {
  const ProgramRun run = run_program(recorded(
      file("a.webp").string(), {"free_cube", "--frames", "600", "--rate", "50", "--set", "solve.dt=0.01"}));
  EXPECT_EQ(run.exit_status, 3);
  EXPECT_NE(run.output.find("the simulation failed: non_finite"), std::string::npos) << run.output;
  const Film film(file("a.webp"));
  ASSERT_FALSE(film.frames.empty());  // fewer than there were: what does not move is shown for longer
  EXPECT_EQ(film.ends.back() % 20, 0);
  EXPECT_NE(run.output.find(", " + std::to_string(film.ends.back() / 20) + " frames"), std::string::npos)
      << run.output;
  EXPECT_GT(film.ends.back(), 40);
  EXPECT_LT(film.ends.back(), 20 * 600);
}

// Simulating takes a hundredth of the time that drawing does.
TEST_F(Shot, KeepsWhatItHasRecordedWhenInterrupted) {
  const std::vector<std::string> endless =
      recorded(file("a.webp").string(), {"free_cube", "--frames", "20000", "--set", "body.cells=[1,1,1]",
                                         "--rate", "1000", "--set", "solve.duration=20"});
  ProgramRun run;
  for (const char* seconds :
       {"3", "12", "48"}) {  // slower processors, and sanitizers, reach the first frame later
    std::vector<std::string> interrupted{MSS_SOURCE_DIR "/tests/experiments/interrupt_after.sh", seconds};
    interrupted.insert(interrupted.end(), endless.begin(), endless.end());
    run = run_program(interrupted);
    EXPECT_EQ(run.exit_status, 130) << run.output;
    if (fs::exists(file("a.webp"))) break;
  }
  EXPECT_NE(run.output.find("a.webp, "), std::string::npos) << run.output;
  const std::size_t frames = Film(file("a.webp")).frames.size();
  EXPECT_GT(frames, 1U);
  EXPECT_LT(frames, 20000U);
}

}  // namespace
}  // namespace mss::view
