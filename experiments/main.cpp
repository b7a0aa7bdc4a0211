#include "experiments/commands.hpp"

int main(int argc, char** argv) { return mss::run_command_line(argc, argv); }
