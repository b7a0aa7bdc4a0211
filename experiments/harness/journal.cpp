#include "experiments/harness/journal.hpp"

#include <fmt/format.h>

#include <limits>
#include <sstream>

#include "core/error.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Which program this is: other builds of a commit may round otherwise.
Json program() {
  return {{"version", program_version()},
          {"built", fs::last_write_time("/proc/self/exe").time_since_epoch().count()}};
}

std::string line(const std::string& name, const Json& answer) {
  return Json{{"case", name}, {"answer", answer}}.dump() + "\n";
}

}  // namespace

Journal::Journal(const fs::path& file, const Json& belongs_to) {
  const std::string head = Json{{"program", program()}, {"belongs_to", belongs_to}}.dump();
  std::string kept = head + "\n";
  if (fs::exists(file)) {
    std::istringstream lines(read_file(file));
    std::string text;
    std::getline(lines, text);
    if (text != head)
      throw InputError(fmt::format(
          "{} is the journal of an interrupted run with other options or another build; remove it "
          "to begin anew, or give another --out",
          file.string()));
    while (std::getline(lines, text)) {
      Json entry = Json::parse(text, nullptr, false);
      if (!entry.is_object() || !entry.contains("answer") || !entry.contains("case") ||
          !entry["case"].is_string())
        break;
      kept += text + "\n";
      answers_[entry["case"].get<std::string>()] = std::move(entry["answer"]);
    }
  }
  write_atomically(file, kept);
  stream_.open(file, std::ios::app);
  if (!stream_) throw InputError(fmt::format("{} cannot be written", file.string()));
}

double number(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

const Json* Journal::find(const std::string& name) const {
  const auto found = answers_.find(name);
  return found == answers_.end() ? nullptr : &found->second;
}

void Journal::add(const std::string& name, Json answer) {
  if (stream_.is_open() && !(stream_ << line(name, answer) << std::flush))
    throw InputError("the journal cannot be written any further; make room and ask again");
  answers_[name] = std::move(answer);
}

}  // namespace mss
