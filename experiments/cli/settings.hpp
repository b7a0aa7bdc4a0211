#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace mss::cli {

/// The option --set of a command that reads scenes. Each takes one setting: further ones that follow it are
/// given a --set of their own before the command line is parsed, so what else follows may be the scene.
inline void add_settings(CLI::App& command, std::vector<std::string>& settings) {
  command.add_option("--set", settings, "Change values of the scene: table.key=value, one or more")
      ->take_all()
      ->allow_extra_args(false);
}

}  // namespace mss::cli
