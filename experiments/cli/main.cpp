#include "experiments/cli/commands.hpp"

int main(int argc, char** argv) { return mss::cli::run_command_line(argc, argv); }
