#include "experiments/simulation/reduced_model.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <ostream>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/digest.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

/// Of the file: a line with this, a line of JSON, and the record. To be counted up when any of them changes,
/// or what shapes a body gets.
constexpr const char* first_line_of_shapes = "mss shapes 1";

/// All that shapes depend on.
std::string key_of(const Scene& scene, const Body& body) {
  Json key = to_json(scene);
  for (const char* other : {"name", "solve", "start", "expect", "strike"}) key.erase(other);
  key["cells"] = digest_of({{body}}, scene);
  return key.dump();
}

std::optional<ReducedShapes> read_shapes(const fs::path& file, const std::string& key) {
  std::ifstream stream(file, std::ios::binary);
  std::string kind, found;
  if (!stream || !std::getline(stream, kind) || !std::getline(stream, found)) return std::nullopt;
  if (kind != first_line_of_shapes || found != key) return std::nullopt;
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const auto begin = reinterpret_cast<const std::byte*>(bytes.data());
  Record record(std::vector<std::byte>(begin, begin + bytes.size()));
  ReducedShapes shapes;
  try {
    record.keep(shapes);
    if (record.at_end()) return shapes;
  } catch (const InputError&) {  // cut short: it is written again
  }
  return std::nullopt;
}

void write_shapes(const fs::path& file, const std::string& key, ReducedShapes& shapes) {
  Record record;
  record.keep(shapes);
  const std::vector<std::byte> bytes = record.take_bytes();
  try {
    write_atomically(file, [&](std::ostream& stream) {
      stream << first_line_of_shapes << '\n' << key << '\n';
      stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    });
  } catch (const InputError&) {  // a folder that cannot be written to costs the time of another set-up
  }
}

}  // namespace

std::optional<Reduction> reduction_named(const std::string& model) {
  if (model == "modal") return Reduction::modal;
  if (model == "modal_warped") return Reduction::warped;
  if (model == "modal_cubic") return Reduction::cubic;
  return std::nullopt;
}

Scene unreduced(Scene scene) {
  if (!reduction_named(scene.model)) return scene;
  scene.model = spring_model;
  scene.modes = 0;
  return scene;
}

fs::path shapes_file(const Scene& scene) {
  if (!fs::exists(scene.file)) return {};
  return fs::path(scene.file).replace_extension(".shapes");
}

std::unique_ptr<ReducedSystem> make_reduced(const Scene& scene, const Body& body) {
  const ReductionChoice choice{.reduction = *reduction_named(scene.model), .modes = scene.modes};
  const fs::path file = shapes_file(scene);
  const std::string key = key_of(scene, body);
  std::optional<ReducedShapes> shapes = file.empty() ? std::nullopt : read_shapes(file, key);
  if (!shapes) {
    shapes = shapes_for(body, scene.environment, choice);
    if (!file.empty()) write_shapes(file, key, *shapes);
  }
  return std::make_unique<ReducedSystem>(body, scene.environment, choice, *shapes);
}

}  // namespace mss
