// mss_fuzz: gives the program damaged scenes, voxel files and meshes, and counts how it ends.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/limits.hpp"
#include "experiments/io/output.hpp"
#include "tests/fuzz/inputs.hpp"
#include "tests/fuzz/outcome.hpp"
#include "tests/fuzz/workers.hpp"

namespace mss::fuzz {

namespace {

namespace fs = std::filesystem;

struct FuzzChoice {
  std::uint64_t inputs = 10000;
  std::uint64_t first = 0;
  std::uint64_t seed = 1;
  std::int64_t only = -1;
  Campaign limits;
  std::string keep;
  std::string corpus;
  bool says_all = false;
};

void write(const fs::path& file, const std::string& content) {
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(content.data(), std::streamsize(content.size()));
}

void write_files(const fs::path& folder, const std::map<std::string, std::string>& files) {
  fs::create_directories(folder);
  for (const auto& [name, content] : files) write(folder / name, content);
}

/// Beside its files, the settings of the command line, one a line.
void keep_input(const fs::path& folder, const Seeds& seeds, const Input& input) {
  write_files(folder, seeds.companions);
  write_files(folder, input.files);
  std::string settings;
  for (const std::string& setting : input.overrides) settings += setting + "\n";
  write(folder / "settings", settings);
}

Outcome try_input(const Seeds& seeds, const FuzzChoice& choice, std::uint64_t index, const fs::path& folder) {
  const Input input = make_input(seeds, choice.seed, index);
  write_files(folder, input.files);
  return run_input(folder / "scene.toml", input.overrides);
}

/// Counts of endings by kind, as a table.
std::string count_table(const Seeds& seeds, const FuzzChoice& choice, const std::vector<Ending>& endings) {
  std::array<std::array<std::uint64_t, ending_count>, kind_names.size() + 1> counts{};
  for (std::size_t i = 0; i < endings.size(); ++i) {
    const Kind kind = make_input(seeds, choice.seed, choice.first + i).kind;
    for (const std::size_t row : {std::size_t(kind), kind_names.size()})
      ++counts[row][std::size_t(endings[i])];
  }
  std::string text = fmt::format("{:8}", "input");
  for (const char* name : ending_names) text += fmt::format("{:>13}", name);
  for (std::size_t row = 0; row < counts.size(); ++row) {
    text += fmt::format("\n{:8}", row < kind_names.size() ? kind_names[row] : "all");
    for (const std::uint64_t count : counts[row]) text += fmt::format("{:>13}", count);
  }
  return text + "\n";
}

int fuzz(const Seeds& seeds, const FuzzChoice& choice) {
  Campaign campaign = choice.limits;
  campaign.first = choice.first;
  campaign.end = choice.first + choice.inputs;
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const CampaignResult result = run_campaign(
      campaign, [&](const fs::path& folder) { write_files(folder, seeds.companions); },
      [&](std::uint64_t index, const fs::path& folder) {
        const Outcome outcome = try_input(seeds, choice, index, folder);
        if (is_mistake(outcome.ending) || choice.says_all)
          fmt::print(stderr, "input {}: {}: {:.300}\n", index, ending_names[std::size_t(outcome.ending)],
                     outcome.sentence);
        return outcome.ending;
      },
      [&](std::uint64_t done) {
        fmt::print(stderr, "{} of {} inputs in {:.0f} s\n", done, choice.inputs, seconds());
      });
  std::uint64_t mistakes = 0;
  for (std::size_t i = 0; i < result.endings.size(); ++i) {
    if (!is_mistake(result.endings[i])) continue;
    const std::uint64_t index = choice.first + i;
    if (!choice.keep.empty() && ++mistakes <= 200)
      keep_input(fs::path(choice.keep) / std::to_string(index), seeds, make_input(seeds, choice.seed, index));
  }
  fmt::print(
      "{}seed {}, {} inputs in {:.0f} s by {} processes; most memory {:.1f} MB (input {}), most time {:.2f} "
      "s (input {})\n",
      count_table(seeds, choice, result.endings), choice.seed, choice.inputs, seconds(), campaign.processes,
      result.bytes.value / 1e6, result.bytes.index, result.seconds.value, result.seconds.index);
  return std::any_of(result.endings.begin(), result.endings.end(), is_mistake) ? 1 : 0;
}

int show_one(const Seeds& seeds, const FuzzChoice& choice) {
  const Input input = make_input(seeds, choice.seed, std::uint64_t(choice.only));
  const fs::path folder = fs::path(choice.keep.empty() ? "." : choice.keep) / std::to_string(choice.only);
  keep_input(folder, seeds, input);
  fmt::print("{}\n", folder.string());
  const Outcome outcome = run_input(folder / "scene.toml", input.overrides);
  fmt::print("{}: {}\n", ending_names[std::size_t(outcome.ending)], outcome.sentence);
  return is_mistake(outcome.ending) ? 1 : 0;
}

/// A file of the corpus, as an input: a scene, a voxel file or a mesh in a scene, or settings of one.
Input corpus_input(const fs::path& file) {
  const std::string content = read_file(file);
  Input input;
  const std::string ending = file.extension().string();
  if (ending == ".toml") return {.kind = Kind::scene, .files = {{"scene.toml", content}}, .overrides = {}};
  if (ending == ".set") {
    input.files["scene.toml"] = scene_around(Kind::voxels, "parts.txt", 0);
    std::istringstream lines(content);
    for (std::string line; std::getline(lines, line);) input.overrides.push_back(line);
    return input;
  }
  for (std::size_t kind = 1; kind < mutant_files.size(); ++kind)
    if (fs::path(mutant_files[kind]).extension() == ending) input.kind = Kind(kind);
  input.files["scene.toml"] = scene_around(input.kind, file.filename().string(), 0);
  input.files[file.filename().string()] = content;
  return input;
}

/// Runs the files of a folder, whose names begin with the status they must end with. Returns how many do not.
int run_corpus(const Seeds& seeds, const fs::path& corpus, Campaign campaign) {
  std::vector<fs::path> files(fs::directory_iterator(corpus), fs::directory_iterator{});
  std::sort(files.begin(), files.end());
  campaign.end = files.size();
  const CampaignResult result = run_campaign(
      campaign, [&](const fs::path& folder) { write_files(folder, seeds.companions); },
      [&](std::uint64_t index, const fs::path& folder) {
        const Input input = corpus_input(files[index]);
        write_files(folder, input.files);
        const Outcome outcome = run_input(folder / "scene.toml", input.overrides);
        fmt::print(stderr, "{}: {}: {:.400}\n", files[index].filename().string(),
                   ending_names[std::size_t(outcome.ending)], outcome.sentence);
        return outcome.ending;
      },
      [](std::uint64_t) {});
  int wrong = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = files[i].filename().string();
    if (exit_status(result.endings[i]) == name.front() - '0') continue;
    fmt::print("{}: {} where its name says {}\n", name, ending_names[std::size_t(result.endings[i])],
               name.front());
    ++wrong;
  }
  fmt::print("{} of {} files of {} end as their names say\n", int(files.size()) - wrong, files.size(),
             corpus.string());
  return wrong > 0 || files.empty() ? 1 : 0;
}

int run(int argc, char** argv) {
  CLI::App app("Gives the program damaged scenes, voxel files and meshes, and counts how it ends.",
               "mss_fuzz");
  FuzzChoice choice;
  app.add_option("--inputs", choice.inputs, "How many");
  app.add_option("--first", choice.first, "Number of the first");
  app.add_option("--seed", choice.seed, "Of the inputs: the same seed gives the same");
  app.add_option("--only", choice.only,
                 "Writes the files of one input, runs it in this process, says how it ended");
  app.add_option("--keep", choice.keep, "Folder for the files of inputs that the program mistook");
  app.add_option("--processes", choice.limits.processes, "How many");
  app.add_option("--seconds", choice.limits.most_seconds, "Of computing that an input may take");
  app.add_flag("--sentences", choice.says_all,
               "Prints what the program says to each input, not to those alone that it mistakes");
  app.add_option("--corpus", choice.corpus,
                 "Runs the files of a folder, whose names begin with their exit status");
  CLI11_PARSE(app, argc, argv);
  limit_sites(most_sites_here);
  // in memory, unless the user says otherwise: an input takes less time than a disk to write it
  if (fs::is_directory("/dev/shm")) setenv("TMPDIR", "/dev/shm", 0);
  const Seeds seeds = make_seeds(fs::path(MSS_SOURCE_DIR) / "experiments/scenes");
  if (choice.only >= 0) return show_one(seeds, choice);
  if (!choice.corpus.empty()) return run_corpus(seeds, choice.corpus, choice.limits);
  return fuzz(seeds, choice);
}

}  // namespace

}  // namespace mss::fuzz

int main(int argc, char** argv) {
  try {
    return mss::fuzz::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "mss_fuzz: {}\n", error.what());
    return 2;
  }
}
