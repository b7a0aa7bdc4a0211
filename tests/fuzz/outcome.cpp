#include "tests/fuzz/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss::fuzz {

namespace {

constexpr std::size_t longest_sentence = 2000;  ///< bytes, as printable() leaves
constexpr long most_adaptive_steps = 20;

double site_count(const Scene& scene) {
  double sites = 1;
  for (const int cells : scene.body.voxels.size()) sites *= cells + 1;
  return sites;
}

template <class Real>
Outcome simulate_two_steps(const Scene& scene, const Body& body) {
  SceneRun<Real> run(scene, body, most_adaptive_steps);
  if (double(run.system().size()) > most_sites_stepped) return {Ending::made, ""};
  const bool fixed = find_integrator(scene.solve.integrator).stepping == Stepping::fixed;
  const double end = fixed ? 2 * run.dt() : std::min(scene.solve.duration, scene.solve.every);
  Work work;
  Status status = run.advance(std::min(end, scene.solve.duration), work);
  if (status == Status::ok && !run.measure()) status = Status::non_finite;
  if (status != Status::ok) return {Ending::failed, std::string(to_string(status))};
  return {Ending::ran, ""};
}

Outcome run_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  Scene scene = load_scene(file, overrides);
  check_solve(scene);
  scene.solve.threads = 1;
  if (is_refined(scene) && site_count(scene) > most_sites_stepped) return {Ending::made, ""};
  for (const std::string& warning : scene.warnings)
    if (const std::string fault = fault_of_sentence(warning); !fault.empty())
      return {Ending::bad_sentence, fmt::format("{}: {}", fault, warning)};
  static_cast<void>(to_json(scene).dump());
  static_cast<void>(to_toml(scene, file.parent_path()));
  const Body body(scene.body);
  return scene.solve.precision == Precision::single ? simulate_two_steps<float>(scene, body)
                                                    : simulate_two_steps<double>(scene, body);
}

/// Of our own limit, far below the program's: "... makes a lattice of 0.01 million particles ...".
bool is_of_our_limit(const std::string& sentence) {
  constexpr std::string_view words = "a lattice of ";
  const std::size_t at = sentence.find(words);
  if (at == std::string::npos) return sentence.find("splits cells into more than") != std::string::npos;
  return std::strtod(sentence.c_str() + at + words.size(), nullptr) < 200;
}

Outcome refusal(const std::string& sentence) {
  if (const std::string fault = fault_of_sentence(sentence); !fault.empty())
    return {Ending::bad_sentence, fault + ": " + sentence};
  return {is_of_our_limit(sentence) ? Ending::too_large : Ending::refused, sentence};
}

/// Bytes of the UTF-8 character that begins a text; 0 if none does.
std::size_t character_size(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t size = byte(0) < 0x80   ? 1
                           : byte(0) < 0xc2 ? 0
                           : byte(0) < 0xe0 ? 2
                           : byte(0) < 0xf0 ? 3
                           : byte(0) < 0xf5 ? 4
                                            : 0;
  if (size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return size;
}

}  // namespace

int exit_status(Ending ending) {
  if (ending == Ending::ran || ending == Ending::made) return 0;
  if (ending == Ending::refused || ending == Ending::too_large) return 2;
  return ending == Ending::failed ? 3 : -1;
}

std::string fault_of_sentence(const std::string& sentence) {
  if (sentence.empty()) return "empty";
  if (sentence.size() > longest_sentence) return "too long";
  for (std::size_t i = 0; i < sentence.size();) {
    const auto first = static_cast<unsigned char>(sentence[i]);
    const std::size_t size = character_size(std::string_view(sentence).substr(i));
    if (size == 0) return "not UTF-8";
    const bool is_control = first < 0x20 || first == 0x7f ||
                            (first == 0xc2 && static_cast<unsigned char>(sentence[i + 1]) < 0xa0);
    if (is_control) return "control character";
    i += size;
  }
  for (const char* internal :
       {"bad_alloc", "length_error", "vector::", "basic_string", "out_of_range", "stoi"})
    if (sentence.find(internal) != std::string::npos) return "names a function of a library";
  return "";
}

Outcome run_input(const std::filesystem::path& scene, const std::vector<std::string>& overrides) {
  try {
    return run_scene(scene, overrides);
  } catch (const InputError& error) {
    return refusal(error.what());
  } catch (const std::bad_alloc& error) {
    return {Ending::no_memory, error.what()};
  } catch (const std::exception& error) {
    return {Ending::exception, error.what()};
  }
}

}  // namespace mss::fuzz
