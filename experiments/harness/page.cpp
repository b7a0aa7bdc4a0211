// The page of `mss reproduce`: plain HTML, charts inside it as data, so that it is complete as one file.
#include <fmt/format.h>

#include <cstdint>

#include "experiments/harness/provenance.hpp"
#include "experiments/harness/report.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

constexpr const char* page_head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>mss: every chart</title>
<style>
  body { max-width: 1200px; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 "DejaVu Sans", Verdana, sans-serif; color: #202020; }
  figure { margin: 1rem 0; }
  figure img { width: 100%; height: auto; }
  figcaption, .origin { color: #404040; font-size: 0.9rem; }
  pre { overflow-x: auto; background: #f4f4f4; padding: 0.8rem; font-size: 0.8rem; }
</style>
</head>
<body>
<h1>mss: every chart</h1>
)";

std::string chart_section(const Report& report, const fs::path& page_directory) {
  std::string out = fmt::format("<section>\n<h2>{}</h2>\n", html_text(report.name));
  if (report.status != Status::ok)
    out += fmt::format("<p><strong>Status: {}.</strong> The rows so far are kept.</p>\n",
                       to_string(report.status));
  out += "<figure>\n";
  std::string links;
  for (const fs::path& file : report.files) {
    if (file.extension() == ".svg")
      out += fmt::format("<img alt=\"Chart: {}\" src=\"data:image/svg+xml;base64,{}\">\n",
                         html_text(report.name), base64(read_file(file)));
    const std::string relative = html_text(fs::relative(file, page_directory).string());
    links += fmt::format("{}<a href=\"{}\">{}</a>", links.empty() ? "" : " · ", relative,
                         html_text(file.filename().string()));
  }
  if (!report.chart_problem.empty())
    out += fmt::format("<p><strong>No chart: {}</strong></p>\n", html_text(report.chart_problem));
  out += fmt::format("<figcaption>{}</figcaption>\n</figure>\n", html_text(report.caption));
  return out + fmt::format("<pre>{}</pre>\n<p>{}</p>\n</section>\n", html_text(report.summary), links);
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t b = 0; b < 3; ++b)
      group = group << 8 | (b < count ? static_cast<std::uint8_t>(bytes[i + b]) : 0U);
    for (std::size_t d = 0; d < 4; ++d) out += d <= count ? digits[group >> (18 - 6 * d) & 63U] : '=';
  }
  return out;
}

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

void write_page(const std::vector<Report>& reports, const fs::path& file) {
  std::string out = page_head;
  if (!reports.empty())
    out +=
        fmt::format("<p class=\"origin\">{}</p>\n", html_text(provenance_line(reports.front().provenance)));
  const fs::path directory = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (const Report& report : reports) out += chart_section(report, directory);
  write_atomically(file, out + "</body>\n</html>\n");
}

}  // namespace mss
