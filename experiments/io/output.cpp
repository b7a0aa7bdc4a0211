#include "experiments/io/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/base/error.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& why) {
  throw InputError(fmt::format("{} cannot be written: {}; choose another place", file.string(), why));
}

}  // namespace

void prepare_directory(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) fail(directory, error.message());
  if (!fs::is_directory(directory)) fail(directory, "it is not a directory");
  if (access(directory.c_str(), W_OK | X_OK) != 0) fail(directory, std::strerror(errno));
}

DirectoryClaim::DirectoryClaim(const fs::path& directory)
    : descriptor_(open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError(
      fmt::format("{} is written to by another run of mss; wait for its end, or choose another --out",
                  directory.string()));
}

DirectoryClaim::~DirectoryClaim() {
  if (descriptor_ >= 0) close(descriptor_);
}

void write_atomically(const fs::path& file, std::string_view content) {
  write_atomically(file, [content](std::ostream& stream) {
    stream.write(content.data(), std::streamsize(content.size()));
  });
}

void write_atomically(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  replace_atomically(file, [&](const fs::path& beside) {
    std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
    write(stream);
    stream.close();
    if (!stream) throw InputError(std::strerror(errno));
  });
}

void replace_atomically(const fs::path& file, const std::function<void(const fs::path& beside)>& write) {
  if (file.has_parent_path()) prepare_directory(file.parent_path());
  fs::path beside = file;
  beside += fmt::format(".{}.tmp", getpid());
  std::error_code error;
  try {
    write(beside);
  } catch (const InputError& why) {
    fs::remove(beside, error);
    fail(file, why.what());
  }
  fs::rename(beside, file, error);
  if (error) {
    const std::string why = error.message();
    fs::remove(beside, error);
    fail(file, why);
  }
}

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (fs::temp_directory_path() / "mss-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) fail(name, std::strerror(errno));
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string read_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  if (!stream) throw InputError(fmt::format("{} cannot be read: {}", file.string(), std::strerror(errno)));
  return std::move(content).str();
}

}  // namespace mss
