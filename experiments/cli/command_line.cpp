#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <new>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/launched_ranks.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/provenance.hpp"

namespace mss::cli {

namespace {

constexpr const char* exit_status_help =
    "Exit status: 0 done; 1 a check failed; 2 bad input or usage; 3 the simulation failed; 130 interrupted "
    "by Ctrl-C,\n"
    "finished rows kept. Messages go to stderr, data to stdout or files.";

/// The command on the command line, or the program if there is none.
const CLI::App& chosen(const CLI::App& app) {
  const auto next = app.get_subcommands();
  return next.empty() ? app : chosen(*next.front());
}

/// The command that shows what is allowed where an error occurred.
std::string help_hint(const CLI::App& app) {
  std::string words;
  for (const CLI::App* command = &chosen(app); command != &app; command = command->get_parent())
    words.insert(0, command->get_name() + " ");
  return fmt::format("`mss {}--help`", words);
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

/// The names an app's options can be given by.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Reports a first word that is neither command nor option; CLI11 would only report that a command is
/// missing.
void check_first_word(const CLI::App& app, int argc, char** argv) {
  const std::vector<std::string> commands = command_names(app), options = option_names(app);
  if (argc < 2)
    throw InputError(
        fmt::format("give a command: {}; `mss --help` describes them", fmt::join(commands, ", ")));
  const std::string word = argv[1];
  const bool option = !word.empty() && word[0] == '-';
  const std::vector<std::string>& known = option ? options : commands;
  if (contains(known, word)) {
    if (!option && word != "run" && launch().count > 1)
      throw InputError(fmt::format(
          "`mss {}` is for one process, and {} were started; `mss run` alone is for several, so start it "
          "without mpirun",
          word, launch().count));
    return;
  }
  throw InputError(fmt::format("{} '{}' is unknown; {}`mss --help` shows all", option ? "option" : "command",
                               word, question(word, known)));
}

/// One sentence about unexpected arguments.
std::string unexpected(const CLI::App& app) {
  const std::vector<std::string> extra = app.remaining(true);
  const auto option =
      std::find_if(extra.begin(), extra.end(), [](const auto& e) { return e.rfind("--", 0) == 0; });
  if (option == extra.end())
    return fmt::format("'{}' is one argument too many; {} shows what is allowed",
                       extra.empty() ? "" : extra.front(), help_hint(app));
  const std::string name = option->substr(0, option->find('='));
  const std::vector<std::string> known = option_names(chosen(app));
  if (contains(known, name))
    return fmt::format("{} stands before `{}`, whose option it is; put it after that", name,
                       chosen(app).get_name());
  return fmt::format("option '{}' is unknown; {}{} shows all", name, question(name, known), help_hint(app));
}

/// The arguments, last first as CLI11 takes them, with a `--set` before each of several settings that follow
/// one: a word with an equals sign is a setting, the first without ends them.
std::vector<std::string> reversed_arguments(int argc, char** argv) {
  const std::string set = "--set";
  std::vector<std::string> words;
  bool after_setting = false;
  for (const std::string& word : std::vector<std::string>(argv + 1, argv + argc)) {
    const bool first = !words.empty() && words.back() == set;
    const bool further = after_setting && !word.starts_with('-') && word.find('=') != std::string::npos;
    if (further) words.push_back(set);
    words.push_back(word);
    after_setting = first || further || word.starts_with(set + "=");
  }
  std::reverse(words.begin(), words.end());
  return words;
}

int fail(const std::string& sentence, ExitStatus status) {
  if (speaks_for_all()) fmt::print(stderr, "mss: {}\n", sentence);
  return status;
}

/// Parse errors of CLI11 other than requests for help.
int usage_error(const CLI::App& app, const CLI::ParseError& error) {
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) return fail(unexpected(app), exit_bad_input);
  std::string sentence = error.what();
  const std::string unreadable = "Could not convert: ";  // then "--threads = x"
  if (sentence.rfind(unreadable, 0) == 0)
    sentence = sentence.substr(unreadable.size()) + " is not a number of the kind expected";
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  return fail(fmt::format("{}; {} shows what is allowed", sentence, help_hint(app)), exit_bad_input);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App app("Real-time deformable solids of masses and springs, benchmarked and validated.", "mss");
  app.set_version_flag("--version", "mss " + program_version());
  app.require_subcommand(1);
  app.footer(exit_status_help);
  app.get_formatter()->column_width(34);
  int exit_status = exit_ok;
  watch_interrupts();
  try {
    for (const Command add : commands()) add(app, exit_status);
    check_first_word(app, argc, argv);
    app.parse(reversed_arguments(argc, argv));
    return exit_status;
  } catch (const CLI::Success& request) {  // --help, --version
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error);
  } catch (const InputError& error) {
    return fail(error.what(), exit_bad_input);
  } catch (const std::bad_alloc&) {
    return fail("there is not enough memory for this; choose fewer cells", exit_simulation_failed);
  } catch (const std::exception& error) {
    return fail(fmt::format("internal error: {}; please report it", error.what()), exit_simulation_failed);
  }
}

}  // namespace mss::cli
