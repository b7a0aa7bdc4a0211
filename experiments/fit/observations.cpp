#include "experiments/fit/observations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/harness/ring_down.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_files.hpp"

namespace mss::fit {

namespace {

namespace fs = std::filesystem;

constexpr double usual_uncertainty = 0.01;  ///< of the value, or of what a series spans

const std::vector<std::pair<std::string, Kind>> kinds{{"static", Kind::at_end},
                                                      {"series", Kind::series},
                                                      {"frequency", Kind::frequency},
                                                      {"damping", Kind::damping}};

const KnownKeys& known_keys() {
  static const KnownKeys keys{{"", {"observation"}},
                              {"observation",
                               {"name", "scene", "set", "kind", "point", "column", "value", "file", "extrema",
                                "mode", "from", "until", "uncertainty"}}};
  return keys;
}

constexpr Quantity position_of_point{"a point", "three finite numbers of metres",
                                     [](double) { return true; }};
constexpr Quantity measured_value{"a value", "a finite number", [](double) { return true; }};
constexpr Quantity standard_deviation{"an uncertainty", "a positive number, in the value's unit",
                                      [](double value) { return value > 0; }};
constexpr Quantity mode_number{"a number of a mode", "a whole number from 1 to 200",
                               [](double value) { return value >= 1 && value <= 200; }};
constexpr Quantity time_of_window{"a time", "a finite number of seconds that is not negative",
                                  [](double value) { return value >= 0; }};

/// A file of measured numbers in time.
struct MeasuredSeries {
  std::vector<double> times;
  std::vector<std::pair<std::string, std::vector<double>>> columns;
};

double number_in(const std::string& cell, const std::string& column, const fs::path& file, std::size_t line) {
  double value = 0;
  const auto [end, problem] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (problem == std::errc() && end == cell.data() + cell.size() && std::isfinite(value)) return value;
  throw InputError(fmt::format("{}:{}: {} = '{}' is not a finite number; give one, or leave the row out",
                               file.string(), line, column, cell));
}

MeasuredSeries read_series(const fs::path& file) {
  std::string text = read_file(file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // the byte-order mark of a spreadsheet
  const auto rows = parse_csv(text);
  if (rows.empty() || rows.front().size() < 2 || (rows.front()[0] != "time" && rows.front()[0] != "t"))
    throw InputError(fmt::format(
        "{}: {}; give a header: time, in seconds, and the columns that were measured", file.string(),
        rows.empty() ? "the file is empty" : "the first line is not the header of a series"));
  if (rows.size() < 2) throw InputError(fmt::format("{} has no rows; give what was measured", file.string()));
  MeasuredSeries series;
  for (std::size_t c = 1; c < rows.front().size(); ++c) {
    if (std::count(rows.front().begin() + 1, rows.front().end(), rows.front()[c]) > 1)
      throw InputError(
          fmt::format("{}: column '{}' is there twice; give each once", file.string(), rows.front()[c]));
    series.columns.emplace_back(rows.front()[c], 0);
  }
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != rows.front().size())
      throw InputError(fmt::format("{}:{}: {} cells for {} columns", file.string(), r + 1, rows[r].size(),
                                   rows.front().size()));
    series.times.push_back(number_in(rows[r][0], rows.front()[0], file, r + 1));
    if (r > 1 && !(series.times[r - 1] > series.times[r - 2]))
      throw InputError(fmt::format("{}:{}: {} = {} is not later than the row before; give rows in time",
                                   file.string(), r + 1, rows.front()[0], rows[r][0]));
    for (std::size_t c = 1; c < rows[r].size(); ++c)
      series.columns[c - 1].second.push_back(number_in(rows[r][c], rows.front()[c], file, r + 1));
  }
  return series;
}

/// Reads one [[observation]] after the other, and gathers those of one run.
class Reader {
 public:
  Reader(const fs::path& file, const SceneSource& scene, const std::vector<std::string>& settings)
      : file_(file.string()), folder_(file.parent_path()), scene_(scene), settings_(settings) {}

  void read(const TomlTable& table) {
    Observation o{.place = fmt::format("{}: {}", file_, table.path())};
    if (!table.has("kind")) table.reject_missing("kind", "give static, series, frequency or damping");
    o.kind = table.choice("kind", "a kind of observation", kinds, Kind::at_end);
    if (table.has("point")) o.point = table.vector("point", position_of_point);
    if (table.has("mode")) o.mode = table.whole("mode", mode_number, 0);
    check_keys(table, o);
    o.from = table.number("from", time_of_window, o.from);
    o.until = table.number("until", time_of_window, o.until);
    if (!(o.until > o.from)) table.reject("until", "is not after from; give a later time");
    o.run = run_of(table, o.mode > 0);
    if (o.mode == 0 && o.kind != Kind::series)
      o.column = table.text("column", "a column", "x, y or z of a point, or a column of series.csv");
    if (o.kind == Kind::series)
      read_series_of(table, o);
    else
      read_value_of(table, o);
  }
  Observations take() { return std::move(data_); }

  /// The columns of a file, each an observation.
  void add_series(const MeasuredSeries& series, const Observation& common, double uncertainty) {
    for (const auto& [column, values] : series.columns) {
      Observation o = common;
      o.column = column;
      o.times = series.times;
      o.measured = values;
      const auto [least, most] = std::minmax_element(values.begin(), values.end());
      o.uncertainty = uncertainty > 0 ? uncertainty : usual_uncertainty * (*most - *least);
      if (!(o.uncertainty > 0))
        throw InputError(
            fmt::format("{}: column {} does not change, so its uncertainty must be given: "
                        "uncertainty = NUMBER",
                        o.place, column));
      add(std::move(o));
    }
  }
  std::size_t run_of_scene(const SceneSource& source, const std::vector<std::string>& settings, bool modes) {
    const std::string key = fmt::format("{}\n{}\n{}", source.identity, fmt::join(settings, "\n"), modes);
    const auto found = std::find(keys_.begin(), keys_.end(), key);
    if (found != keys_.end()) return std::size_t(found - keys_.begin());
    keys_.push_back(key);
    data_.runs.push_back({.load =
                              [source, settings](const std::vector<std::string>& more) {
                                std::vector<std::string> all = settings;
                                all.insert(all.end(), more.begin(), more.end());
                                return source.load(all);
                              },
                          .modes = modes});
    return keys_.size() - 1;
  }

 private:
  void check_keys(const TomlTable& table, const Observation& o) const {
    const bool rings = o.kind == Kind::frequency || o.kind == Kind::damping;
    if (o.mode > 0 && o.kind != Kind::frequency)
      table.reject("mode", "is a vibration without damping; it is for kind = \"frequency\"");
    for (const char* key : {"point", "column", "file", "extrema", "from", "until"})
      if (o.mode > 0 && table.has(key))
        table.reject(key, fmt::format("means nothing for {}.mode; leave one of them out", table.path()));
    for (const char* key : {"extrema", "from", "until"})
      if (!rings && table.has(key))
        table.reject(key, "is about a ring-down; it is for kind = \"frequency\" and \"damping\"");
    if (o.kind == Kind::series)
      for (const char* key : {"value", "column"})
        if (table.has(key)) table.reject(key, "is not for a series; the file's header names its columns");
    if (o.kind == Kind::at_end && table.has("file"))
      table.reject("file", "is about time; give value, or kind = \"series\"");
  }

  std::size_t run_of(const TomlTable& table, bool modes) {
    std::vector<std::string> settings = settings_;
    if (table.has("set"))
      for (std::string& text :
           table.texts("set", "a list of settings", "[\"table.key=value\", ...], as --set takes them"))
        settings.push_back(std::move(text));
    if (!table.has("scene")) return run_of_scene(scene_, settings, modes);
    const std::string given =
        table.text("scene", "a scene", "a scene file, or a name from `mss list scenes`");
    const bool is_here = fs::exists(folder_ / given);
    return run_of_scene(source_of(is_here ? folder_ / given : scene_file(given)), settings, modes);
  }

  void read_series_of(const TomlTable& table, Observation& o) {
    const fs::path file = folder_ / table.text("file", "a file name", "a CSV file, relative to this one");
    o.name = table.has("name") ? table.text("name", "a name", "a text") : "";
    add_series(read_series(file), o, table.number("uncertainty", standard_deviation, 0));
  }

  void read_value_of(const TomlTable& table, Observation& o) {
    if (table.has("file") == table.has("value")) {
      if (table.has("value")) table.reject("value", "conflicts with the file; give one of the two");
      table.reject_missing("value", "give what was measured");
    }
    const double value = table.has("value") ? table.number("value", measured_value) : value_in_file(table, o);
    check_range(table, o, value);
    o.measured = {value};
    o.uncertainty = table.number("uncertainty", standard_deviation, usual_uncertainty * std::abs(value));
    if (!(o.uncertainty > 0))
      table.reject_missing("uncertainty", "a value of 0 does not give one; give a positive number");
    o.name = table.has("name") ? table.text("name", "a name", "a text") : "";
    add(std::move(o));
  }

  static void check_range(const TomlTable& table, const Observation& o, double value) {
    const char* key = table.has("value") ? "value" : "file";
    if (o.kind == Kind::frequency && !(value > 0))
      table.reject(key, "is not a frequency; give a positive number of hertz");
    if (o.kind == Kind::damping && !(value > 0 && value < 1))
      table.reject(key,
                   fmt::format("{}is not a damping ratio of a vibration; give a number above 0 and below "
                               "1, 0.05 for 5 percent",
                               key == std::string("file") ? fmt::format("gives {:g}, which ", value) : ""));
  }

  /// Of a measured ring-down, by what finds it in the computed one.
  double value_in_file(const TomlTable& table, const Observation& o) const {
    const fs::path file = folder_ / table.text("file", "a file name", "a CSV file, relative to this one");
    const MeasuredSeries series = read_series(file);
    const auto found = std::find_if(series.columns.begin(), series.columns.end(),
                                    [&](const auto& column) { return column.first == o.column; });
    if (found == series.columns.end())
      table.reject("column",
                   fmt::format("is not in {}, whose columns are {}", file.string(), names_of(series)));
    std::vector<double> times, values;
    std::vector<Extremum> turns;
    for (std::size_t i = 0; i < series.times.size(); ++i) {
      if (series.times[i] < o.from || series.times[i] > o.until) continue;
      times.push_back(series.times[i]);
      values.push_back(found->second[i]);
      turns.push_back({times.back(), values.back()});
    }
    if (!table.boolean("extrema", false)) turns = turning_points(times, values);
    const RingDown ring = ring_down(turns);
    if (ring.status != "ok")
      table.reject("file",
                   fmt::format("is no ring-down between {}.from and until, where it has {} maxima and "
                               "minima: {}",
                               table.path(), turns.size(), ring.status));
    return o.kind == Kind::frequency ? ring.frequency : ring.swing_damping_ratio;
  }
  static std::string names_of(const MeasuredSeries& series) {
    std::string names;
    for (const auto& [name, values] : series.columns) names += (names.empty() ? "" : ", ") + name;
    return names;
  }

  void add(Observation o) {
    const std::string number = fmt::format("{}", data_.observations.size() + 1);
    if (o.name.empty()) o.name = fmt::format("{} {}", number, to_string(o.kind));
    if (o.kind == Kind::series && o.name.find(o.column) == std::string::npos) o.name += " " + o.column;
    data_.observations.push_back(std::move(o));
  }

  std::string file_;
  fs::path folder_;
  const SceneSource& scene_;
  const std::vector<std::string>& settings_;
  std::vector<std::string> keys_;  ///< of the runs
  Observations data_;
};

Observations read_toml(const TomlFile& toml, Reader reader) {
  const std::vector<TomlTable> tables = TomlTable(toml).tables("observation");
  if (tables.empty())
    throw InputError(fmt::format("{} has no [[observation]]; give what was measured", toml.file().string()));
  for (const TomlTable& table : tables) reader.read(table);
  return reader.take();
}

}  // namespace

const std::string& to_string(Kind kind) { return kinds[std::size_t(kind)].first; }

SceneSource source_of(const fs::path& file) {
  return {fs::weakly_canonical(file).string(), [file](const std::vector<std::string>& settings) {
            return load_matched_scene(file, settings).scene;
          }};
}

Observations read_observations(const fs::path& file, const SceneSource& scene,
                               const std::vector<std::string>& settings) {
  Reader reader(file, scene, settings);
  if (file.extension() != ".csv") return read_toml(TomlFile(file, {}, known_keys()), std::move(reader));
  reader.add_series(
      read_series(file),
      {.place = file.string(), .kind = Kind::series, .run = reader.run_of_scene(scene, settings, false)}, 0);
  return reader.take();
}

Observations read_observations_text(const std::string& toml, const SceneSource& scene,
                                    const std::vector<std::string>& settings) {
  return read_toml(TomlFile(toml, "data", {}, known_keys()), Reader("data", scene, settings));
}

}  // namespace mss::fit
