#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

namespace mss {

/// Writes a file whole or not at all: beside its place under another name first, then renamed. Missing
/// directories are made. Throws InputError naming the file if that fails; what was there before is then
/// untouched.
void write_atomically(const std::filesystem::path& file, std::string_view content);

/// The same for content too large to hold at once: `write` gets the stream to put it into.
void write_atomically(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

/// The same for what another library writes: `write` gets the file's other name.
void replace_atomically(const std::filesystem::path& file,
                        const std::function<void(const std::filesystem::path& beside)>& write);

/// Makes a directory and checks that files can be written to it. Throws InputError if not.
void prepare_directory(const std::filesystem::path& directory);

/// Keeps other processes from claiming a directory as long as it lives, and its process does.
class DirectoryClaim {
 public:
  /// Throws InputError if another process has it. Where the file system knows no locks it claims nothing.
  explicit DirectoryClaim(const std::filesystem::path& directory);
  DirectoryClaim(const DirectoryClaim&) = delete;
  DirectoryClaim& operator=(const DirectoryClaim&) = delete;
  ~DirectoryClaim();

 private:
  int descriptor_;
};

/// A new directory for temporary files, removed with everything in it by the destructor. Throws InputError if
/// it cannot be made.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The whole content of a file. Throws InputError naming it if it cannot be read.
std::string read_file(const std::filesystem::path& file);

}  // namespace mss
