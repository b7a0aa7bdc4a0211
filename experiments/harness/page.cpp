// The page of `mss reproduce`: plain HTML, charts inside it as data, so that it is complete as one file. A
// chart that is shown twice, small in the summary and large in its section, is there once.
#include "experiments/harness/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <set>
#include <sstream>

#include "experiments/harness/other_work.hpp"
#include "experiments/harness/page_style.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/study_times.hpp"
#include "experiments/io/installation.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;
using fmt::arg;

constexpr const char* page_frame = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>mss: every study and its charts</title>
<style>{style}</style>
</head>
<body>
<div class="page">
<nav class="beside" aria-label="Contents">
{contents}</nav>
<main>
<h1>mss: every study and its charts</h1>
<nav class="above" aria-label="Contents">
<details><summary>Contents</summary>
{contents}</details>
</nav>
{summary}{studies}</main>
</div>
</body>
</html>
)";

constexpr const char* contents_entry = R"(<li><a href="#{study}">{study}</a>{charts}</li>
)";

constexpr const char* charts_entry = R"(
<details><summary>{count}</summary><ul>
{charts}</ul></details>)";

constexpr const char* summary_frame = R"(<div id="summary">
{findings}<h2>Find a study</h2>
<p>{verdict}</p>
<ul class="cards">
{cards}</ul>
<h2>Where these numbers come from</h2>
<dl class="facts">
{facts}</dl>
</div>
)";

constexpr const char* findings_frame =
    R"({findings}<p class="quiet">From the results that are kept with the program, of its authors' machine; below is what ran here.</p>
)";

constexpr const char* card_frame = R"(<li><a href="#{study}">{thumbnail}<span>{study}</span></a>
<p>{question}</p>
<p class="quiet">{outcome}</p></li>
)";

constexpr const char* study_frame = R"(<section id="{study}" aria-labelledby="heading-{study}">
<h2 id="heading-{study}"><a href="#{study}">{study}</a></h2>
<p>{question}</p>
<p>{outcome}</p>
<pre class="command"><code>{command}</code></pre>
<p>{caption}</p>
{charts}{printed}{tables}<p class="quiet">{provenance}</p>
<p><a href="#summary">To the summary</a></p>
</section>
)";

constexpr const char* chart_frame = R"(<figure id="chart-{chart}">
<h3>{title}</h3>
<p class="hint">Wider than this screen: move it sideways.</p>
<div class="scrolls"><a href="{file}"><svg viewBox="0 0 {width} {height}" role="img" aria-label="Chart: {title}"><image id="image-{chart}" width="{width}" height="{height}" href="data:image/svg+xml;base64,{data}"/></svg></a></div>
<figcaption>
{notice}<p>{subtitle}</p>
<p class="quiet">By <code>{command}</code></p>
<ul class="links">
{links}</ul>
</figcaption>
</figure>
)";

constexpr const char* thumbnail_frame =
    R"(<svg viewBox="0 0 {width} {height}" preserveAspectRatio="xMidYMid meet" aria-hidden="true"><use href="#image-{chart}"/></svg>)";

constexpr const char* printed_frame = R"(<details><summary>What it printed</summary>
<pre>{text}</pre>
</details>
)";

constexpr const char* tables_frame = R"(<details><summary>All tables</summary>
<div class="scrolls"><table>
<thead><tr><th>file</th><th>rows</th></tr></thead>
<tbody>
{rows}</tbody>
</table></div>
<p>Units, configuration and machine: {meta}</p>
</details>
)";

/// The texts that a function makes of the items of a range, one after the other.
template <class Range, class Function>
std::string concatenated(const Range& range, const Function& text_of) {
  std::string out;
  for (const auto& item : range) out += text_of(item);
  return out;
}

std::string html_link(const std::string& target, const std::string& text) {
  return fmt::format("<a href=\"{}\">{}</a>", html_text(target), html_text(text));
}

std::string html_item(const std::string& content) { return fmt::format("<li>{}</li>\n", content); }

constexpr std::string_view heading = "## Which method when\n";

/// The lines under the heading, up to the next one.
std::string section_of(const std::string& text) {
  const std::size_t at = text.find(heading);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + heading.size();
  return text.substr(begin, text.find("\n## ", begin) - begin);
}

/// A link's text; to its study where that is on the page, which its path names first.
std::string html_of_link(std::string_view text, std::string_view target,
                         const std::set<std::string>& studies) {
  const std::string study(target.substr(0, target.find('/')));
  if (!studies.contains(study)) return html_text(text);
  return fmt::format("<a href=\"#{}\">{}</a>", html_text(study), html_text(text));
}

/// What the committed results say of which method to take when: that section of results/README.md. Its
/// figures lead to their studies, where these are on the page. Empty if the file or the section is not there.
std::string page_findings(const std::set<std::string>& studies) {
  const std::filesystem::path file = shipped_files() / "results" / "README.md";
  if (!std::filesystem::exists(file)) return {};
  std::istringstream lines(section_of(read_file(file)));
  std::string items, before;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("- "))
      items += fmt::format("<li>{}</li>\n", html_of_markdown(std::string_view(line).substr(2), studies));
    else if (!line.empty())
      before += fmt::format("<p>{}</p>\n", html_of_markdown(line, studies));
  if (items.empty()) return {};
  return fmt::format("<h2>Which method when</h2>\n{}<ul class=\"findings\">\n{}</ul>\n", before, items);
}

/// A study on its way into the page: its folder as seen from there.
struct PageStudy {
  const Report& report;
  std::string folder;

  std::string file(const std::string& name) const { return folder + "/" + name; }
  std::string command() const { return html_text(report.command + " --out " + folder); }
};

/// The title of a chart; where several charts have it, with what else their names say.
std::string page_title(const Report& report, const DrawnChart& chart) {
  const auto has_title = [&](const DrawnChart& other) { return other.title == chart.title; };
  if (chart.name == report.name || std::count_if(report.charts.begin(), report.charts.end(), has_title) == 1)
    return chart.title;
  const bool prefixed = chart.name.starts_with(report.name + "_");
  std::string rest = prefixed ? chart.name.substr(report.name.size() + 1) : chart.name;
  std::replace(rest.begin(), rest.end(), '_', ' ');
  return fmt::format("{}: {}", chart.title, rest);
}

std::string contents_list(const std::vector<PageStudy>& studies) {
  const auto entry = [](const PageStudy& study) {
    const auto chart_entry = [&](const DrawnChart& chart) {
      return html_item(html_link("#chart-" + chart.name, page_title(study.report, chart)));
    };
    const std::size_t count = study.report.charts.size();
    const std::string charts =
        count == 0
            ? ""
            : fmt::format(charts_entry, arg("count", fmt::format("{} chart{}", count, count == 1 ? "" : "s")),
                          arg("charts", concatenated(study.report.charts, chart_entry)));
    return fmt::format(contents_entry, arg("study", html_text(study.report.name)), arg("charts", charts));
  };
  return "<ul>\n" + concatenated(studies, entry) + "</ul>\n";
}

/// Rows of the main table by their status, the most frequent ones.
std::string rows_text(const Report& report, std::size_t most) {
  if (report.tables.empty()) return "no rows";
  std::vector<std::string> parts;
  std::size_t others = report.tables.front().second;
  for (const auto& [status, rows] : report.outcomes) {
    if (parts.size() == most) break;
    parts.push_back(fmt::format("{} {}", rows, status));
    others -= rows;
  }
  if (others > 0 && !parts.empty()) parts.push_back(fmt::format("{} of other outcomes", others));
  return fmt::format("{} rows{}{}", report.tables.front().second, parts.empty() ? "" : ": ",
                     fmt::join(parts, ", "));
}

/// A duration that no line break divides.
std::string page_duration(double seconds) {
  std::string out;
  for (const char c : duration_text(seconds)) out += c == ' ' ? "&nbsp;" : std::string(1, c);
  return out;
}

/// How a study went: to its end or not, its rows, its time, and why there is no chart.
std::string outcome_text(const Report& report, std::size_t most_outcomes) {
  const std::string time = page_duration(report.seconds);
  std::string text = report.status == Status::ok
                         ? "complete in " + time
                         : fmt::format("<strong class=\"bad\">{} after {}; the rows so far are kept</strong>",
                                       to_string(report.status), time);
  text += " · " + html_text(rows_text(report, most_outcomes));
  if (!report.chart_problem.empty())
    text += fmt::format(" · <strong class=\"bad\">no chart: {}</strong>", html_text(report.chart_problem));
  return text;
}

/// Width and height of an SVG picture.
std::pair<double, double> size_of_svg(const std::string& svg) {
  double width = 4, height = 3;
  const std::size_t at = svg.find("viewBox=\"");
  if (at != std::string::npos) std::sscanf(svg.c_str() + at, "viewBox=\"0 0 %lf %lf", &width, &height);
  return {width, height};
}

std::string thumbnail_of(const PageStudy& study) {
  if (study.report.charts.empty()) return {};
  const std::string& chart = study.report.charts.front().name;
  const auto [width, height] = size_of_svg(read_file(study.report.directory / (chart + ".svg")));
  return fmt::format(thumbnail_frame, arg("width", width), arg("height", height),
                     arg("chart", html_text(chart)));
}

std::string study_card(const PageStudy& study) {
  constexpr std::size_t most_outcomes = 3;
  return fmt::format(card_frame, arg("study", html_text(study.report.name)),
                     arg("thumbnail", thumbnail_of(study)), arg("question", html_text(study.report.question)),
                     arg("outcome", outcome_text(study.report, most_outcomes)));
}

/// Whether all studies ran to their end and have charts, and if not, which.
std::string page_verdict(const std::vector<PageStudy>& studies) {
  std::vector<std::string> unfinished, without_charts;
  std::size_t charts = 0;
  double seconds = 0;
  for (const auto& [report, folder] : studies) {
    if (report.status != Status::ok) unfinished.push_back(html_text(report.name));
    if (!report.chart_problem.empty()) without_charts.push_back(html_text(report.name));
    charts += report.charts.size();
    seconds += report.seconds;
  }
  std::string text =
      fmt::format("{} {} with {} {}, in {}.", studies.size(), studies.size() == 1 ? "study" : "studies",
                  charts, charts == 1 ? "chart" : "charts", page_duration(seconds));
  if (unfinished.empty() && without_charts.empty()) return text + " All ran to their end.";
  if (!unfinished.empty())
    text += fmt::format(" <strong class=\"bad\">Not complete: {}.</strong>", fmt::join(unfinished, ", "));
  if (!without_charts.empty())
    text +=
        fmt::format(" <strong class=\"bad\">Without charts: {}.</strong>", fmt::join(without_charts, ", "));
  return text;
}

/// One fact about all studies: its values, those that differ.
std::string page_fact(const char* name, const std::vector<PageStudy>& studies,
                      const std::function<std::string(const Json&)>& value_of) {
  std::vector<std::string> values;
  for (const PageStudy& study : studies)
    if (const std::string value = value_of(study.report.provenance);
        std::find(values.begin(), values.end(), value) == values.end())
      values.push_back(value);
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, html_text(fmt::format("{}", fmt::join(values, "; "))));
}

/// How busy others kept the cores while studies ran; empty if that is not known of any.
std::string other_work_fact(const std::vector<PageStudy>& studies) {
  std::vector<double> shares;
  for (const PageStudy& study : studies)
    if (const auto others = other_work_in(study.report.provenance)) shares.push_back(others->share);
  if (shares.empty()) return {};
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  return fmt::format("<dt>Other work</dt><dd>{:.0f} to {:.0f} % of the cores while a study ran</dd>\n",
                     100 * *least, 100 * *most);
}

/// Where the numbers come from.
std::string page_facts(const std::vector<PageStudy>& studies) {
  const auto text = [](const char* key) { return [key](const Json& p) { return p.value(key, "unknown"); }; };
  const auto load = [](const PageStudy& study) {
    return study.report.provenance.at("load_average").at(0).get<double>();
  };
  constexpr std::size_t shown_digits = 12;
  std::string out = page_fact("Commit", studies, [](const Json& p) {
    return p.value("commit", "unknown").substr(0, shown_digits) +
           (p.value("modified", false) ? ", with changes" : "");
  });
  out += page_fact("Machine", studies, [](const Json& p) {
    return fmt::format("{}, {} cores", p.value("cpu", "unknown"), p.value("cores_available", 0));
  });
  out += page_fact("System", studies, text("os")) + page_fact("Compiler", studies, text("compiler"));
  if (studies.empty()) return out;
  const auto [least, most] = std::minmax_element(
      studies.begin(), studies.end(), [&](const auto& a, const auto& b) { return load(a) < load(b); });
  return out + other_work_fact(studies) +
         fmt::format("<dt>Load</dt><dd>{:.1f} to {:.1f} when a study began</dd>\n", load(*least),
                     load(*most)) +
         fmt::format("<dt>Began</dt><dd>{}</dd>\n",
                     html_text(text("date")(studies.front().report.provenance)));
}

std::string page_summary(const std::vector<PageStudy>& studies) {
  std::set<std::string> names;
  for (const PageStudy& study : studies) names.insert(study.report.name);
  const std::string findings = page_findings(names);
  return fmt::format(
      summary_frame,
      arg("findings", findings.empty() ? "" : fmt::format(findings_frame, arg("findings", findings))),
      arg("verdict", page_verdict(studies)), arg("facts", page_facts(studies)),
      arg("cards", concatenated(studies, study_card)));
}

std::string chart_figure(const PageStudy& study, const DrawnChart& chart) {
  const std::string svg = read_file(study.report.directory / (chart.name + ".svg"));
  const auto [width, height] = size_of_svg(svg);
  const std::string table = chart.table + ".csv";
  const std::string notice = chart.notice.empty() ? ""
                                                  : fmt::format("<p><strong class=\"bad\">{}</strong></p>\n",
                                                                html_text(chart.notice));
  std::string links;
  if (!chart.table.empty()) links += html_item(html_link(study.file(table), "Data: " + table));
  links += html_item(html_link(study.file(chart.name + ".svg"), "SVG")) +
           html_item(html_link(study.file(chart.name + ".png"), "PNG"));
  return fmt::format(chart_frame, arg("chart", html_text(chart.name)),
                     arg("title", html_text(page_title(study.report, chart))),
                     arg("file", html_text(study.file(chart.name + ".svg"))), arg("notice", notice),
                     arg("subtitle", html_text(chart.subtitle)), arg("width", width), arg("height", height),
                     arg("data", base64(svg)), arg("command", study.command()), arg("links", links));
}

std::string table_list(const PageStudy& study) {
  const auto row = [&](const auto& named) {
    const std::string file = named.first + ".csv";
    return fmt::format("<tr><td>{}</td><td class=\"number\">{}</td></tr>\n",
                       html_link(study.file(file), file), named.second);
  };
  return fmt::format(tables_frame, arg("rows", concatenated(study.report.tables, row)),
                     arg("meta", html_link(study.file("meta.json"), "meta.json")));
}

std::string study_section(const PageStudy& study) {
  const Report& report = study.report;
  const std::string printed =
      report.summary.empty() ? "" : fmt::format(printed_frame, arg("text", html_text(report.summary)));
  return fmt::format(
      study_frame, arg("study", html_text(report.name)), arg("question", html_text(report.question)),
      arg("outcome", outcome_text(report, report.outcomes.size())), arg("command", study.command()),
      arg("charts", concatenated(report.charts, [&](const DrawnChart& c) { return chart_figure(study, c); })),
      arg("caption", html_text(report.caption)), arg("printed", printed), arg("tables", table_list(study)),
      arg("provenance", html_text(provenance_line(report.provenance))));
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

std::string html_of_markdown(std::string_view line, const std::set<std::string>& studies) {
  std::string out;
  while (!line.empty()) {
    const auto enclosed = [&](std::string_view mark, const char* tag) {
      const std::size_t end = line.starts_with(mark) ? line.find(mark, mark.size()) : std::string_view::npos;
      if (end == std::string_view::npos) return false;
      out += fmt::format("<{0}>{1}</{0}>", tag, html_text(line.substr(mark.size(), end - mark.size())));
      line.remove_prefix(end + mark.size());
      return true;
    };
    if (enclosed("**", "strong") || enclosed("`", "code")) continue;
    const std::size_t middle = line.front() == '[' ? line.find("](") : std::string_view::npos,
                      end = middle == std::string_view::npos ? middle : line.find(')', middle);
    if (end != std::string_view::npos) {
      out += html_of_link(line.substr(1, middle - 1), line.substr(middle + 2, end - middle - 2), studies);
      line.remove_prefix(end + 1);
      continue;
    }
    out += html_text(line.substr(0, 1));
    line.remove_prefix(1);
  }
  return out;
}

void write_page(const std::vector<Report>& reports, const fs::path& file) {
  const fs::path directory = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::vector<PageStudy> studies;
  studies.reserve(reports.size());
  for (const Report& report : reports)
    studies.push_back({report, fs::relative(report.directory, directory).generic_string()});
  write_atomically(file,
                   fmt::format(page_frame, arg("style", page_style), arg("contents", contents_list(studies)),
                               arg("summary", page_summary(studies)),
                               arg("studies", concatenated(studies, study_section))));
}

}  // namespace mss
