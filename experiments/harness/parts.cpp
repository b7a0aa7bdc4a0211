// Parts of an experiment on several machines, and their results together.
#include "experiments/harness/parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

constexpr const char* part_file = "part.json";

Json to_json(const ExperimentOptions& o) {
  return {{"quick", o.quick}, {"cells", o.cells},     {"integrators", o.integrators},
          {"model", o.model}, {"threads", o.threads}, {"seed", o.seed}};
}

ExperimentOptions options_from(const Json& json) {
  return {.quick = json.at("quick").get<bool>(),
          .cells = json.at("cells").get<std::vector<int>>(),
          .integrators = json.at("integrators").get<std::vector<std::string>>(),
          .threads = json.at("threads").get<int>(),
          .model = json.at("model").get<std::string>(),
          .seed = json.at("seed").get<std::uint64_t>()};
}

/// A part.json that was read.
struct PartFound {
  fs::path directory;
  std::string experiment, program, machine;
  CasePart part;
  Json options, configuration;
  std::optional<OtherWork> other_work;
};

/// What tells machines apart where times are compared.
std::string machine_of(const Json& provenance) {
  return fmt::format("{}, {} cores", provenance.at("cpu").get<std::string>(),
                     provenance.at("cores_available").get<int>());
}

PartFound read_part(const fs::path& directory) {
  const fs::path file = directory / part_file;
  if (!fs::exists(file))
    throw InputError(
        fmt::format("{} holds no complete part: it has no {}, which a run with --part i/N leaves at its end",
                    directory.string(), part_file));
  const Json json = Json::parse(read_file(file), nullptr, false);
  try {
    return {.directory = directory,
            .experiment = json.at("experiment").get<std::string>(),
            .program = json.at("program").get<std::string>(),
            .machine = machine_of(json.at("provenance")),
            .part = {.index = json.at("part").at(0).get<int>(), .count = json.at("part").at(1).get<int>()},
            .options = json.at("options"),
            .configuration = json.at("configuration"),
            .other_work = other_work_in(json.at("provenance"))};
  } catch (const Json::exception&) {
    throw InputError(fmt::format("{} is damaged; run that part again", file.string()));
  }
}

[[noreturn]] void refuse_to_mix(const PartFound& a, const PartFound& b, const std::string& what,
                                const std::string& of_a, const std::string& of_b) {
  throw InputError(fmt::format("{} and {} cannot be merged: {} {} and {}", a.directory.string(),
                               b.directory.string(), what, of_a, of_b));
}

void check_alike(const PartFound& a, const PartFound& b, bool timed) {
  if (a.experiment != b.experiment)
    refuse_to_mix(a, b, "they are of the experiments", a.experiment, b.experiment);
  if (a.part.count != b.part.count)
    refuse_to_mix(a, b, "their experiment was cut into numbers of parts,", fmt::format("{}", a.part.count),
                  fmt::format("{}", b.part.count));
  if (a.program != b.program) refuse_to_mix(a, b, "they were computed by", a.program, b.program);
  if (a.options != b.options) refuse_to_mix(a, b, "their options are", a.options.dump(), b.options.dump());
  if (timed && a.machine != b.machine)
    refuse_to_mix(a, b, "their times are of different machines,", a.machine, b.machine);
}

void check_complete(const std::vector<PartFound>& parts) {
  const int count = parts.front().part.count;
  std::vector<const PartFound*> found(std::size_t(count), nullptr);
  for (const PartFound& part : parts) {
    const PartFound*& place = found.at(std::size_t(part.part.index - 1));
    if (place != nullptr)
      throw InputError(fmt::format("{} and {} are both part {}/{}; give each part once",
                                   place->directory.string(), part.directory.string(), part.part.index,
                                   count));
    place = &part;
  }
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i] == nullptr) missing.push_back(fmt::format("{}/{}", i + 1, count));
  if (!missing.empty())
    throw InputError(fmt::format("of {} {} missing: {}; run {} with --part and the same options",
                                 parts.front().experiment, missing.size() == 1 ? "a part is" : "parts are",
                                 fmt::join(missing, ", "), missing.size() == 1 ? "it" : "them"));
}

}  // namespace

bool CasePart::has(std::string_view group) const {
  if (group.empty() || is_whole()) return true;
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  for (const char letter : group) hash = (hash ^ std::uint8_t(letter)) * 1099511628211U;
  return int(hash % std::uint64_t(count)) == index - 1;
}

CasePart parse_part(std::string_view text) {
  constexpr int most = 100000;
  CasePart part;
  const char* end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, part.index);
  if (first == std::errc() && slash != end && *slash == '/')
    if (const auto [rest, second] = std::from_chars(slash + 1, end, part.count);
        second == std::errc() && rest == end && part.count <= most && part.index >= 1 &&
        part.index <= part.count)
      return part;
  throw InputError(
      fmt::format("--part {} is no part; give i/N with i from 1 to N and N up to {}, as in 2/5", text, most));
}

Report run_part(const ExperimentInfo& info, ExperimentOptions options, const fs::path& directory) {
  prepare_directory(directory);
  const DirectoryClaim claim(directory);
  fs::remove(directory / part_file);
  options.journal = directory / (info.name + ".journal");
  Report report{.name = info.name, .resumable = true, .provenance = provenance()};
  const OtherWorkWatch others;
  ExperimentResult result;
  {
    TerminalProgress progress(info.name);
    result = info.run(options, progress);
  }
  report.provenance["other_work"] = to_json(others.so_far());
  report.status = result.status;
  if (result.status != Status::ok) return report;
  const Json part{{"experiment", info.name},
                  {"part", {options.part.index, options.part.count}},
                  {"program", program_version()},
                  {"options", to_json(options)},
                  {"configuration", result.configuration},
                  {"provenance", report.provenance}};
  write_atomically(directory / part_file, part.dump(2) + "\n");
  report.files = {options.journal, directory / part_file};
  return report;
}

PartsFound merge_parts(const std::vector<fs::path>& directories, const fs::path& directory) {
  std::vector<PartFound> parts;
  parts.reserve(directories.size());
  for (const fs::path& one : directories) parts.push_back(read_part(one));
  const ExperimentInfo& info = find_experiment(parts.front().experiment);
  for (const PartFound& part : parts) check_alike(parts.front(), part, info.times);
  check_complete(parts);
  if (parts.front().program != program_version())
    throw InputError(
        fmt::format("{} was computed by {}, and this is {}; merge with the program that computed",
                    parts.front().directory.string(), parts.front().program, program_version()));
  prepare_directory(directory);
  const fs::path file = directory / (info.name + ".journal");
  fs::remove(file);
  Journal journal(file, parts.front().configuration);
  for (const PartFound& part : parts)
    for (auto& [name, result] : read_journal(part.directory / (info.name + ".journal")))
      if (journal.find(name) == nullptr) journal.add(name, std::move(result));
  std::optional<OtherWork> other_work;
  for (const PartFound& part : parts) other_work = more_of(other_work, part.other_work);
  return {.info = &info, .options = options_from(parts.front().options), .other_work = other_work};
}

}  // namespace mss
