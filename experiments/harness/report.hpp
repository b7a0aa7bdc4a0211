#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss {

/// What came of running and writing one experiment.
struct Report {
  std::string name;
  std::string caption = {};
  std::string summary = {};
  Status status = Status::ok;
  bool resumable = false;                         ///< interrupted, it can go on from its journal
  std::vector<std::filesystem::path> files = {};  ///< as written, the tables first
  std::string chart_problem = {};                 ///< why there is no chart; empty if there is one
  Json provenance;
};

/// Runs an experiment with a progress line and writes NAME.csv, its further tables, meta.json, NAME.svg,
/// NAME.png (or maps by their own names) and its further charts to `directory`, rows first. Throws InputError
/// if the directory cannot be written to, before anything is run. An experiment that keeps a journal has it
/// there until it is finished.
Report run_and_write(const ExperimentInfo& info, ExperimentOptions options,
                     const std::filesystem::path& directory);

/// One self-contained page that shows every chart with its caption and links the files beside it.
void write_page(const std::vector<Report>& reports, const std::filesystem::path& file);

/// Bytes as base64 text, for images inside a page.
std::string base64(std::string_view bytes);

/// Text with the characters that HTML reads as markup replaced.
std::string html_text(std::string_view text);

}  // namespace mss
