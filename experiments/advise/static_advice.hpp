#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/advise/advise.hpp"
#include "experiments/advise/static_maps.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/simulation/error_estimates.hpp"

namespace mss::advise {

/// A scene solved at rest in cells of one size.
struct SizeTried {
  double cell_size = 0;  ///< [m]
  std::size_t particles = 0;
  double seconds = 0;           ///< of the solution
  Work work{};                  ///< of the solution
  double estimate_seconds = 0;  ///< of the estimates
  Status status = Status::ok;
  BoxExtents boxes{};
  SceneEstimates estimates{};
};

/// Which cells a scene at rest needs: found by solving it in ever smaller ones.
struct StaticAdvice {
  std::vector<SizeTried> sizes{};         ///< from the largest cells to the smallest, each half of the last
  std::string quantity{};                 ///< that the requested error is of
  double as_computed = 0, corrected = 0;  ///< largest cells that meet the error so [m]; 0: none do
  std::vector<MapTried> maps{};           ///< smaller cells in places,
  std::optional<std::size_t> map{};  ///< and the one that meets the error with fewer particles than these
  std::string explanation{};         ///< a sentence where nothing is advised; empty otherwise
  bool stopped = false;              ///< by the user
};

/// Throws InputError if what is requested is about motion.
void check_static(const AdviseRequest& request);

/// Solves a scene from the largest cells that its own can be merged to, halving them while a solution is
/// charged less than `patience` seconds; limits are extrapolated from the three smallest sizes by the order
/// these show. The error is of the largest component of a displacement in [expect], or of the stored energy.
/// Corrected values count where nothing makes their estimate doubtful.
///
/// Then it tries maps that begin with the three smallest of the sizes that are too large. One is advised if
/// it meets the error as computed with fewer particles than the largest cells that do, and with two thirds or
/// less of those that cells of one size, whatever it is, would need for its error; otherwise cells of one
/// size stay the answer. Maps and sizes are compared whose boxes hold particles up to the same places. Throws
/// as check_static(), and InputError for a scene that is refined already.
StaticAdvice advise_at_rest(const Scene& scene, const AdviseRequest& request, Progress& progress);

/// `static_advice`: a row per quantity and size, with the estimate beside the error that was found;
/// `static_advice_maps`: a row per map; `static_advice_request`: one row.
std::vector<NamedTable> static_tables(const AdviseRequest& request, const StaticAdvice& advice);
/// Errors found of the quantity, as computed and corrected, against the size of cells.
Drawings draw_at_rest(const std::vector<NamedTable>& tables);

/// Writes tables, chart and meta.json. `origin`: the provenance.
void write_static_advice(const Scene& scene, const AdviseRequest& request, const StaticAdvice& advice,
                         const Json& origin, const std::filesystem::path& directory);
/// In lines for stdout.
std::string summary(const Scene& scene, const AdviseRequest& request, const StaticAdvice& advice);

}  // namespace mss::advise
