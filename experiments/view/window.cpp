// The window of `mss view`: GLFW's events become what the session, the camera and the display do.
#include "experiments/view/window.hpp"

#define GLFW_INCLUDE_NONE  // epoxy has OpenGL
#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <utility>

#include "core/base/error.hpp"
#include "core/device/device.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/view/bodies_surface.hpp"
#include "experiments/view/image.hpp"
#include "experiments/view/panel.hpp"
#include "experiments/view/recording.hpp"
#include "experiments/view/renderer.hpp"
#include "experiments/view/surface_on_device.hpp"

namespace mss::view {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// A window with a current context of OpenGL 4.3, whose shaders can step bodies, or else 3.3. Throws
/// InputError if there is none to be had.
class Window {
 public:
  Window(const ViewOptions& options, const std::string& title) {
    if (glfwInit() == GLFW_FALSE) fail();
    open(options, title, 4);
    const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    if (renderer != nullptr &&
        std::strstr(renderer, "llvmpipe") != nullptr) {  // a processor that draws is too slow
      glfwDestroyWindow(window_);
      open(options, title, 0);
    }
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
      auto& keys = static_cast<Window*>(glfwGetWindowUserPointer(window))->keys_;
      if (action == GLFW_PRESS) keys.push_back({key, modifiers});
    });
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }

  struct Key {
    int key, modifiers;
  };

  GLFWwindow* get() const { return window_; }
  /// The keys pressed since the last call.
  std::vector<Key> take_keys() { return std::exchange(keys_, {}); }

 private:
  void open(const ViewOptions& options, const std::string& title, int samples) {
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SAMPLES, samples);
    glfwWindowHint(GLFW_VISIBLE, options.shot.empty() && options.record.empty() ? GLFW_TRUE : GLFW_FALSE);
    for (const int major : {4, 3}) {
      glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
      glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
      window_ = glfwCreateWindow(options.width, options.height, title.c_str(), nullptr, nullptr);
      if (window_ != nullptr) break;
    }
    if (window_ == nullptr) fail();
    glfwMakeContextCurrent(window_);
  }

  [[noreturn]] static void fail() {
    const char* why = nullptr;
    glfwGetError(&why);
    const std::string reason = why != nullptr ? why : "no reason is given";
    glfwTerminate();
    throw InputError(
        fmt::format("no window with OpenGL 3.3 can be opened ({}); run on a desktop, or under xvfb-run from "
                    "the package xvfb",
                    reason));
  }

  GLFWwindow* window_ = nullptr;
  std::vector<Key> keys_;
};

/// What draws a window, as a device that takes steps.
class WindowDevice {
 public:
  /// Throws InputError if a scene needs it and it cannot; needs a current context.
  explicit WindowDevice(const Scene& scene) {
    try {
      device_ = Device::adopt_current();
    } catch (const InputError& error) {
      if (scene.solve.device != "cpu") throw;
      fault_ = error.what();
    }
  }

  /// Empty: it cannot.
  std::string name() const { return device_ ? device_->info().name : ""; }
  const std::shared_ptr<Device>& get() const { return device_; }
  /// Throws InputError if a setting needs it and it cannot.
  void check(const SceneEdit& settings) const {
    if (settings.device != "cpu" && !device_) throw InputError(fault_);
  }

 private:
  std::shared_ptr<Device> device_;
  std::string fault_;
};

/// Dear ImGui in a window, in the style of this program.
class Gui {
 public:
  explicit Gui(const Window& window) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // leaves no files behind
    const fs::path font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    if (fs::exists(font)) io.Fonts->AddFontFromFileTTF(font.c_str(), 14);
    ImGui::StyleColorsLight();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = style.WindowBorderSize = 0;
    style.FrameRounding = style.GrabRounding = 3;
    style.FramePadding = {6, 3};
    style.ItemSpacing = {6, 4};
    style.Colors[ImGuiCol_FrameBg] = {0.88F, 0.90F, 0.92F, 1};
    ImGui_ImplGlfw_InitForOpenGL(window.get(), true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
  }
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;
  ~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }

  /// Opens a frame for a screen of this size [pixels].
  void begin(int width, int height) const {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::GetIO().DisplaySize = {float(width), float(height)};
    ImGui::GetIO().DisplayFramebufferScale = {1, 1};
    ImGui::NewFrame();
  }
  void end() const {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }
};

/// Shows one session in one window.
class Viewer {
 public:
  Viewer(const Scene& scene, const ViewOptions& options)
      : options_(options),
        window_(options, "mss view: " + scene.name),
        device_(scene),
        session_(scene, options.motion),
        gui_(window_),
        panel_(scene),
        cells_(surface_of_cells(scene, session_.levels())),
        grids_(grids_of(session_.body(), scene.environment)),
        obstacles_(scene.environment.obstacles.begin(), scene.environment.obstacles.end()) {
    glfwGetFramebufferSize(window_.get(), &width_, &height_);
    const std::vector<const SceneBody*> bodies = bodies_of(scene);
    display_.has_mesh = display_.shows_mesh =
        std::any_of(bodies.begin(), bodies.end(), [](const SceneBody* one) { return one->mesh.has_value(); });
    if (display_.has_mesh) true_surface_ = surface_of_meshes(scene, session_.levels());
    display_.ground_spacing = grids_.front().spacing;
    display_.device = device_.name();
    see_all();
    fit_colours();
  }

  Status show_live();
  Status make_shot();
  Shown make_recording(Recording& recording);

 private:
  void frame();
  void simulate_frame();
  void do_keys();
  void do_mouse(const Viewport& view);
  void start_dragging(const Ray& ray);
  void drag(const Ray& ray);
  void release();
  void apply(const Panel::Requests& requests);
  void apply(PanelCommand command);
  void play_or_pause();
  void see(const std::vector<Vec3>& points);
  void see_all();
  void fit_colours();
  long frames_of_recording() const;
  long simulate_recording(long frames);
  void colour();
  bool move_on_device();
  void move_on_processor();
  SurfaceOnDevice* surface_on_device();
  Layout arrangement() const;
  void draw(const Layout& places, int width, int height);
  void draw_on(const Canvas& canvas);
  void log(const std::string& event) const;
  /// What is drawn of the body.
  DrawnSurface& surface() {
    if (display_.shows_mesh) return *true_surface_;
    return *cells_;
  }

  ViewOptions options_;
  Window window_;
  WindowDevice device_;
  Session session_;
  Gui gui_;
  Panel panel_;
  std::unique_ptr<DrawnSurface> cells_;
  std::unique_ptr<DrawnSurface> true_surface_;                                 ///< of bodies given as meshes
  std::map<const DrawnSurface*, std::unique_ptr<SurfaceOnDevice>> on_device_;  ///< nullptr: not to be had
  unsigned vertices_ = 0;  ///< of the surface, if they were moved on the device, see Picture
  std::vector<GridPlane> grids_;
  std::vector<ObstacleSurface> obstacles_;
  Renderer renderer_;
  Camera camera_;
  Display display_;
  int width_ = 0, height_ = 0;
  bool past_end_ = false;                  ///< the user continues after the scene's duration
  double grabbed_depth_ = 0;               ///< of the dragged particle, along the viewing direction [m]
  double shown_low_ = 0, shown_high_ = 0;  ///< values since the colours were fitted
  long frames_ = 0;
  double drawing_seconds_ = 0, stepping_seconds_ = 0;  ///< in all frames
  double frame_drawing_seconds_ = 0;                   ///< in the last one
  Clock::time_point recorded_ = Clock::now();
  double record_seconds_ = 0;
};

/// What scripts that drive the window wait for and check.
void Viewer::log(const std::string& event) const {
  if (!options_.log) return;
  Json widgets = Json::object();
  for (const auto& [name, w] : panel_.widgets())
    widgets[name] = {std::lround(w.x), std::lround(w.y), std::lround(w.width), std::lround(w.height)};
  const auto middle = camera_.project(camera_.target(), arrangement().body);
  const Json line{{"event", event},
                  {"t", session_.time()},
                  {"steps", session_.steps()},
                  {"status", to_string(session_.status())},
                  {"playing", display_.playing},
                  {"dt", session_.dt()},
                  {"integrator", session_.settings().integrator},
                  {"edge", session_.scene().body.springs.edge},
                  {"device", session_.settings().device},
                  {"fetches", session_.fetches()},
                  {"kinetic", session_.measures().kinetic},
                  {"yaw", camera_.yaw()},
                  {"distance", camera_.distance()},
                  {"middle", {std::lround(middle[0]), std::lround(middle[1])}},
                  {"width", width_},
                  {"height", height_},
                  {"frames", frames_},
                  {"frame_seconds", display_.frame_seconds},
                  {"stepping_seconds", stepping_seconds_},
                  {"drawing_seconds", drawing_seconds_},
                  {"renderer", reinterpret_cast<const char*>(glGetString(GL_RENDERER))},
                  {"slower", display_.slower},
                  {"message", display_.message},
                  {"widgets", widgets}};
  fmt::print("{}\n", line.dump());
  std::fflush(stdout);
}

void Viewer::play_or_pause() {
  display_.playing = !display_.playing && session_.status() == Status::ok;
  const double duration = session_.scene().solve.duration;
  past_end_ = session_.time() > duration - session_.dt() / 2 - 1e-9 * duration;
  log(display_.playing ? "play" : "pause");
}

/// Points the camera at all of these.
void Viewer::see(const std::vector<Vec3>& points) {
  Vec3 lower = points.front(), upper = lower;
  for (const Vec3& point : points) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  camera_.fit(lower, upper, arrangement().body);
  if (options_.plain) camera_.fill(points, arrangement().body);
}

void Viewer::see_all() {
  std::vector<Vec3> points;
  for (const std::ptrdiff_t site : cells_->sites()) points.push_back(session_.positions().at(site));
  see(points);
}

/// A plain picture is all body.
Layout Viewer::arrangement() const {
  if (!options_.plain) return layout(width_, height_);
  return {.column = {}, .graphs = {}, .bar = {}, .body = {0, 0, double(width_), double(height_)}};
}

void Viewer::fit_colours() {
  shown_low_ = info_of(display_.quantity).low;
  shown_high_ = info_of(display_.quantity).high;
}

void Viewer::apply(PanelCommand command) {
  switch (command) {
    case PanelCommand::play_or_pause:
      return play_or_pause();
    case PanelCommand::step:
      display_.playing = false;
      session_.step();
      session_.record();
      return log("step");
    case PanelCommand::restart:
      session_.restart();
      past_end_ = false;
      fit_colours();
      return log("restart");
    case PanelCommand::see_all:
      return see_all();
    case PanelCommand::fit_colours:
      return fit_colours();
    case PanelCommand::close:
      return glfwSetWindowShouldClose(window_.get(), GLFW_TRUE);
  }
}

void Viewer::apply(const Panel::Requests& requests) {
  if (!requests.commands.empty() || requests.settings) display_.message.clear();
  try {
    if (requests.settings) {
      device_.check(*requests.settings);
      session_.change(*requests.settings);
      log("change");
    }
    for (const PanelCommand command : requests.commands) apply(command);
  } catch (const InputError& error) {
    display_.message = error.what();
    log("refusal");
  }
}

void Viewer::do_keys() {
  Panel::Requests requests;
  for (const Window::Key& key : window_.take_keys()) {
    if (ImGui::GetIO().WantTextInput) continue;
    const bool control = (key.modifiers & GLFW_MOD_CONTROL) != 0;
    if (key.key == GLFW_KEY_SPACE) requests.commands.push_back(PanelCommand::play_or_pause);
    if (key.key == GLFW_KEY_S) requests.commands.push_back(PanelCommand::step);
    if (key.key == GLFW_KEY_R) requests.commands.push_back(PanelCommand::restart);
    if (key.key == GLFW_KEY_F) requests.commands.push_back(PanelCommand::see_all);
    if (key.key == GLFW_KEY_C) requests.commands.push_back(PanelCommand::fit_colours);
    if (key.key == GLFW_KEY_Q && control) requests.commands.push_back(PanelCommand::close);
  }
  if (!requests.commands.empty()) apply(requests);
}

void Viewer::do_mouse(const Viewport& view) {
  const ImGuiIO& io = ImGui::GetIO();
  const Ray ray = camera_.ray(io.MousePos.x, io.MousePos.y, view);
  if (session_.pulled()) {
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) return drag(ray);
    return release();
  }
  const auto begun_here = [&](ImGuiMouseButton b) {  // drags that began on a button or slider are not ours
    return ImGui::IsMouseDown(b) && view.contains(io.MouseClickedPos[b].x, io.MouseClickedPos[b].y);
  };
  if (view.contains(io.MousePos.x, io.MousePos.y)) {
    if (io.MouseWheel != 0) camera_.zoom(io.MouseWheel);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.KeyCtrl) start_dragging(ray);
  }
  if (session_.pulled()) return;
  if (begun_here(ImGuiMouseButton_Left)) camera_.orbit(io.MouseDelta.x, io.MouseDelta.y);
  if (begun_here(ImGuiMouseButton_Right) || begun_here(ImGuiMouseButton_Middle))
    camera_.pan(io.MouseDelta.x, io.MouseDelta.y, view);
}

void Viewer::start_dragging(const Ray& ray) {
  if (vertices_ != 0)
    surface().update(session_.positions(), std::vector<float>(surface().sites().size(), 0.0F));
  const auto hit = surface().hit(ray);
  if (!hit || session_.status() != Status::ok || !session_.grab(hit->site)) return;
  grabbed_depth_ = (session_.positions().at(hit->site) - camera_.eye()).dot(camera_.forward());
  log("grab");
}

/// The particle is pulled to where the mouse points, as far from the eye as it was.
void Viewer::drag(const Ray& ray) {
  session_.pull(ray.origin + grabbed_depth_ / ray.direction.dot(camera_.forward()) * ray.direction);
}

void Viewer::release() {
  session_.release();
  log("release");
}

/// As much time as the last frame took, as far as the machine gets in what drawing leaves of a sixtieth of a
/// second, and in a third of what drawing takes if that is more.
void Viewer::simulate_frame() {
  constexpr double longest_frame = 0.1, memory = 0.9;
  const double drawing = frame_drawing_seconds_;
  const double budget = std::max(1.0 / 60 - drawing, drawing / 3);
  display_.step_seconds = display_.steps_per_frame = 0;
  if (!display_.playing) return;
  double asked = std::min(display_.frame_seconds, longest_frame);
  const double left = session_.scene().solve.duration - session_.time();
  if (!past_end_) asked = std::min(asked, left);
  const auto begin = Clock::now();
  const std::int64_t steps_before = session_.steps();
  const double simulated = session_.advance_within(asked, budget);
  display_.step_seconds = seconds_since(begin);
  display_.steps_per_frame = double(session_.steps() - steps_before);
  if (simulated > 0)
    display_.slower = memory * display_.slower + (1 - memory) * display_.frame_seconds / simulated;
  const bool at_end = !past_end_ && simulated >= left;
  if (session_.status() == Status::ok && !at_end) return;
  display_.playing = false;
  log(at_end ? "end" : "failure");
}

/// The colour bar covers all values since it was fitted last.
void Viewer::colour() {
  vertices_ = 0;
  if (!move_on_device()) move_on_processor();
  display_.range = round_range(shown_low_, shown_high_, 0);
}

/// Where the body is, if what is drawn of it can be found there.
SurfaceOnDevice* Viewer::surface_on_device() {
  const auto [place, is_new] = on_device_.try_emplace(&surface());
  if (is_new)
    if (const auto motion = surface().motion())
      place->second = std::make_unique<SurfaceOnDevice>(surface(), *motion, device_.get());
  return place->second.get();
}

bool Viewer::move_on_device() {
  const Session::BodyOnDevice body = session_.body_on_device();
  if (body.index() == 0 || !SurfaceOnDevice::knows(display_.quantity)) return false;
  SurfaceOnDevice* there = surface_on_device();
  if (there == nullptr) return false;
  const auto update = [&](auto* system) {
    shown_high_ = std::max(shown_high_, there->update(*system, display_.quantity));
  };
  if (const auto* single = std::get_if<DeviceSystem<float>*>(&body)) update(*single);
  if (const auto* dbl = std::get_if<DeviceSystem<double>*>(&body)) update(*dbl);
  vertices_ = there->vertices();
  return true;
}

void Viewer::move_on_processor() {
  const auto values = values_at(surface().sites(), display_.quantity, session_.levels(), session_.positions(),
                                session_.velocities());
  for (const float value : values) {
    shown_low_ = std::min(shown_low_, double(value));
    shown_high_ = std::max(shown_high_, double(value));
  }
  surface().update(session_.positions(), values);
}

void Viewer::draw(const Layout& places, int width, int height) {
  Picture picture{.mesh = surface(),
                  .vertices = vertices_,
                  .range = display_.range,
                  .surface = display_.surface,
                  .edges = display_.edges && !display_.shows_mesh};
  if (display_.ground)
    for (const GridPlane& grid : grids_) add_grid(picture.lines, grid);
  for (const ObstacleSurface& obstacle : obstacles_)
    add_obstacle(picture.faces, picture.lines, obstacle, session_.time());
  if (display_.springs)
    for (const Level& level : session_.levels())
      add_springs(picture.lines, level, session_.positions(),
                  display_.quantity == DisplayedQuantity::stretch ? &display_.range : nullptr);
  if (display_.particles)
    add_particles(picture.points, session_.levels(), session_.positions(),
                  session_.scene().environment.holds);
  if (const auto pull = session_.pulled()) {
    const Colour red{0.8F, 0.1F, 0.1F};
    for (const Vec3& end : {pull->from, pull->to}) {
      picture.lines.push_back(mark(end, red));
      picture.points.push_back(mark(end, red));
    }
  }
  renderer_.draw(picture, camera_, places.body, width, height);
}

void Viewer::frame() {
  const auto begin = Clock::now();
  const int width_before = width_, height_before = height_;
  glfwGetFramebufferSize(window_.get(), &width_, &height_);
  if (width_ == 0 || height_ == 0) return;  // minimised
  gui_.begin(width_, height_);
  const Layout places = arrangement();
  apply(panel_.draw(session_, display_, places));
  do_keys();
  do_mouse(places.body);
  simulate_frame();
  stepping_seconds_ += display_.step_seconds;
  if (seconds_since(recorded_) > 20 * record_seconds_) {  // measuring takes a twentieth of the time at most
    const auto recording = Clock::now();
    if (display_.playing) session_.record();
    record_seconds_ = seconds_since(recording);
    recorded_ = Clock::now();
  }
  colour();
  draw(places, width_, height_);
  gui_.end();
  glfwSwapBuffers(window_.get());
  frame_drawing_seconds_ = seconds_since(begin) - display_.step_seconds;
  drawing_seconds_ += frame_drawing_seconds_;
  ++frames_;
  if (frames_ == 1) log("ready");
  if (frames_ > 1 && (width_ != width_before || height_ != height_before)) log("resize");
}

Status Viewer::show_live() {
  display_.playing = true;
  auto last = Clock::now();
  while (glfwWindowShouldClose(window_.get()) == GLFW_FALSE && !interrupted()) {
    glfwPollEvents();
    display_.frame_seconds = seconds_since(std::exchange(last, Clock::now()));
    frame();
  }
  log("close");
  return interrupted() ? Status::interrupted : session_.status();
}

void Viewer::draw_on(const Canvas& canvas) {
  gui_.begin(width_, height_);
  const Layout places = arrangement();
  if (!options_.plain) panel_.draw(session_, display_, places);
  canvas.bind();
  draw(places, width_, height_);
  gui_.end();
}

/// Sixtieths of a second as they come, whatever the time they take: the same picture on every machine.
Status Viewer::make_shot() {
  prepare_directory(options_.shot.has_parent_path() ? options_.shot.parent_path() : fs::path("."));
  width_ = options_.width;
  height_ = options_.height;
  const Canvas canvas(width_, height_);
  see_all();  // of a body that flies apart, its start
  for (; frames_ < options_.frames.value_or(0) && session_.status() == Status::ok && !interrupted();
       ++frames_) {
    const auto begin = Clock::now();
    session_.advance(1.0 / 60);
    stepping_seconds_ += seconds_since(begin);
    session_.record();
    if (!options_.every_frame) continue;
    const auto stepped = Clock::now();
    colour();
    draw_on(canvas);
    glFinish();
    drawing_seconds_ += seconds_since(stepped);
  }
  if (interrupted()) return Status::interrupted;
  if (session_.status() == Status::ok) see_all();
  colour();
  for (int pass = 0; pass < 2; ++pass) draw_on(canvas);  // Dear ImGui has sizes from the second frame on
  write_png(options_.shot, width_, height_, canvas.read());
  log("shot");
  return session_.status();
}

/// From the start until the scene ends.
long Viewer::frames_of_recording() const {
  const double last = session_.scene().solve.duration * options_.rate;
  return options_.frames.value_or(1 + std::lround(std::floor(last + 1e-9)));
}

/// Where the body comes to in these frames, and what its colours cover. Returns how many of them there are.
long Viewer::simulate_recording(long frames) {
  TerminalProgress progress("record " + session_.scene().name);
  std::vector<Vec3> corners;  // of the boxes that it is in
  long frame = 0;
  for (; frame < frames && !interrupted(); ++frame) {
    if (frame > 0) session_.advance(1 / options_.rate);
    if (session_.status() != Status::ok) break;
    Eigen::AlignedBox3d box;
    for (const std::ptrdiff_t site : cells_->sites()) box.extend(session_.positions().at(site));
    for (int corner = 0; corner < 8; ++corner)
      corners.push_back(box.corner(Eigen::AlignedBox3d::CornerType(corner)));
    colour();
    progress.report(double(frame) / double(2 * frames), "simulates");
  }
  if (!corners.empty()) see(corners);
  return frame;
}

/// Simulates twice: the first time to see what camera and colours must cover, so that neither changes from
/// frame to frame unless the simulation fails.
Shown Viewer::make_recording(Recording& recording) {
  width_ = options_.width;
  height_ = options_.height;
  const long frames = simulate_recording(frames_of_recording());
  const Status status = session_.status();
  if (interrupted()) return {Status::interrupted, 0};
  session_.restart();
  if (status != Status::ok) {  // of a body that flies apart, its start
    see_all();
    fit_colours();
  }
  const Canvas canvas(width_, height_);
  colour();
  draw_on(canvas);  // Dear ImGui has sizes from the second frame on
  TerminalProgress progress("record " + session_.scene().name);
  for (; frames_ < frames && !interrupted(); ++frames_) {
    if (frames_ > 0) {
      session_.advance(1 / options_.rate);
      session_.record();
      colour();
    }
    draw_on(canvas);
    recording.add(canvas.read());
    progress.report(0.5 + double(frames_) / double(2 * frames), "draws");
  }
  recording.finish();
  log("record");
  return {interrupted() ? Status::interrupted : status, frames_};
}

}  // namespace

Shown show(const Scene& scene, const ViewOptions& options) {
  std::unique_ptr<Recording> recording;  // names are refused before anything is opened
  if (!options.record.empty())
    recording = make_recording(options.record, options.width, options.height, options.rate);
  Viewer viewer(scene, options);
  if (recording) return viewer.make_recording(*recording);
  return {options.shot.empty() ? viewer.show_live() : viewer.make_shot()};
}

}  // namespace mss::view
