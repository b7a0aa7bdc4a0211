#include "experiments/simulation/restart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <ostream>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/digest.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Of the file: a line with this, a line of JSON, and the record. To be counted up when any of them changes.
constexpr const char* first_line = "mss restart 2";

Json head_of(const Restart& restart) {
  return {{"status", to_string(restart.status)},
          {"t", restart.t},
          {"dt", restart.dt},
          {"kernel", restart.kernel},
          {"version", restart.version},
          {"build", restart.build},
          {"spring_law", restart.spring_law},
          {"body", restart.body},
          {"configuration", restart.configuration},
          {"bytes", restart.record.size()}};
}

std::string digest_of(const Json& head, std::span<const std::byte> record) {
  const std::string text = head.dump();
  Digest digest;
  digest.add(std::as_bytes(std::span(text)));
  digest.add(record);
  return digest.text();
}

Status status_named(const std::string& name) {
  for (const Status status : {Status::ok, Status::interrupted, Status::non_finite, Status::newton_stalled,
                              Status::not_positive_definite, Status::linear_stalled, Status::step_limit,
                              Status::tolerance_missed, Status::device_lost})
    if (to_string(status) == name) return status;
  throw InputError("unknown status");
}

/// Throws an exception that nobody sees for what head_of() has not written.
Restart parsed(const std::string& line, std::istream& rest) {
  Json head = Json::parse(line);
  const std::string digest = head.at("digest");
  head.erase("digest");
  Restart restart{.status = status_named(head.at("status")),
                  .t = head.at("t"),
                  .dt = head.at("dt"),
                  .kernel = head.at("kernel"),
                  .version = head.at("version"),
                  .build = head.at("build"),
                  .spring_law = head.at("spring_law"),
                  .body = head.at("body"),
                  .configuration = head.at("configuration")};
  const std::string bytes((std::istreambuf_iterator<char>(rest)), std::istreambuf_iterator<char>());
  const auto record = std::as_bytes(std::span(bytes));
  if (head.at("bytes") != record.size() || digest != digest_of(head, record))
    throw InputError("the record is another");
  restart.record.assign(record.begin(), record.end());
  return restart;
}

/// What a scene may change when it goes on.
Json that_matters(Json configuration) {
  for (const char* key : {"name", "expect"}) configuration.erase(key);
  for (const char* key : {"duration", "threads"}) configuration["solve"].erase(key);
  return configuration;
}

std::string shown(const Json& value) { return value.is_null() ? "nothing" : value.dump(); }

/// "solve.dt = 0.001, and the run had 0.002" for the first value that differs; empty: none does.
std::string difference(const std::string& key, const Json& scene, const Json& run) {
  if (scene == run) return {};
  const auto inner = [&](const std::string& name) { return key.empty() ? name : key + "." + name; };
  const auto at = [](const Json& json, const auto& name) {
    return json.contains(name) ? json.at(name) : Json();
  };
  if (scene.is_object() && run.is_object()) {
    Json both = scene;
    both.update(run);
    for (const auto& [name, value] : both.items())
      if (std::string found = difference(inner(name), at(scene, name), at(run, name)); !found.empty())
        return found;
  }
  if (scene.is_array() && run.is_array() && scene.size() == run.size())
    for (std::size_t i = 0; i < scene.size(); ++i)
      if (std::string found = difference(inner(std::to_string(i)), scene[i], run[i]); !found.empty())
        return found;
  return fmt::format("{} = {}, and the run had {}", key, shown(scene), shown(run));
}

}  // namespace

void write_restart(const fs::path& file, const Restart& restart) {
  write_atomically(file, [&](std::ostream& stream) {
    Json head = head_of(restart);
    head["digest"] = digest_of(head, restart.record);
    stream << first_line << '\n' << head.dump() << '\n';
    const auto* bytes = reinterpret_cast<const char*>(restart.record.data());
    stream.write(bytes, std::streamsize(restart.record.size()));
  });
}

Restart read_restart(const fs::path& directory) {
  const fs::path file = directory / restart_file;
  if (!fs::is_directory(directory))
    throw InputError(fmt::format("--from {}: there is no such folder; give the one that a run has written to",
                                 directory.string()));
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(
        fmt::format("--from {}: it has no {}, which a run in one process leaves; run the scene from its "
                    "beginning",
                    directory.string(), restart_file));
  std::string kind, head;
  std::getline(stream, kind);
  if (kind != first_line)
    throw InputError(fmt::format(
        "{}: another version of mss has written it; go on with that one, or run the scene from its beginning",
        file.string()));
  std::getline(stream, head);
  try {
    return parsed(head, stream);
  } catch (const std::exception&) {
    throw InputError(
        fmt::format("{}: it has been changed or cut short; run the scene from its beginning", file.string()));
  }
}

void check_restart(const Restart& restart, const Scene& scene, const fs::path& directory) {
  const std::string from = "--from " + directory.string();
  if (restart.status != Status::ok && restart.status != Status::interrupted)
    throw InputError(
        fmt::format("{}: that run ended with {} at {:.4g} s, from where nothing goes on; change "
                    "the scene, and run it from its beginning",
                    from, to_string(restart.status), restart.t));
  const std::string other = difference("", that_matters(Json::parse(Json(to_json(scene)).dump())),
                                       that_matters(restart.configuration));
  if (!other.empty())
    throw InputError(fmt::format("{}: {}: {}; only solve.duration, solve.threads and [expect] may change",
                                 from, scene.file.string(), other));
  const bool fixed = find_integrator(scene.solve.integrator).stepping == Stepping::fixed;
  const double left = scene.solve.duration - restart.t;
  if (fixed ? std::lround(left / restart.dt) > 0 : left > 0) return;
  throw InputError(
      fmt::format("{}: that run is at {:.10g} s, and solve.duration = {:.10g} s asks for no more; give a "
                  "longer one with --set solve.duration=",
                  from, restart.t, scene.solve.duration));
}

}  // namespace mss
