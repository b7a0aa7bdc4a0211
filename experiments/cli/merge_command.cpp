// `mss merge`: the parts of an experiment, which runs with --part i/N left, together as one run's results.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/conclude.hpp"
#include "experiments/harness/parts.hpp"

namespace mss::cli {

namespace {

void add_merge(CLI::App& app, int& exit_status) {
  CLI::App* command =
      app.add_subcommand("merge", "the results of an experiment from the parts that runs with --part left");
  const auto directories = std::make_shared<std::vector<std::string>>();
  const auto out = std::make_shared<std::string>("out/merged");
  command->add_option("directories", *directories, "Directories of all parts, in any order")->required();
  command->add_option("--out", *out, "Directory for the results")->capture_default_str();
  command->callback([=, &exit_status] {
    const PartsFound parts = merge_parts({directories->begin(), directories->end()}, *out);
    exit_status = conclude(run_and_write(*parts.info, parts.options, *out, parts.other_work));
  });
}

}  // namespace

Command merge_command() { return add_merge; }

}  // namespace mss::cli
