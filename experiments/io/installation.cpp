#include "experiments/io/installation.hpp"

#include <dlfcn.h>

#include <optional>

namespace mss {

namespace {

namespace fs = std::filesystem;

/// The program or shared library that this code is in.
fs::path this_file() {
  std::error_code error;
  Dl_info info{};
  static const char anchor = 0;
  if (dladdr(&anchor, &info) != 0 && fs::path(info.dli_fname).is_absolute())
    return fs::canonical(info.dli_fname, error);
  return fs::read_symlink("/proc/self/exe", error);  // of a program, dladdr() knows what the caller named it
}

/// The prefix of the installation, if this file is where installing puts it.
std::optional<fs::path> installation() {
  const fs::path folder = this_file().parent_path();
  std::error_code error;
  for (const char* up : {MSS_PREFIX_FROM_PROGRAM, MSS_PREFIX_FROM_PYTHON}) {
    const fs::path prefix = (folder / up).lexically_normal();
    if (fs::is_directory(prefix / MSS_DATA_FOLDER, error)) return prefix;
  }
  return std::nullopt;
}

}  // namespace

fs::path shipped_files() {
  const std::optional<fs::path> prefix = installation();
  return prefix ? *prefix / MSS_DATA_FOLDER : fs::path(MSS_SOURCE_TREE);
}

fs::path helper_program(const std::string& name) {
  const std::optional<fs::path> prefix = installation();
  return (prefix ? *prefix / MSS_HELPER_FOLDER : fs::path(MSS_BUILD_FOLDER)) / name;
}

}  // namespace mss
