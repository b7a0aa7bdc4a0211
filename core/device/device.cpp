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
  bool make_current() const {
    return is_adopted() || eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE;
  }
  void release() const {
    if (!is_adopted()) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
};

namespace {

constexpr int least_version = 43;  ///< of OpenGL, times ten
constexpr int most_buffers = 12;   ///< that a shader of ours reaches; bindings are below 16

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
                  .is_software = contains("llvmpipe") || contains("softpipe") || contains("SwiftShader"),
                  .has_double = epoxy_gl_version() >= 40 || epoxy_has_gl_extension("GL_ARB_gpu_shader_fp64")};
  if (epoxy_gl_version() < least_version)
    info.fault = fmt::format("its OpenGL is {}, and compute shaders need 4.3", info.version);
  GLint buffers = 0;
  if (info.fault.empty()) glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &buffers);
  if (info.fault.empty() && buffers < most_buffers)
    info.fault = fmt::format("its shaders reach {} buffers, and some here need {}", buffers, most_buffers);
  return info;
}

/// What EGL shows at a place, opened; nullptr and why not, if it cannot be.
struct Opened {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  DeviceInfo info{};
};
Opened open_display(EGLDisplay display, int number) {
  Opened opened{.display = display};
  opened.info.name = fmt::format("EGL's device {}", number);
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) {
    opened.info.fault = "EGL cannot start its driver";
    return opened;
  }
  if (!eglBindAPI(EGL_OPENGL_API)) {
    opened.info.fault = "it has no OpenGL";
    return opened;
  }
  opened.context = create_context(display);
  if (opened.context == EGL_NO_CONTEXT ||
      !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, opened.context)) {
    if (const char* vendor = eglQueryString(display, EGL_VENDOR)) opened.info.name = vendor;
    opened.info.fault = "it has no context of OpenGL 4.3";
    return opened;
  }
  opened.info = describe_current();
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  return opened;
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
  for (EGLDisplay display : displays()) {
    const Opened opened = open_display(display, int(all.size()));
    if (opened.context != EGL_NO_CONTEXT) eglDestroyContext(display, opened.context);
    all.push_back(opened.info);
  }
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

/// Whether numbers that are written there, changed by a shader, copied and read are what they should be.
bool computes_rightly(const std::shared_ptr<Device>& device) {
  const DeviceUse use(*device);
  std::vector<std::uint32_t> numbers(1000);
  std::iota(numbers.begin(), numbers.end(), 1U);
  const auto bytes = std::ptrdiff_t(numbers.size() * sizeof(numbers[0]));
  const DeviceMemory given(device, bytes, numbers.data());
  DeviceMemory changed(device, bytes), copied(device, bytes);
  changed.clear();
  static const std::string text(shader_text("trial"));
  device->program(text).bind(14, given).bind(3, changed).set("factor", 3).run(std::ptrdiff_t(numbers.size()));
  copied.copy(changed);
  std::vector<std::uint32_t> found(numbers.size());
  copied.read(found.data(), 0, bytes);
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
  const Opened found = open_display(all[number], int(number));
  auto context = std::make_unique<Context>();
  context->display = found.display;
  context->context = found.context;
  if (!found.info.fault.empty()) refuse(found.info);
  return opened[number] = checked(std::move(context));
}

std::shared_ptr<Device> Device::adopt_current() {
  auto device = checked(std::make_unique<Context>());
  adopted() = device;
  return device;
}

/// Throws InputError for a device that does not do what it is asked for.
std::shared_ptr<Device> Device::checked(std::unique_ptr<Context> context) {
  auto device = std::shared_ptr<Device>(new Device(std::move(context)));
  if (!device->info_.fault.empty()) refuse(device->info_);
  if (!computes_rightly(device)) {
    device->info_.fault = "its driver does not compute what a small shader says";
    refuse(device->info_);
  }
  return device;
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
  const DeviceUse use(*this);
  programs_.clear();
}

DeviceUse::DeviceUse(Device& device) : device_(device), lock_(device.in_use_) {
  if (device_.uses_++ == 0 && !device_.context_->make_current()) device_.is_lost_ = true;
}

DeviceUse::~DeviceUse() {
  if (--device_.uses_ == 0) device_.context_->release();
}

ShaderProgram& Device::program(const std::string& text) {
  std::unique_ptr<ShaderProgram>& program = programs_[fmt::format("{}\n{}", group_size_, text)];
  if (!program) program = std::make_unique<ShaderProgram>(text, group_size_);
  return *program;
}

void Device::finish() { glFinish(); }

bool Device::is_lost() {
  if (is_lost_) return true;
  const bool tells = epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness");
  is_lost_ = tells && glGetGraphicsResetStatus() != GL_NO_ERROR;
  for (GLenum error = glGetError(); error != GL_NO_ERROR && !is_lost_; error = glGetError()) {
    is_lost_ = error == GL_OUT_OF_MEMORY || error == GL_CONTEXT_LOST;
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
  device_->is_lost();
  glGenBuffers(1, &id_);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  // Numbers go along with the memory: what glClearBufferData() does was seen to overtake later writes.
  const std::vector<char> zeros(std::size_t(from && bytes == bytes_ ? 0 : bytes_));
  glBufferData(GL_SHADER_STORAGE_BUFFER, bytes_, zeros.empty() ? from : zeros.data(), GL_DYNAMIC_COPY);
  if (glGetError() != GL_NO_ERROR) {
    glDeleteBuffers(1, &id_);
    id_ = 0;
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
  const DeviceUse use(*device_);
  glDeleteBuffers(1, &id_);
}

void DeviceMemory::write(const void* from, std::ptrdiff_t offset, std::ptrdiff_t bytes) {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, offset, bytes, from);
}

void DeviceMemory::read(void* to, std::ptrdiff_t offset, std::ptrdiff_t bytes) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, offset, bytes, to);
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
