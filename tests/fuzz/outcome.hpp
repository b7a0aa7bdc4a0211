#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace mss::fuzz {

/// How an input ended. The first ones are what it may; the others are mistakes of the program.
enum class Ending : unsigned char {
  ran,           ///< status 0: it was made and took steps,
  made,          ///< or it was made, and is too large to take steps here
  refused,       ///< status 2, with a sentence
  too_large,     ///< status 2 by the lower limit of sites that this program sets
  failed,        ///< status 3: the simulation says why it failed
  bad_sentence,  ///< status 2 with no sentence that can be read
  exception,     ///< of another type than InputError
  no_memory,     ///< more than the bound
  crash,         ///< a signal ended the process
  hang,          ///< more time than the bound
  not_run
};
inline constexpr std::size_t ending_count = 11;
inline constexpr std::array<const char*, ending_count> ending_names{
    "0 ran",     "0 made",    "2 refused", "2 too large", "3 failed", "bad sentence",
    "exception", "no memory", "crash",     "hang",        "not run"};
inline bool is_mistake(Ending ending) { return ending >= Ending::bad_sentence; }
/// The exit status of the program; -1 where it has none of its own.
int exit_status(Ending ending);

struct Outcome {
  Ending ending = Ending::not_run;
  std::string sentence;  ///< of the program
};

/// Lattices are limited to so many sites here, and those up to the second number take steps.
inline constexpr double most_sites_here = 4000;
inline constexpr double most_sites_stepped = 400;

/// Does what `mss run` does with a scene, until two steps are taken.
Outcome run_input(const std::filesystem::path& scene, const std::vector<std::string>& overrides);

/// What is wrong with a sentence; empty: nothing.
std::string fault_of_sentence(const std::string& sentence);

}  // namespace mss::fuzz
