#pragma once

// The search of `mss advise`: advise_references.cpp has what it judges by, advise.cpp how it finds what it
// advises.

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "experiments/advise/advise.hpp"

namespace mss::advise {

/// Levels of references: parts that an edge of the coarsest cells is split into.
inline constexpr std::array<int, 13> rungs{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96};
/// Levels between those, of candidates and of references that check.
inline constexpr std::array<int, 7> between_rungs{5, 7, 10, 14, 20, 28, 40};
/// Both, ascending.
std::vector<int> all_levels();

/// Candidates that would take so much longer than the cheapest so far are dropped.
inline constexpr double worth_trying = 1.3;

inline constexpr const char* meets_it = "meets it";
inline constexpr const char* too_wrong = "error above what is asked";
inline constexpr const char* no_reference = "no reference could be computed: see the table";

/// The longest step of a method that is sure to be stable on such a lattice [s].
double safe_step(const std::string& method, const SpectralBound& bound);
/// 0.0123 as 1.23 %.
std::string percent(double share);

class Search {
 public:
  Search(SceneFamily& family, const Ask& ask, Progress& progress)
      : family_(family), ask_(ask), progress_(progress), looks_(looks_of(family.asked(), ask.of)) {}

  Advice find();
  Advice grid(int finest_level, int reference_level);

 private:
  struct Rung {
    int level;
    Trajectory trajectory;
    double seconds;
    std::size_t trial;
  };
  /// What ends a trial early.
  struct Limits {
    double error = std::numeric_limits<double>::infinity();
    double cost = std::numeric_limits<double>::infinity();
  };
  enum class Outcome { meets, wrong, dear, impossible };
  template <class Act>
  Outcome attempt(const Candidate& candidate, Act&& act);

  Candidate accurate(Candidate lattice) const;
  Scene awake(const Candidate& candidate) const;
  int quicker_threads(Candidate candidate);
  std::optional<Rung> climb_to(int level);
  bool climb();
  void judge_by_ladder();
  bool is_sure() const;
  double seconds_at(int level) const;
  int next_level() const;
  int checking_level() const;
  void check_scale() const;
  void judge_rungs();
  std::string why_unsure() const;
  std::string how_unsure() const;
  std::string why_grid_fails() const;

  Outcome run(const Candidate& candidate, const Limits& limits);
  Outcome follow(const Candidate& candidate, const Limits& limits);
  Outcome try_lattice(const Candidate& lattice);
  void add(const Candidate& candidate, const std::string& verdict);
  /// Uncertainties are rather too large: half of one does where a finer reference will check.
  bool meets(double error) const {
    return error + (!ladder_.empty() && checking_level() > 0 ? 0.5 : 1) * advice_.uncertainty <= ask_.error;
  }
  bool is_undecided(double error) const { return std::abs(error - ask_.error) < advice_.uncertainty; }
  bool decides() const;
  double best_cost() const;
  double least_cost(const Candidate& candidate) const;
  double accurate_cost(int level) const;
  std::string times_the_best(double cost) const;
  Limits worth() const { return {ask_.error + advice_.uncertainty, worth_trying * best_cost()}; }

  std::vector<Candidate> fillings(int level) const;
  std::vector<Candidate> find_lattices();
  int coarsest_plain();
  std::vector<std::vector<Candidate>> methods(const Candidate& lattice);
  void try_methods(const Candidate& lattice);

  std::optional<std::size_t> cheapest() const;
  void try_threads();
  void time_again(double worth = worth_trying);
  void check();
  void explain_budget();
  double seconds() const;
  bool stopped() {
    advice_.stopped = advice_.stopped || progress_.stopped();
    return advice_.stopped;
  }

  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  SceneFamily& family_;
  const Ask& ask_;
  Progress& progress_;
  Looks looks_;
  Advice advice_;
  std::vector<Rung> ladder_;
  std::optional<Judge> judge_;
  bool extrapolated_ = false;  ///< the judge is finer than the finest rung
};

/// Where a scene cannot be computed like that, or there is not enough memory, a trial says so.
template <class Act>
Search::Outcome Search::attempt(const Candidate& candidate, Act&& act) {
  try {
    return act();
  } catch (const InputError& error) {
    const std::string problem = error.what(), file = family_.asked().file.string() + ": ";
    add(candidate, "impossible: " + problem.substr(problem.starts_with(file) ? file.size() : 0));
    return Outcome::impossible;
  } catch (const std::bad_alloc&) {
    add(candidate, "needs more memory than there is");
    return Outcome::dear;
  }
}

}  // namespace mss::advise
