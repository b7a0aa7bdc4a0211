// Who computes the scenes of `mss peers`: adapters, as programs of their own, and this program.
#include <fmt/format.h>

#include <cmath>

#include "experiments/io/installation.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/moving_body.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/studies/peers/peers.hpp"

namespace mss::studies::peers {

namespace {

using Words = std::vector<std::string>;

/// The words that start an adapter.
Words command_of(Adapter adapter) {
  const auto script = [](const char* name) {
    return (shipped_files() / "reference" / "peers" / name).string();
  };
  switch (adapter) {
    case Adapter::jolt:
      return {"node", script("jolt.mjs")};
    case Adapter::mujoco:
      return {"node", script("mujoco.mjs")};
    case Adapter::calculix:
      return {"python3", script("calculix.py")};
    case Adapter::bullet:
      return {helper_program("mss_peer_bullet").string()};
    case Adapter::own:
      break;
  }
  return {};
}

std::string not_started(Adapter adapter) {
  if (adapter == Adapter::bullet) return "built without Bullet's deformable world (libbullet-dev)";
  return fmt::format("{} is not installed", command_of(adapter)[0] == "node" ? "Node.js" : "Python");
}

/// The last line that a program wrote, without its name.
std::string last_line(const std::string& output) {
  const std::size_t end = output.find_last_not_of(" \r\n");
  if (end == std::string::npos) return "it ended without a word";
  const std::size_t begin = output.find_last_of('\n', end);
  std::string line = output.substr(begin + 1, end - begin);
  if (const std::size_t colon = line.find(": "); colon != std::string::npos && line.find(' ') > colon)
    line = line.substr(colon + 2);
  return line;
}

Scene own_scene(const Family& family, const Setting& setting, const Scene& scene) {
  Scene own = scene;
  own.solve.integrator = family.options[0];
  if (family.options.size() > 1) own.solve.nonlinear_solver = family.options[1];
  own.solve.iterations = setting.iterations;
  own.solve.threads = 1;
  if (setting.steps > 0) own.solve.dt = frame / setting.steps;
  return own;
}

}  // namespace

const std::string& Adapters::version(Adapter adapter) {
  const auto [place, is_new] = answers_.try_emplace(adapter);
  Answer& answer = place->second;
  if (is_new) {
    Words words = command_of(adapter);
    words.push_back("--version");
    const ProgramRun run = run_program(words);
    if (!run.started || run.exit_status == 127)
      answer.missing = not_started(adapter);
    else
      (run.exit_status == 0 ? answer.version : answer.missing) = last_line(run.output);
  }
  if (!answer.missing.empty()) throw NoResult{answer.missing};
  return answer.version;
}

peer::Result run_adapter(Adapters& adapters, const Family& family, const Setting& setting,
                         const peer::Exchange& exchange, const std::filesystem::path& exported, double drag) {
  adapters.version(family.adapter);
  const TemporaryDirectory folder;
  Words words = command_of(family.adapter);
  words.insert(words.end(), {exported.string(), folder.path().string(), "--step",
                             fmt::format("{:.12g}", frame / setting.steps)});
  words.insert(words.end(), family.options.begin(), family.options.end());
  if (family.adapter == Adapter::calculix) {
    if (drag > 0) words.emplace_back("--rest");
  } else {
    if (setting.iterations > 0)
      words.insert(words.end(), {"--iterations", std::to_string(setting.iterations)});
    const Words how = drag > 0 ? Words{"--drag", fmt::format("{}", drag)} : Words{"--repeat", "3"};
    words.insert(words.end(), how.begin(), how.end());
  }
  const ProgramRun run = run_program(words);
  if (run.exit_status != 0) throw NoResult{last_line(run.output)};
  return peer::read_result(folder.path(), exchange);
}

peer::Result run_family_here(const Family& family, const Setting& setting, const peer::Exchange& exchange,
                             const Progress& progress) {
  const Scene scene = own_scene(family, setting, exchange.scene);
  constexpr int most_repetitions = 3;
  constexpr double enough = 0.5;  // [s]
  peer::Result best = peer::run_own(scene, exchange, progress);
  double spent = best.wall_seconds;
  for (int i = 1; i < most_repetitions && spent < enough && best.problem.empty(); ++i) {
    peer::Result again = peer::run_own(scene, exchange, progress);
    spent += again.wall_seconds;
    if (again.cpu_seconds < best.cpu_seconds) best = std::move(again);
  }
  return best;
}

State<double> rest_here(const Family& family, const Setting& setting, const peer::Exchange& exchange,
                        double drag) {
  Scene scene = own_scene(family, setting, exchange.scene);
  if (!scene.solve.dt)
    scene.solve.dt =
        explicit_steps(find_integrator(scene.solve.integrator), exchange.system->spectral_bound(), frame).dt;
  const double dt = *scene.solve.dt, kept = std::exp(-drag * dt);
  const IntegratorInfo& info = find_integrator(scene.solve.integrator);
  const auto method = info.make<double>(method_options(scene, *exchange.system));
  State<double> state = exchange.start;
  Work work;
  const long steps = std::lround(scene.solve.duration / dt);
  for (long i = 1; i <= steps; ++i) {
    const Status status = method->advance(*exchange.system, state, double(i) * dt, work);
    if (status != Status::ok || !is_finite(state))
      throw NoResult{
          fmt::format("no rest: {}", to_string(status == Status::ok ? Status::non_finite : status))};
    state.v.array() *= kept;
    if (info.limit) method->reset();  // others keep guesses only, which are part of how they iterate
  }
  return state;
}

std::vector<Family> peer_families(bool quick) {
  const std::vector<Setting> jolt = quick ? std::vector<Setting>{{1, 5}, {1, 40}}
                                          : std::vector<Setting>{{1, 5}, {1, 20}, {1, 40}, {1, 80}, {1, 320}};
  const std::vector<Setting> flexes = quick ? std::vector<Setting>{{4}} : std::vector<Setting>{{1}, {4}};
  const std::vector<Setting> bullet =
      quick ? std::vector<Setting>{{1, 5}} : std::vector<Setting>{{1, 1}, {1, 5}, {4, 5}};
  const auto pick = [quick](const std::vector<Setting>& few, const std::vector<Setting>& all) {
    return quick ? few : all;
  };
  return {{.name = "mss Verlet", .adapter = Adapter::own, .settings = {{0}}, .options = {"verlet"}},
          {.name = "mss XPBD",
           .adapter = Adapter::own,
           .settings = pick({{5, 1}, {20, 1}}, {{2, 1}, {5, 1}, {10, 1}, {20, 1}, {40, 1}, {80, 1}}),
           .options = {"xpbd"}},
          {.name = "mss VBD",
           .adapter = Adapter::own,
           .settings = pick({{1, 10}}, {{1, 5}, {1, 20}, {1, 50}, {1, 100}, {4, 10}, {10, 10}}),
           .options = {"vbd"}},
          {.name = "mss quasi-Newton",
           .adapter = Adapter::own,
           .settings = pick({{1, 2}, {4, 2}}, {{1, 1}, {1, 2}, {1, 5}, {1, 10}, {2, 3}, {4, 3}, {8, 3}}),
           .options = {"backward_euler", "lbfgs"}},
          {.name = "Jolt", .adapter = Adapter::jolt, .settings = jolt, .in_webassembly = true},
          {.name = "MuJoCo trilinear",
           .adapter = Adapter::mujoco,
           .settings = flexes,
           .in_webassembly = true,
           .boxes_only = true},
          {.name = "MuJoCo trilinear*",
           .adapter = Adapter::mujoco,
           .settings = flexes,
           .options = {"--recalibrate", "yes", "--solref", "0.004 1"},
           .in_webassembly = true,
           .boxes_only = true},
          {.name = "MuJoCo tetrahedra",
           .adapter = Adapter::mujoco,
           .settings = quick ? std::vector<Setting>{{4}} : std::vector<Setting>{{2}, {4}},
           .options = {"--dof", "full"},
           .in_webassembly = true},
          {.name = "Bullet linear",
           .adapter = Adapter::bullet,
           .settings = bullet,
           .options = {"--model", "linear"}},
          {.name = "Bullet neo-Hookean",
           .adapter = Adapter::bullet,
           .settings = bullet,
           .options = {"--model", "neo_hookean"}},
          {.name = "Bullet neo-Hookean*",
           .adapter = Adapter::bullet,
           .settings = pick({{1, 5}}, {{1, 5}, {4, 5}}),
           .options = {"--model", "neo_hookean", "--recalibrate"}},
          {.name = "Bullet links",
           .adapter = Adapter::bullet,
           .settings = pick({{1, 10}}, {{1, 1}, {1, 10}, {1, 100}}),
           .options = {"--model", "links"},
           .has_modulus = false},
          {.name = "CalculiX C3D8I",
           .adapter = Adapter::calculix,
           .settings = {{1}},
           .options = {"--element", "C3D8I"},
           .has_planes = false}};
}

}  // namespace mss::studies::peers
