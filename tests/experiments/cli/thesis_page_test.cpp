// reference/THESIS.md: the program knows every command, option and scene named there, and the files exist.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>

#include "experiments/harness/experiment.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "tests/matches.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

using testing::matches;

/// What is wrong with a command line after `mss`; empty: nothing.
std::string fault_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  if (words.empty()) return "no command";
  std::vector<std::string> command{MSS_PROGRAM, words.front()};
  words.erase(words.begin());
  const auto& all = experiments();
  const auto two = [&](const ExperimentInfo& e) {
    return !words.empty() && e.command() == command[1] + " " + words[0];
  };
  if (std::any_of(all.begin(), all.end(), two)) {
    command.push_back(words.front());
    words.erase(words.begin());
  }
  command.emplace_back("--help");
  static std::map<std::string, ProgramRun> helps;
  const std::string key = command.size() > 3 ? command[1] + " " + command[2] : command[1];
  if (!helps.contains(key)) helps[key] = run_program(command);
  if (helps[key].exit_status != 0) return "no command " + key;
  const bool takes_scenes = helps[key].output.find("cene") != std::string::npos;
  bool value = false;  // of an option
  for (const std::string& word : words) {
    const bool option = word.starts_with("--");
    if (option && helps[key].output.find(word) == std::string::npos)
      return fmt::format("{} has no {}", key, word);
    if (!option && !value && takes_scenes && !fs::exists(scene_file(word))) return "no scene " + word;
    value = option || (value && word.find('=') != std::string::npos);
  }
  return {};
}

TEST(ThesisPage, NamesCommandsThatExist) {
  const std::string page = read_file(fs::path(MSS_SOURCE_DIR) / "reference/THESIS.md");
  const std::vector<std::string> lines = matches(page, "`mss ([^`]+)`");
  EXPECT_GT(lines.size(), 20U);
  for (const std::string& line : lines) EXPECT_EQ(fault_of(line), "") << line;
}

TEST(ThesisPage, APlantedFaultIsFound) {
  EXPECT_NE(fault_of("theses"), "");
  EXPECT_NE(fault_of("thesis --quicker"), "");
  EXPECT_THROW(fault_of("check fig2_1_crumble"), std::exception);
  EXPECT_EQ(fault_of("validate contact --quick"), "");
  EXPECT_EQ(fault_of("run fig2_1_crumple --set body.topology=\"full\""), "");
}

// A test is written `Suite.Name`, and so in a file of tests/.
TEST(ThesisPage, NamesTestsAndFilesThatExist) {
  const fs::path root = MSS_SOURCE_DIR;
  const std::string page = read_file(root / "reference/THESIS.md");
  std::string tests;
  for (const fs::path& path : fs::recursive_directory_iterator(root / "tests"))
    if (path.extension() == ".cpp") tests += read_file(path);
  for (const std::string& test : matches(page, "`([A-Z]\\w+\\.[A-Z]\\w+)`")) {
    const std::size_t dot = test.find('.');
    const std::string suite = test.substr(0, dot), name = test.substr(dot + 1);
    EXPECT_NE(tests.find(fmt::format("({}, {})", suite, name)), std::string::npos) << test;
  }
  for (const std::string& link : matches(page, "\\]\\(([^)# ]+)"))
    EXPECT_TRUE(fs::exists(root / "reference" / link)) << link;
}

}  // namespace
}  // namespace mss
