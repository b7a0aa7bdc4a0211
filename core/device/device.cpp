// Contexts of OpenGL from EGL, without a window: of every device that EGL_EXT_device_enumeration shows, or,
// without that extension, of EGL's own choice. EGL and OpenGL are looked for when the first device is asked
// for, so the program starts without them.
#include "core/device/device.hpp"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/base/error.hpp"

namespace mss {

/// Of EGL; or a window's, which has none.
struct Device::Context {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
  }
  bool is_adopted() const { return context == EGL_NO_CONTEXT; }
  /// A thread's choice of API and its context are its own, and what was current before comes back.
  bool make_current() {
    if (is_adopted()) return true;
    eglBindAPI(EGL_OPENGL_API);
    display_before = eglGetCurrentDisplay();
    context_before = eglGetCurrentContext();
    return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE;
  }
  void release() const {
    if (is_adopted()) return;
    eglBindAPI(EGL_OPENGL_API);
    if (context_before == EGL_NO_CONTEXT)
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    else
      eglMakeCurrent(display_before, EGL_NO_SURFACE, EGL_NO_SURFACE, context_before);
  }

 private:
  EGLDisplay display_before = EGL_NO_DISPLAY;
  EGLContext context_before = EGL_NO_CONTEXT;
};

/// What EGL shows at a place: a device that has passed its trial, or why there is none.
struct Device::Tried {
  std::shared_ptr<Device> device{};
  DeviceInfo info{};
};

namespace {

constexpr int least_version = 43;  ///< of OpenGL, times ten
constexpr int most_buffers = 12;   ///< that a shader of ours reaches,
constexpr int most_bindings = 16;  ///< by numbers below this

/// Throws InputError if EGL is not there; epoxy would end the program.
void find_egl() {
  static const bool is_there = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr;
  if (!is_there)
    throw InputError(
        "no device: EGL (libEGL.so.1) is not on this machine; install it and a driver, or give device = "
        "\"cpu\"");
}

/// Empty: EGL does not show them.
std::vector<EGLDeviceEXT> egl_devices() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
      !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base"))
    return {};
  EGLint count = 0;
  if (!eglQueryDevicesEXT(0, nullptr, &count) || count < 1) return {};
  std::vector<EGLDeviceEXT> devices(std::size_t(count), nullptr);
  if (!eglQueryDevicesEXT(count, devices.data(), &count)) return {};
  devices.resize(std::size_t(count));
  return devices;
}

std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> all;
  for (EGLDeviceEXT device : egl_devices())
    all.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
  if (all.empty() && epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    all.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                           reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr));
  if (all.empty()) all.push_back(eglGetDisplay(EGL_DEFAULT_DISPLAY));
  return all;
}

EGLContext create_context(EGLDisplay display) {
  // That a driver was reset is to be seen, where it can tell.
  for (const bool robust : {true, false}) {
    std::vector<EGLint> wanted{EGL_CONTEXT_MAJOR_VERSION,       least_version / 10,
                               EGL_CONTEXT_MINOR_VERSION,       least_version % 10,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
    if (robust)
      wanted.insert(wanted.end(),
                    {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
    wanted.push_back(EGL_NONE);
    const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
    if (context != EGL_NO_CONTEXT) return context;
  }
  return EGL_NO_CONTEXT;
}

std::string gl_text(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : "";
}

/// Of the current context.
DeviceInfo describe_current() {
  const std::string name = gl_text(GL_RENDERER);
  const auto contains = [&](std::string_view part) { return name.find(part) != std::string::npos; };
  DeviceInfo info{.name = name,
                  .version = gl_text(GL_VERSION),
                  .is_software = contains("llvmpipe") || contains("softpipe") || contains("SwiftShader")};
  if (epoxy_gl_version() < least_version)
    info.fault = fmt::format("its OpenGL is {}, and compute shaders need OpenGL 4.3", info.version);
  GLint buffers = 0;
  if (info.fault.empty()) glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &buffers);
  if (info.fault.empty() && buffers < most_buffers)
    info.fault = fmt::format("its shaders reach {} buffers, and some here need {}", buffers, most_buffers);
  GLint bindings = most_bindings;
  if (info.fault.empty()) glGetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &bindings);
  if (bindings < most_bindings)
    info.fault = fmt::format("it binds {} buffers, and this needs {}", bindings, most_bindings);
  return info;
}

/// Throws InputError.
std::size_t number_in(const std::string& choice) {
  const std::string digits = choice.rfind("gpu:", 0) == 0 ? choice.substr(4) : "";
  if (digits.empty() || digits.size() > 3 || digits.find_first_not_of("0123456789") != std::string::npos)
    throw InputError(
        fmt::format("device '{}' is unknown; give \"cpu\", \"gpu\", or \"gpu:N\" with a number "
                    "of `mss list devices`",
                    choice));
  return std::stoul(digits);
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  find_egl();
  std::vector<DeviceInfo> all;
  for (EGLDisplay display : displays()) all.push_back(Device::try_display(display, all.size()).info);
  return all;
}

namespace {

std::size_t first_card(const std::vector<DeviceInfo>& all) {
  const auto usable = [](const DeviceInfo& info) { return info.fault.empty(); };
  const auto card = [&](const DeviceInfo& info) { return usable(info) && !info.is_software; };
  auto found = std::find_if(all.begin(), all.end(), card);
  if (found == all.end()) found = std::find_if(all.begin(), all.end(), usable);
  if (found != all.end()) return std::size_t(found - all.begin());
  std::string faults;
  for (const DeviceInfo& info : all) faults += fmt::format("; {}: {}", info.name, info.fault);
  throw InputError(
      fmt::format("no device with OpenGL 4.3{}; install a driver, or give device = \"cpu\"", faults));
}

[[noreturn]] void refuse(const DeviceInfo& info) {
  throw InputError(fmt::format("device {} cannot be used: {}; give another one, or device = \"cpu\"",
                               info.name, info.fault));
}

/// Whether it does what steps are made of: numbers are written, changed by one shader after the other, and
/// written and zeroed in between, copied and read.
bool computes_rightly(const std::shared_ptr<Device>& device) {
  const DeviceUse use(*device);
  std::vector<float> numbers(1000);
  std::iota(numbers.begin(), numbers.end(), 1.0F);
  const auto bytes = std::ptrdiff_t(numbers.size() * sizeof(numbers[0]));
  DeviceMemory given(device, bytes), sums(device, bytes), copied(device, bytes);
  static const std::string text(shader_text("trial"));
  const auto add = [&](double factor) {
    device->program(text)
        .bind(14, given)
        .bind(3, sums)
        .set("factor", factor)
        .run(std::ptrdiff_t(numbers.size()));
  };
  given.write(numbers.data(), 0, bytes);
  add(7);
  sums.clear();
  add(2);
  add(0.5);
  const float first = 100;
  given.write(&first, 0, sizeof(first));
  add(0.5);
  copied.copy(sums);
  std::vector<float> found(numbers.size());
  copied.read(found.data(), 0, bytes);
  numbers[0] = (2.5F + 50) / 3;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (found[i] != 3 * numbers[i]) return false;
  return true;
}

/// A window's.
std::weak_ptr<Device>& adopted() {
  static std::weak_ptr<Device> device;
  return device;
}

}  // namespace

std::shared_ptr<Device> Device::open(const std::string& choice) {
  // As long as the program runs: drivers do not like to be taken down at its end.
  static std::mutex opening;
  static auto& opened = *new std::map<std::size_t, std::shared_ptr<Device>>;
  const std::lock_guard<std::mutex> lock(opening);
  if (auto of_window = adopted().lock()) {
    if (choice == "gpu") return of_window;
    throw InputError(
        fmt::format("device '{}': in a window steps are taken by what draws it, {}; give device = \"gpu\"",
                    choice, of_window->info().name));
  }
  static std::size_t of_gpu = std::numeric_limits<std::size_t>::max();
  if (choice == "gpu" && of_gpu == std::numeric_limits<std::size_t>::max())
    of_gpu = first_card(list_devices());
  const std::size_t number = choice == "gpu" ? of_gpu : number_in(choice);
  if (const auto found = opened.find(number); found != opened.end() && !found->second->is_lost_)
    return found->second;
  find_egl();
  const std::vector<EGLDisplay> all = displays();
  if (number >= all.size())
    throw InputError(fmt::format("device '{}' is not there; `mss list devices` has {}", choice, all.size()));
  const Tried tried = try_display(all[number], number);
  if (!tried.device) refuse(tried.info);
  return opened[number] = tried.device;
}

std::shared_ptr<Device> Device::adopt_current() {
  auto device = tried(std::make_unique<Context>());
  if (!device->info_.fault.empty()) refuse(device->info_);
  adopted() = device;
  return device;
}

/// A fault says what is wrong with it.
std::shared_ptr<Device> Device::tried(std::unique_ptr<Context> context) {
  auto device = std::shared_ptr<Device>(new Device(std::move(context)));
  if (device->info_.fault.empty() && !computes_rightly(device))
    device->info_.fault = "its driver does not compute what a small shader says";
  return device;
}

Device::Tried Device::try_display(void* display, std::size_t number) {
  Tried none{.info = {.name = fmt::format("EGL's device {}", number)}};
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) {
    none.info.fault = "EGL cannot start its driver";
    return none;
  }
  if (!eglBindAPI(EGL_OPENGL_API)) {
    none.info.fault = "it has no OpenGL";
    return none;
  }
  auto context = std::make_unique<Context>();
  context->display = display;
  context->context = create_context(display);
  if (context->context == EGL_NO_CONTEXT) {
    if (const char* vendor = eglQueryString(display, EGL_VENDOR)) none.info.name = vendor;
    none.info.fault = "it has no context of OpenGL 4.3";
    return none;
  }
  try {
    Tried found{.device = tried(std::move(context))};
    found.info = found.device->info_;
    if (!found.info.fault.empty()) found.device.reset();
    return found;
  } catch (const std::exception& problem) {
    none.info.fault = problem.what();
    return none;
  }
}

Device::Device(std::unique_ptr<Context> context) : context_(std::move(context)) {
  const DeviceUse use(*this);
  info_ = describe_current();
  if (!info_.fault.empty()) return;
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  largest_buffer_ = largest;
}

Device::~Device() {
  try {
    const DeviceUse use(*this);
    programs_.clear();
    glDeleteBuffers(1, &outlet_);
  } catch (const DeviceLost&) {  // and what it held with it
    for (auto& [text, program] : programs_) static_cast<void>(program.release());
  }
}

unsigned Device::outlet() {
  if (outlet_ != 0) return outlet_;
  glGenBuffers(1, &outlet_);
  glBindBuffer(GL_COPY_WRITE_BUFFER, outlet_);
  glBufferData(GL_COPY_WRITE_BUFFER, outlet_bytes, nullptr, GL_STREAM_READ);
  return outlet_;
}

DeviceUse::DeviceUse(Device& device) : device_(device), lock_(device.in_use_) {
  if (device_.uses_ == 0 && !device_.context_->make_current()) {
    device_.is_lost_ = true;
    throw DeviceLost();
  }
  ++device_.uses_;
}

DeviceUse::~DeviceUse() {
  if (--device_.uses_ == 0) device_.context_->release();
}

ShaderProgram& Device::program(const std::string& text) {
  std::unique_ptr<ShaderProgram>& program = programs_[fmt::format("{}\n{}", group_size_, text)];
  if (program) return *program;
  try {
    program = std::make_unique<ShaderProgram>(text, group_size_);
  } catch (const std::logic_error&) {
    if (is_lost()) throw DeviceLost();
    throw;
  }
  return *program;
}

void Device::finish() { glFinish(); }

bool Device::is_lost() {
  if (is_lost_) return true;
  const bool tells = epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness");
  is_lost_ = tells && glGetGraphicsResetStatus() != GL_NO_ERROR;
  for (GLenum error = glGetError(); error != GL_NO_ERROR && !is_lost_; error = glGetError()) {
    if (error == GL_OUT_OF_MEMORY)
      throw InputError(
          fmt::format("{} has no memory left; give a smaller body, or device = \"cpu\"", info_.name));
    is_lost_ = error == GL_CONTEXT_LOST;
    if (!is_lost_) throw std::logic_error(fmt::format("OpenGL refuses a call, with error {:#x}", error));
  }
  return is_lost_;
}

DeviceMemory::DeviceMemory(const std::shared_ptr<Device>& device, std::ptrdiff_t bytes, const void* from)
    : device_(device), bytes_(std::max<std::ptrdiff_t>(bytes, 16)) {
  const auto refuse = [&](const char* why) {
    throw InputError(
        fmt::format("{} {} of {:.3g} MB, which this body needs; give a smaller one, or device = "
                    "\"cpu\"",
                    device_->info().name, why, double(bytes_) / 1e6));
  };
  if (bytes_ > device_->largest_buffer()) refuse("lets shaders reach no buffer");
  if (device_->is_lost()) throw DeviceLost();
  glGenBuffers(1, &id_);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  // Numbers go along with the memory: after glClearBufferData() one driver was seen to lose what was written.
  const std::vector<char> zeros(std::size_t(from && bytes == bytes_ ? 0 : bytes_));
  glBufferData(GL_SHADER_STORAGE_BUFFER, bytes_, zeros.empty() ? from : zeros.data(), GL_DYNAMIC_COPY);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    glDeleteBuffers(1, &id_);
    id_ = 0;
    if (error == GL_CONTEXT_LOST) throw DeviceLost();
    refuse("has no memory left for a buffer");
  }
  if (from && !zeros.empty()) write(from, 0, bytes);
}

DeviceMemory::DeviceMemory(DeviceMemory&& other) noexcept
    : device_(std::move(other.device_)),
      id_(std::exchange(other.id_, 0)),
      bytes_(std::exchange(other.bytes_, 0)) {}

DeviceMemory& DeviceMemory::operator=(DeviceMemory&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(id_, other.id_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

DeviceMemory::~DeviceMemory() {
  if (id_ == 0) return;
  try {
    const DeviceUse use(*device_);
    glDeleteBuffers(1, &id_);
  } catch (const DeviceLost&) {  // and the memory with it
  }
}

void DeviceMemory::write(const void* from, std::ptrdiff_t offset, std::ptrdiff_t bytes) {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, offset, bytes, from);
}

/// By way of a small buffer that is there for it: drivers move what is read often out of the device's memory.
void DeviceMemory::read(void* to, std::ptrdiff_t offset, std::ptrdiff_t bytes) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_COPY_READ_BUFFER, id_);
  glBindBuffer(GL_COPY_WRITE_BUFFER, device_->outlet());
  for (std::ptrdiff_t done = 0; done < bytes; done += Device::outlet_bytes) {
    const std::ptrdiff_t part = std::min(bytes - done, Device::outlet_bytes);
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, offset + done, 0, part);
    glGetBufferSubData(GL_COPY_WRITE_BUFFER, 0, part, static_cast<char*>(to) + done);
  }
}

void DeviceMemory::clear() {
  static const std::string text(shader_text("clear"));
  device_->program(text).bind(0, *this).run(bytes_ / std::ptrdiff_t(sizeof(std::uint32_t)));
}

void DeviceMemory::copy(const DeviceMemory& other) {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_COPY_READ_BUFFER, other.id_);
  glBindBuffer(GL_COPY_WRITE_BUFFER, id_);
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, bytes_);
}

ShaderProgram::ShaderProgram(const std::string& text, int group_size) : group_size_(group_size) {
  const std::string whole =
      fmt::format("#version 430 core\nlayout(local_size_x = {}) in;\n{}", group_size, text);
  const char* lines = whole.c_str();
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  glShaderSource(shader, 1, &lines, nullptr);
  glCompileShader(shader);
  std::array<char, 4096> log{};
  GLint compiled = 0, linked = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (!compiled) glGetShaderInfoLog(shader, GLsizei(log.size()), nullptr, log.data());
  id_ = glCreateProgram();
  glAttachShader(id_, shader);
  if (compiled) glLinkProgram(id_);
  glGetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (compiled && !linked) glGetProgramInfoLog(id_, GLsizei(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  if (linked) return;
  glDeleteProgram(id_);
  throw std::logic_error(fmt::format("a shader does not compile: {}", log.data()));
}

ShaderProgram::~ShaderProgram() { glDeleteProgram(id_); }

int ShaderProgram::location(const char* name) {
  const auto [at, is_new] = locations_.try_emplace(name, 0);
  if (is_new) at->second = glGetUniformLocation(id_, name);
  return at->second;
}

ShaderProgram& ShaderProgram::set(const char* name, int value) {
  glProgramUniform1i(id_, location(name), value);
  return *this;
}
ShaderProgram& ShaderProgram::set(const char* name, float value) {
  glProgramUniform1f(id_, location(name), value);
  return *this;
}
ShaderProgram& ShaderProgram::set(const char* name, double value) {
  glProgramUniform1d(id_, location(name), value);
  return *this;
}

ShaderProgram& ShaderProgram::bind(int binding, const DeviceMemory& memory) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(binding), memory.id());
  return *this;
}

void ShaderProgram::run(std::ptrdiff_t count) {
  constexpr std::ptrdiff_t most = 65535;  // every device takes so many groups along an axis
  const std::ptrdiff_t groups = (count + group_size_ - 1) / group_size_;
  const std::ptrdiff_t rows = (groups + most - 1) / most, columns = rows > 0 ? (groups + rows - 1) / rows : 0;
  if (groups == 0) return;
  set("threads_in_row", int(columns * group_size_));
  set("thread_count", int(count));
  glUseProgram(id_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  glDispatchCompute(GLuint(columns), GLuint(rows), 1);
}

}  // namespace mss
