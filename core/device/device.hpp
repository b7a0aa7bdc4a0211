#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace mss {

class ShaderProgram;

/// What is known of a device.
struct DeviceInfo {
  std::string name{};        ///< as its driver calls it
  std::string version{};     ///< of OpenGL, as its driver says
  bool is_software = false;  ///< its shaders run on the processor
  std::string fault{};       ///< why it cannot be used; empty: it can
};

/// Thrown where a device turns out to have stopped working: nothing that it returned meanwhile means
/// anything.
class DeviceLost : public std::runtime_error {
 public:
  DeviceLost() : std::runtime_error("the device has stopped working") {}
};

/// Every device that EGL shows, usable or not. Throws InputError if the program was built without devices, or
/// EGL is not there.
std::vector<DeviceInfo> list_devices();

/// A device that runs compute shaders: a context of OpenGL 4.3 or later.
///
/// All calls of OpenGL belong between the beginning and the end of a DeviceUse.
class Device {
 public:
  /// "gpu": the first card, else the first that runs in software; "gpu:N": number N of list_devices(). One
  /// that is in use is shared. Throws InputError if there is none, or it cannot be used.
  static std::shared_ptr<Device> open(const std::string& choice);
  /// The context that is current in this thread, a window's, which must outlive it. While it lives it is what
  /// open("gpu") finds, and open() finds no other: a thread has one context at a time. Throws InputError if
  /// it is before OpenGL 4.3.
  static std::shared_ptr<Device> adopt_current();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  const DeviceInfo& info() const { return info_; }
  /// Threads that share a work group in later programs. What they compute does not depend on it.
  void set_group_size(int threads) { group_size_ = threads; }
  int group_size() const { return group_size_; }
  /// Largest buffer that a shader can reach [bytes].
  std::int64_t largest_buffer() const { return largest_buffer_; }

  /// The program of a text in GLSL, compiled once. Throws std::logic_error for text that is not GLSL, and
  /// DeviceLost.
  ShaderProgram& program(const std::string& text);
  /// Waits until everything asked for is done.
  void finish();
  /// Whether it has stopped working, since when nothing it returns means anything. Throws InputError if it
  /// ran out of memory, and std::logic_error if OpenGL has refused a call.
  bool is_lost();

 private:
  friend class DeviceUse;
  friend class DeviceMemory;
  struct Context;
  static constexpr std::ptrdiff_t outlet_bytes = std::ptrdiff_t{1} << 24;

  friend std::vector<DeviceInfo> list_devices();
  struct Tried;

  explicit Device(std::unique_ptr<Context> context);
  static Tried try_display(void* display, std::size_t number);
  static std::shared_ptr<Device> tried(std::unique_ptr<Context> context);
  /// A buffer of outlet_bytes through which the processor reads.
  unsigned outlet();

  std::unique_ptr<Context> context_;
  DeviceInfo info_;
  int group_size_ = 128;
  std::int64_t largest_buffer_ = 0;
  bool is_lost_ = false;
  std::recursive_mutex in_use_;
  int uses_ = 0;
  unsigned outlet_ = 0;
  std::unordered_map<std::string, std::unique_ptr<ShaderProgram>> programs_;
};

/// While it lives, this thread calls a device, and no other thread can. Throws DeviceLost if it has no
/// context any more.
class DeviceUse {
 public:
  explicit DeviceUse(Device& device);
  ~DeviceUse();
  DeviceUse(const DeviceUse&) = delete;
  DeviceUse& operator=(const DeviceUse&) = delete;

 private:
  Device& device_;
  std::unique_lock<std::recursive_mutex> lock_;
};

/// Memory of a device, zero at first. Its functions need a DeviceUse, its destructor none.
class DeviceMemory {
 public:
  DeviceMemory() = default;
  /// With a copy of what is at `from`, unless that is nullptr. Throws InputError if the device has not so
  /// much memory, or its shaders cannot reach so much, and DeviceLost.
  DeviceMemory(const std::shared_ptr<Device>& device, std::ptrdiff_t bytes, const void* from = nullptr);
  DeviceMemory(DeviceMemory&& other) noexcept;
  DeviceMemory& operator=(DeviceMemory&& other) noexcept;
  ~DeviceMemory();

  std::ptrdiff_t bytes() const { return bytes_; }
  unsigned id() const { return id_; }
  void write(const void* from, std::ptrdiff_t offset, std::ptrdiff_t bytes);
  void read(void* to, std::ptrdiff_t offset, std::ptrdiff_t bytes) const;
  void clear();
  /// Takes over what another of the same size holds.
  void copy(const DeviceMemory& other);

 private:
  std::shared_ptr<Device> device_;
  unsigned id_ = 0;
  std::ptrdiff_t bytes_ = 0;
};

/// Memory that holds these values.
template <class T>
DeviceMemory memory_of(const std::shared_ptr<Device>& device, const std::vector<T>& values) {
  return {device, std::ptrdiff_t(values.size() * sizeof(T)), values.data()};
}

/// A compiled compute shader. Its functions need a DeviceUse.
class ShaderProgram {
 public:
  ShaderProgram(const std::string& text, int group_size);
  ~ShaderProgram();
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;

  /// Values of uniforms, for later runs; of those that the text does not use nothing.
  ShaderProgram& set(const char* name, int value);
  ShaderProgram& set(const char* name, float value);
  ShaderProgram& set(const char* name, double value);
  /// The buffer that `binding` names.
  ShaderProgram& bind(int binding, const DeviceMemory& memory);
  /// Runs main() for threads 0 ... count - 1 and some more, after all that was asked for before.
  void run(std::ptrdiff_t count);

 private:
  int location(const char* name);

  unsigned id_ = 0;
  int group_size_;
  std::unordered_map<std::string, int> locations_;
};

/// A text of shaders/, or one that formulas share with them, by its file's name.
std::string_view shader_text(std::string_view name);

}  // namespace mss
