#include "experiments/harness/journal.hpp"

#include <fmt/format.h>

#include <sstream>

#include "core/base/error.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Identifies the build: another one of the same commit may round differently.
Json program() {
  return {{"version", program_version()},
          {"built", fs::last_write_time("/proc/self/exe").time_since_epoch().count()}};
}

std::string line(const std::string& name, const Json& result) {
  return Json{{"case", name}, {"result", result}}.dump() + "\n";
}

/// The lines of results behind the first line, and the results; a line that was cut short and those after it
/// are dropped.
std::string read_results(std::istringstream& lines, std::map<std::string, Json>& results) {
  std::string kept, text;
  while (std::getline(lines, text)) {
    Json entry = Json::parse(text, nullptr, false);
    if (!entry.is_object() || !entry.contains("result") || !entry.contains("case") ||
        !entry["case"].is_string())
      break;
    kept += text + "\n";
    results[entry["case"].get<std::string>()] = std::move(entry["result"]);
  }
  return kept;
}

/// Whether a journal's first line differs from `now` in the program alone.
bool is_of_another_build(const std::string& line, Json now) {
  Json before = Json::parse(line, nullptr, false);
  if (!before.is_object() || !before.contains("program")) return false;
  before.erase("program");
  now.erase("program");
  return before == now;
}

/// Results of another build are no part of this run, and may have taken hours.
void keep_aside(const fs::path& file) {
  fs::path aside = file;
  aside += ".before";
  fs::rename(file, aside);
  fmt::print(stderr, "mss: {} is of another build: kept as {}, and starting again\n", file.string(),
             aside.filename().string());
}

}  // namespace

Journal::Journal(const fs::path& file, const Json& belongs_to, const CasePart& part) : part_(part) {
  Json first{{"program", program()}, {"belongs_to", belongs_to}};
  if (!part.is_whole()) first["part"] = {part.index, part.count};
  const std::string head = first.dump();
  std::string kept = head + "\n";
  if (fs::exists(file)) {
    std::istringstream lines(read_file(file));
    std::string text;
    std::getline(lines, text);
    if (text == head)
      kept += read_results(lines, results_);
    else if (is_of_another_build(text, first))
      keep_aside(file);
    else
      throw InputError(
          fmt::format("{} is the journal of an interrupted run with other options; delete it to start again, "
                      "or choose another --out",
                      file.string()));
  }
  write_atomically(file, kept);
  stream_.open(file, std::ios::app);
  if (!stream_) throw InputError(fmt::format("{} cannot be written", file.string()));
}

std::map<std::string, Json> read_journal(const fs::path& file) {
  std::istringstream lines(read_file(file));
  std::string first;
  std::getline(lines, first);
  std::map<std::string, Json> results;
  read_results(lines, results);
  return results;
}

double number(const Json& value) { return value.is_null() ? no_value : value.get<double>(); }

const Json* Journal::find(const std::string& name) const {
  const auto found = results_.find(name);
  return found == results_.end() ? nullptr : &found->second;
}

void Journal::add(const std::string& name, Json result) {
  if (stream_.is_open() && !(stream_ << line(name, result) << std::flush))
    throw InputError("the journal cannot be written; free disk space and run the same command again");
  results_[name] = std::move(result);
}

}  // namespace mss
