#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "experiments/harness/case_part.hpp"
#include "experiments/harness/json.hpp"

namespace mss {

/// A number in a result: NaN for null, which is how JSON writes what is not finite.
double number(const Json& value);

/// Results of finished cases by name, in a file that survives an interruption: a first line that identifies
/// the program and configuration they belong to, then one line of JSON per case. A line that was cut short is
/// dropped.
class Journal {
 public:
  /// In memory only.
  Journal() = default;

  /// Continues a file, or begins it. `belongs_to` holds everything that results depend on; the program's
  /// build is added: a file that differs by it alone is kept beside the new one, as FILE.before. Throws
  /// InputError if the file belongs to something else or cannot be written.
  /// Of a part of the cases, if that is given.
  Journal(const std::filesystem::path& file, const Json& belongs_to, const CasePart& part = {});

  /// nullptr if there is none yet.
  const Json* find(const std::string& name) const;
  /// Throws InputError if the file cannot be written.
  void add(const std::string& name, Json result);
  std::size_t size() const { return results_.size(); }
  /// Which cases are to be computed.
  const CasePart& part() const { return part_; }

 private:
  std::map<std::string, Json> results_;
  CasePart part_{};
  std::ofstream stream_;
};

/// The results in a journal's file, whatever they belong to. Throws InputError if it cannot be read.
std::map<std::string, Json> read_journal(const std::filesystem::path& file);

}  // namespace mss
