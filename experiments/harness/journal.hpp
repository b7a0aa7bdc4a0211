#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "experiments/harness/json.hpp"

namespace mss {

/// A number of an answer; what is not finite is null there, and NaN here.
double number(const Json& value);

/// Answers found so far, by the name of their case, in a file that survives an interruption: a first line
/// that says what they belong to, then a line of JSON each. A line that was cut short is dropped.
class Journal {
 public:
  /// Of nothing on disk.
  Journal() = default;

  /// Goes on with a file, or begins it. `belongs_to` is what answers depend on; the program's build is
  /// added. Throws InputError if the file belongs to something else or cannot be written.
  Journal(const std::filesystem::path& file, const Json& belongs_to);

  /// nullptr: not known yet.
  const Json* find(const std::string& name) const;
  void add(const std::string& name, Json answer);
  std::size_t size() const { return answers_.size(); }

 private:
  std::map<std::string, Json> answers_;
  std::ofstream stream_;
};

}  // namespace mss
