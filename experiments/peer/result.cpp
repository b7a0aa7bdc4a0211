#include "experiments/peer/result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/number_file.hpp"
#include "experiments/harness/processor_time.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/outcome.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss::peer {

namespace {

namespace fs = std::filesystem;

/// Of the time between samples: by how much they may be taken beside their times.
constexpr double tolerated_offset = 0.01;

std::string problem_of_offset(double offset, double spacing) {
  return fmt::format("samples are {} by up to {:.3g} s, and {:.3g} s apart", offset > 0 ? "late" : "early",
                     std::abs(offset), spacing);
}

/// The values of cost.json, checked.
class CostFile {
 public:
  explicit CostFile(fs::path file)
      : file_(std::move(file)), json_(Json::parse(read_file(file_), nullptr, false)) {
    if (!json_.is_object()) throw InputError(fmt::format("{} is not a JSON object", file_.string()));
  }

  std::string text(const char* key) const {
    const Json found = value(key);
    if (!found.is_string() || found.get<std::string>().empty())
      refuse(key, "a text of at least one character");
    return printable(found.get<std::string>());
  }
  double number(const char* key, bool may_be_zero) const {
    const Json found = value(key);
    const double number = found.is_number() ? found.get<double>() : -1;
    if (!(may_be_zero ? number >= 0 : number > 0) || !(number <= double(most)))
      refuse(key,
             fmt::format("a {} number up to {:g}", may_be_zero ? "non-negative" : "positive", double(most)));
    return number;
  }
  /// Nothing where it is null or missing.
  std::optional<int> count(const char* key, std::uint64_t least) const {
    const Json found = value(key);
    if (found.is_null()) return {};
    if (!found.is_number_unsigned() || found.get<std::uint64_t>() < least ||
        found.get<std::uint64_t>() > most)
      refuse(key, fmt::format("a whole number from {} to {}, or null", least, most));
    return found.get<int>();
  }
  std::string precision() const {
    std::string precision = text("precision");
    if (precision != "single" && precision != "double") refuse("precision", "\"single\" or \"double\"");
    return precision;
  }
  std::string status() const { return json_.contains("status") ? text("status") : "ok"; }
  Json value(const char* key) const { return json_.value(key, Json()); }

 private:
  static constexpr std::uint64_t most = 1000000000;
  [[noreturn]] void refuse(const char* key, std::string_view allowed) const {
    throw InputError(
        fmt::format("{}: \"{}\" = {} is not {}", file_.string(), key, value(key).dump(), allowed));
  }

  fs::path file_;
  Json json_;
};

/// Brings the rows of samples.csv to sample times and particles.
class SampleReader {
 public:
  SampleReader(const fs::path& path, const Exchange& exchange)
      : file_(path, NumberFile::Rows::may_be_none),
        exchange_(exchange),
        particles_(exchange.body->particle_count()),
        t_(file_.column("t")),
        row_of_(exchange.times.size(), std::vector<std::ptrdiff_t>(particles_, -1)) {
    for (const char* name : {"x", "y", "z"}) columns_.push_back(&file_.column(name));
    if (file_.has("vx"))
      for (const char* name : {"vx", "vy", "vz"}) columns_.push_back(&file_.column(name));
  }

  void read(Result& result) {
    result.has_velocities = columns_.size() > 3;
    result.problem = place_rows();
    if (!result.problem.empty()) return;
    for (std::size_t k = 0; k < row_of_.size(); ++k) {
      result.problem = problem_at(k);
      result.diverged = !is_finite_at(k);
      if (!result.problem.empty()) return;
      result.samples.push_back(sample_at(k));
    }
  }

 private:
  /// Says what keeps rows from having one place each.
  std::string place_rows() {
    const std::vector<std::size_t> ids = file_.ids("id");
    double offset = 0;
    for (std::size_t row = 0; row < ids.size(); ++row) {
      const double t = t_[row], k = std::round(t / exchange_.spacing);
      if (!std::isfinite(t)) return fmt::format("t is no finite number in line {}", file_.line(row));
      if (ids[row] >= particles_)
        return fmt::format("particle {} at t = {:.6g} is not one of the {} (from 0 to {})", ids[row], t,
                           particles_, particles_ - 1);
      if (!(k >= 0 && k < double(row_of_.size()))) return fmt::format("t = {:.6g} is no sample time", t);
      std::ptrdiff_t& place = row_of_[std::size_t(k)][ids[row]];
      if (place >= 0) return fmt::format("particle {} is there twice at t = {:.6g}", ids[row], t);
      place = std::ptrdiff_t(row);
      const double now = t - exchange_.times[std::size_t(k)];
      if (std::abs(now) > std::abs(offset)) offset = now;
    }
    return std::abs(offset) > tolerated_offset * exchange_.spacing
               ? problem_of_offset(offset, exchange_.spacing)
               : "";
  }

  std::string problem_at(std::size_t k) const {
    const std::vector<std::ptrdiff_t>& rows = row_of_[k];
    const double t = exchange_.times[k];
    const auto is_empty = [](const std::vector<std::ptrdiff_t>& sample) {
      return std::all_of(sample.begin(), sample.end(), [](std::ptrdiff_t row) { return row < 0; });
    };
    if (is_empty(rows))
      return std::all_of(row_of_.begin() + std::ptrdiff_t(k), row_of_.end(), is_empty)
                 ? fmt::format("samples end before t = {:.6g}", t)
                 : fmt::format("there is no sample at t = {:.6g}", t);
    for (std::size_t id = 0; id < particles_; ++id) {
      if (rows[id] < 0) return fmt::format("particle {} is missing at t = {:.6g}", id, t);
      for (const std::vector<double>* column : columns_)
        if (const double number = (*column)[std::size_t(rows[id])]; !std::isfinite(number))
          return fmt::format("{} in particle {} at t = {:.6g}", std::isnan(number) ? "NaN" : "infinity", id,
                             t);
    }
    return "";
  }

  /// Whether the numbers that are there are.
  bool is_finite_at(std::size_t k) const {
    for (const std::ptrdiff_t row : row_of_[k])
      for (const std::vector<double>* column : columns_)
        if (row >= 0 && !std::isfinite((*column)[std::size_t(row)])) return false;
    return true;
  }

  State<double> sample_at(std::size_t k) const {
    State<double> sample = exchange_.start;
    sample.t = exchange_.times[k];
    for (std::size_t id = 0; id < particles_; ++id) {
      const auto at = [&](std::size_t column) { return (*columns_[column])[std::size_t(row_of_[k][id])]; };
      const std::ptrdiff_t site = exchange_.body->sites()[id];
      sample.x.set(site, {at(0), at(1), at(2)});
      if (columns_.size() > 3) sample.v.set(site, {at(3), at(4), at(5)});
    }
    return sample;
  }

  NumberFile file_;
  const Exchange& exchange_;
  std::size_t particles_;
  const std::vector<double>& t_;
  std::vector<const std::vector<double>*> columns_;
  std::vector<std::vector<std::ptrdiff_t>> row_of_;  ///< by sample and particle; -1: there is none
};

/// The scene with a step that divides the time between samples, if it has none of its own.
Scene with_dividing_step(Scene scene, const Exchange& exchange) {
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  if (!scene.solve.dt && method.stepping == Stepping::fixed)
    scene.solve.dt = explicit_steps(method, exchange.system->spectral_bound(), exchange.spacing).dt;
  return scene;
}

/// In double precision, with velocities of the time of the positions (outcome.hpp).
template <class Real>
State<double> sample_of(const Exchange& exchange, const State<Real>& state, double lag) {
  State<double> sample = exchange.start;
  sample.t = state.t;
  for (const std::ptrdiff_t site : exchange.body->sites()) {
    sample.x.set(site, state.x.at(site));
    sample.v.set(site, state.v.at(site));
  }
  if (lag > 0) {
    Field<double> a = sample.v;
    exchange.system->acceleration(sample.t, sample.x, sample.v, a);
    sample.v.array() += lag * a.array();
  }
  return sample;
}

template <class Real>
void run(const Scene& scene, const Exchange& exchange, const Progress& progress, Result& result) {
  SceneRun<Real> run(scene, *exchange.body);
  const double lag = velocity_lag(find_integrator(scene.solve.integrator), run.dt());
  Work work;
  result.threads = run.system().threads();
  for (const double t : exchange.times) {
    if (progress.stopped()) result.problem = to_string(Status::interrupted);
    if (!result.problem.empty()) break;
    Status status = Status::ok;
    const ProcessorStopwatch of_processor;
    if (t > 0) result.wall_seconds += seconds_of([&] { status = run.advance(t, work); });
    if (t > 0) result.cpu_seconds += of_processor.seconds();
    const double offset = run.state().t - t;
    if (status == Status::ok && !is_finite(run.state())) status = Status::non_finite;
    result.diverged = status != Status::ok;
    if (result.diverged)
      result.problem = fmt::format("{} before t = {:.4g}", to_string(status), t);
    else if (std::abs(offset) > tolerated_offset * exchange.spacing)
      result.problem = problem_of_offset(offset, exchange.spacing);
    else
      result.samples.push_back(sample_of(exchange, run.state(), t > 0 ? lag : 0));
  }
  result.step = scene.solve.dt.value_or(work.steps > 0 ? run.state().t / double(work.steps) : run.state().t);
}

}  // namespace

Result read_result(const fs::path& directory, const Exchange& exchange) {
  if (!fs::is_directory(directory))
    throw InputError(
        fmt::format("{} is no folder; give one with samples.csv and cost.json", directory.string()));
  const CostFile cost(directory / "cost.json");
  Result result{.name = fs::absolute(directory / "").parent_path().filename().string(),
                .engine = cost.text("engine"),
                .version = cost.text("version"),
                .step = cost.number("step", false),
                .iterations = cost.count("iterations", 0),
                .precision = cost.precision(),
                .threads = cost.count("threads", 1).value_or(1),
                .wall_seconds = cost.number("wall_seconds", true),
                .cpu_seconds = cost.number("cpu_seconds", true),
                .settings = cost.value("settings")};
  if (const std::string status = cost.status(); status != "ok") {
    result.problem = status;
    result.diverged = status.starts_with("blew up");
  } else {
    SampleReader(directory / "samples.csv", exchange).read(result);
  }
  return result;
}

Result run_own(const Scene& own, const Exchange& exchange, const Progress& progress) {
  check_solve(own);
  const Scene scene = with_dividing_step(own, exchange);
  const bool single = scene.solve.precision == Precision::single;
  Result result{
      .name = scene.solve.integrator,
      .engine = "mss",
      .version = program_version(),
      .iterations = scene.solve.iterations > 0 ? std::optional(scene.solve.iterations) : std::nullopt,
      .precision = to_string(scene.solve.precision),
      .settings = {{"integrator", scene.solve.integrator}},
      .has_velocities = true};
  single ? run<float>(scene, exchange, progress, result) : run<double>(scene, exchange, progress, result);
  return result;
}

}  // namespace mss::peer
