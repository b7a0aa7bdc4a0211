#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss {

/// The outcome of running one experiment and writing its files.
struct Report {
  std::string name;
  std::string caption = {};
  std::string summary = {};
  Status status = Status::ok;
  bool resumable = false;  ///< if interrupted, the same command continues from its journal
  std::vector<std::filesystem::path> files = {};  ///< as written, the tables first
  std::string chart_problem = {};                 ///< why there is no chart; empty if there is one
  Json provenance;
};

/// Runs an experiment with a progress line and writes its tables, meta.json and its charts to `directory`,
/// tables first. Throws InputError before anything is run if the directory cannot be written to. The journal
/// of an experiment that keeps one is there until the run is complete.
Report run_and_write(const ExperimentInfo& info, ExperimentOptions options,
                     const std::filesystem::path& directory);

/// Draws every chart and map that has something on it to NAME.svg and NAME.png in a directory, all or none of
/// them, with the provenance of the run at their foot. Returns the files. Throws InputError if gnuplot is
/// missing or fails.
std::vector<std::filesystem::path> write_drawings(Drawings drawings, const Json& provenance,
                                                  const std::filesystem::path& directory);

/// One self-contained page that shows every chart with its caption and links the files beside it.
void write_page(const std::vector<Report>& reports, const std::filesystem::path& file);

/// Base64 encoding of bytes, for images inside a page.
std::string base64(std::string_view bytes);

/// Text with the characters that are markup in HTML replaced.
std::string html_text(std::string_view text);

}  // namespace mss
