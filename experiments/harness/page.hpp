#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/harness/report.hpp"

namespace mss {

/// One self-contained page of studies: a summary, every chart with its caption, its table and its command,
/// and links to the files beside it. It needs no script and nothing from elsewhere.
void write_page(const std::vector<Report>& reports, const std::filesystem::path& file);

/// A line of Markdown as HTML: links, strong text and code. A link leads to the study that its path names
/// first, if that is among those given.
std::string html_of_markdown(std::string_view line, const std::set<std::string>& studies);

/// Base64 encoding of bytes, for images inside a page.
std::string base64(std::string_view bytes);

/// Text with the characters that are markup in HTML replaced.
std::string html_text(std::string_view text);

}  // namespace mss
