// The sources themselves: includes run one way, and no namespace has two types of one name.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace mss {
namespace {

namespace fs = std::filesystem;

/// Where an include may lead: to its own folder and to those of lower rank, so not between folders of one
/// rank, such as studies. The longest folder that a file is in counts.
struct Folder {
  std::string path;
  int rank;
};
const std::vector<Folder> folders{{"core/base", 0},
                                  {"core/system", 1},
                                  {"core/forces", 2},
                                  {"core/kernels", 3},
                                  {"core/body", 3},
                                  {"core/mesh", 4},
                                  {"core/environment", 5},
                                  {"core/springs", 6},
                                  {"core/measures", 7},
                                  {"core/refinement", 7},
                                  {"core/device", 7},
                                  {"core/bodies", 8},
                                  {"core/scene", 9},
                                  {"integrators", 10},
                                  {"integrators/device", 11},
                                  {"integrators/linear", 11},
                                  {"integrators/explicit", 12},
                                  {"integrators/position_based", 12},
                                  {"integrators/nonlinear", 12},
                                  {"integrators/sundials", 12},
                                  {"integrators/implicit", 13},
                                  {"integrators/statics", 13},
                                  {"integrators/analysis", 14},
                                  {"integrators/reduction", 15},
                                  {"integrators/registry", 14},
                                  {"reference", 10},
                                  {"experiments/io", 20},
                                  {"experiments/plot", 21},
                                  {"experiments/harness", 22},
                                  {"experiments/simulation", 23},
                                  {"experiments/advise", 24},
                                  {"experiments/fit", 24},
                                  {"experiments/view", 24},
                                  {"experiments/peer", 24},
                                  {"experiments/studies", 25},
                                  {"experiments/cli", 26},
                                  {"experiments/python", 26},
                                  {"tests", 30}};

/// The folder and rank of a file; every study is a folder of its own. An empty path for a file in none.
Folder folder_of(const std::string& file) {
  Folder found{"", -1};
  for (const Folder& folder : folders)
    if (file.starts_with(folder.path + "/") && folder.path.size() > found.path.size()) found = folder;
  if (found.path == "experiments/studies") found.path = file.substr(0, file.find('/', found.path.size() + 1));
  return found;
}

/// The oracle and what it judges know nothing of each other.
bool are_apart(const std::string& a, const std::string& b) {
  const auto is = [](const std::string& path, const char* top) { return path.starts_with(top); };
  return (is(a, "integrators") && is(b, "reference")) || (is(a, "reference") && is(b, "integrators"));
}

using Sources = std::map<std::string, std::string>;  ///< text by path

std::vector<std::string> wrong_includes(const Sources& sources) {
  static const std::regex include("#include \"([^\"]+)\"");
  std::vector<std::string> wrong;
  for (const auto& [file, text] : sources)
    for (std::sregex_iterator i(text.begin(), text.end(), include), end; i != end; ++i) {
      const Folder from = folder_of(file), to = folder_of((*i)[1]);
      if (from.rank < 0 || to.rank < 0 || are_apart(from.path, to.path) ||
          (to.path != from.path && to.rank >= from.rank))
        wrong.push_back(fmt::format("{} includes {}", file, (*i)[1].str()));
    }
  return wrong;
}

/// Types defined in two files under one qualified name; those in anonymous namespaces are their file's own.
/// Reads the closing comments that clang-format keeps, and definitions that begin a line.
std::vector<std::string> types_defined_twice(const Sources& sources) {
  static const std::regex line_of_interest(
      R"(^(?:namespace ([\w:]*) ?\{|(\}  // namespace.*)|(?:struct|class|enum class) (?:alignas\(\w+\) )?([\w:]+)(?: final)?(?: :[^;]*)? \{.*)$)");
  std::map<std::string, std::string> first;
  std::vector<std::string> twice;
  for (const auto& [file, text] : sources) {
    std::vector<std::string> space;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (!std::regex_match(line, match, line_of_interest)) continue;
      if (match[2].matched) {
        if (!space.empty()) space.pop_back();
      } else if (!match[3].matched) {
        space.push_back(match[1].str().empty() ? file : match[1].str());
      } else {
        std::string name;
        for (const std::string& part : space) name += part + "::";
        name += match[3];
        if (const auto [entry, is_new] = first.emplace(name, file); !is_new)
          twice.push_back(fmt::format("{} in {} and {}", name, entry->second, file));
      }
    }
  }
  return twice;
}

Sources all_sources() {
  const fs::path root = MSS_SOURCE_DIR;
  Sources sources;
  for (const char* folder : {"core", "integrators", "reference", "experiments", "tests"})
    for (const fs::path& path : fs::recursive_directory_iterator(root / folder))
      if (path.extension() == ".cpp" || path.extension() == ".hpp") {
        std::ostringstream text;
        text << std::ifstream(path).rdbuf();
        sources[fs::relative(path, root).string()] = text.str();
      }
  return sources;
}

TEST(Sources, IncludeDownwardsOnly) {
  const Sources sources = all_sources();
  EXPECT_GT(sources.size(), 200U);
  EXPECT_EQ(wrong_includes(sources), std::vector<std::string>{});
}

TEST(Sources, APlantedIncludeIsFound) {
  const auto wrong = [](const std::string& file, const std::string& included) {
    return wrong_includes({{file, "#include \"" + included + "\"\n"}}).size() == 1;
  };
  EXPECT_TRUE(wrong("core/body/body.hpp", "integrators/integrator.hpp"));
  EXPECT_TRUE(wrong("core/body/body.hpp", "core/springs/spring_system.hpp"));
  EXPECT_TRUE(wrong("core/body/body.hpp", "core/environment/environment.hpp"));  // of one rank
  EXPECT_TRUE(wrong("core/body.hpp", "core/base/field.hpp"));                    // in no room
  EXPECT_TRUE(wrong("integrators/linear/pcg.cpp", "integrators/nonlinear/implicit_stage.hpp"));
  EXPECT_TRUE(wrong("integrators/explicit/verlet.cpp", "reference/closed_forms.hpp"));
  EXPECT_TRUE(wrong("reference/closed_forms.cpp", "integrators/integrator.hpp"));
  EXPECT_TRUE(wrong("experiments/plot/chart.cpp", "experiments/harness/table.hpp"));
  EXPECT_TRUE(wrong("experiments/studies/atlas/runs.cpp", "experiments/studies/stability/stability.hpp"));
  EXPECT_TRUE(wrong("experiments/advise/advise.cpp", "experiments/view/session.hpp"));
  EXPECT_TRUE(wrong("experiments/harness/table.cpp", "tests/random_bodies.hpp"));
  EXPECT_TRUE(wrong("experiments/harness/table.cpp", "table.hpp"));  // of no folder
  EXPECT_FALSE(wrong("experiments/studies/atlas/runs.cpp", "experiments/studies/atlas/atlas.hpp"));
  EXPECT_FALSE(wrong("experiments/cli/run_command.cpp", "core/base/error.hpp"));
}

TEST(Sources, NoTypeIsDefinedTwice) {
  EXPECT_EQ(types_defined_twice(all_sources()), std::vector<std::string>{});
}

TEST(Sources, APlantedTypeIsFound) {
  const std::string text = "namespace mss::advise {\n\nstruct Trial {\n};\n\n}  // namespace mss::advise\n";
  const std::string own =
      "namespace mss::advise {\n\nnamespace {\n\nclass Trial final : public Base {\n};\n\n}  // "
      "namespace\n\n}  // namespace mss::advise\n";
  EXPECT_EQ(types_defined_twice({{"a.hpp", text}, {"b.hpp", text}}),
            std::vector<std::string>{"mss::advise::Trial in a.hpp and b.hpp"});
  EXPECT_EQ(types_defined_twice({{"a.hpp", text}, {"b.cpp", own}, {"c.cpp", own}}),
            std::vector<std::string>{});
}

}  // namespace
}  // namespace mss
