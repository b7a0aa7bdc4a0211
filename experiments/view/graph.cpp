#include "experiments/view/graph.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace mss::view {

namespace {

constexpr ImU32 ink = IM_COL32(30, 34, 40, 255), faint = IM_COL32(30, 34, 40, 40);

/// A line of a graph.
struct Curve {
  std::string name;
  ImU32 colour;
  std::function<double(const Measures&)> value;
  float width = 1.8F;  ///< [pixels]
};

ImVec2 at(double x, double y) { return {float(x), float(y)}; }

void write(double x, double y, const std::string& text, ImU32 colour = ink) {
  ImGui::GetWindowDrawList()->AddText(at(x, y), colour, text.c_str());
}

double width_of(const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; }

/// The number of a tick, with as many digits as distinguish it from its neighbours.
std::string tick_text(double value, const ValueRange& range) {
  if (std::abs(value) < range.step / 2) return "0";
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  const int first = int(std::floor(std::log10(largest) + 1e-9)),
            last = int(std::floor(std::log10(range.step) + 1e-9));
  if (first >= 6 || last <= -6) return fmt::format("{:.{}e}", value, std::max(0, first - last));
  return fmt::format("{:.{}f}", value, std::max(0, -last));
}

ValueRange span(const std::deque<Measures>& history, const std::vector<Curve>& curves, double least) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Measures& m : history)
    for (const Curve& curve : curves) {
      low = std::min(low, curve.value(m));
      high = std::max(high, curve.value(m));
    }
  return round_range(low, high, std::max(least, 1e-9 * std::max(std::abs(low), std::abs(high))));
}

/// Every second tick has its number where all would not fit.
void draw_ticks(const Viewport& plot, const ValueRange& range) {
  const std::vector<double> ticks = range.ticks();
  const std::size_t every = double(ticks.size()) * ImGui::GetTextLineHeight() > plot.height ? 2 : 1;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double y = plot.y + plot.height * (1 - range.share(ticks[i]));
    ImGui::GetWindowDrawList()->AddLine(at(plot.x, y), at(plot.x + plot.width, y), faint);
    if (i % every != 0) continue;
    const std::string text = tick_text(ticks[i], range);
    write(plot.x - width_of(text) - 6, y - ImGui::GetTextLineHeight() / 2, text);
  }
}

/// Title and names of the curves, broken into lines where they do not fit. Draws them from (x, y) on if
/// `drawn`; returns their height.
double legend(double x, double y, double width, const std::string& title, const std::vector<Curve>& curves,
              bool drawn) {
  constexpr double sample = 14, gap = 14;
  const double line = ImGui::GetTextLineHeight();
  double at_x = x, at_y = y;
  if (drawn) write(at_x, at_y, title);
  at_x += width_of(title) + gap;
  for (const Curve& curve : curves) {
    if (curves.size() == 1) break;  // the title names it
    const double own = sample + 4 + width_of(curve.name);
    if (at_x + own > x + width && at_x > x) {
      at_x = x;
      at_y += line + 2;
    }
    if (drawn) {
      ImGui::GetWindowDrawList()->AddLine(at(at_x, at_y + line / 2), at(at_x + sample, at_y + line / 2),
                                          curve.colour, curve.width + 0.7F);
      write(at_x + sample + 4, at_y, curve.name);
    }
    at_x += own + gap;
  }
  return at_y + line - y;
}

void draw_graph(const Viewport& place, const std::string& title, const std::vector<Curve>& curves,
                const std::deque<Measures>& history, double least) {
  const double left = 74, right = 14, bottom = 24;
  const double top = 12 + legend(place.x + left, 0, place.width - left, title, curves, false);
  const Viewport plot{place.x + left, place.y + top, std::max(10.0, place.width - left - right),
                      std::max(10.0, place.height - top - bottom)};
  const ValueRange range = span(history, curves, least);
  legend(plot.x, place.y + 6, place.width - left, title, curves, true);
  draw_ticks(plot, range);
  const double begin = history.front().t, end = std::max(history.back().t, begin + 1e-9);
  for (const Curve& curve : curves) {
    std::vector<ImVec2> points;
    for (const Measures& m : history) {
      const ImVec2 point = at(plot.x + plot.width * (m.t - begin) / (end - begin),
                              plot.y + plot.height * (1 - range.share(curve.value(m))));
      if (points.empty() || point.x > points.back().x + 0.5F) points.push_back(point);
    }
    ImGui::GetWindowDrawList()->AddPolyline(points.data(), int(points.size()), curve.colour, 0, curve.width);
  }
  const std::string first = fmt::format("t = {:.2f} s", begin),
                    last = fmt::format("{:.2f} s", history.back().t);
  if (width_of(first) + width_of(last) + 10 < plot.width) write(plot.x, plot.y + plot.height + 5, first);
  write(plot.x + plot.width - width_of(last), plot.y + plot.height + 5, last);
}

/// Weight, with loads and penalty planes if there are any, counts from the start: its zero is arbitrary,
/// and would hide the rest.
std::vector<Curve> energy_curves(const Session& session) {
  const double zero = session.start().external_potential;
  std::vector<Curve> curves{
      // what is often equal to another one lies beneath it, and is wider
      {"total", IM_COL32(165, 170, 178, 255), [zero](const Measures& m) { return m.total() - zero; }, 4.5F},
      {"kinetic", IM_COL32(0, 114, 178, 255), [](const Measures& m) { return m.kinetic; }},
      {"elastic", IM_COL32(213, 94, 0, 255), [](const Measures& m) { return m.elastic + m.volume_energy; }}};
  const Environment& environment = session.scene().environment;
  const auto presses = [](const auto& one) { return one.contact == ContactLaw::penalty; };
  const bool planes = std::any_of(environment.planes.begin(), environment.planes.end(), presses) ||
                      std::any_of(environment.obstacles.begin(), environment.obstacles.end(), presses);
  if (planes || !environment.gravity.isZero(0) || !environment.loads.empty())
    curves.push_back({planes || !environment.loads.empty() ? "outer" : "weight", IM_COL32(0, 158, 115, 255),
                      [zero](const Measures& m) { return m.external_potential - zero; }});
  return curves;
}

}  // namespace

void draw_colour_bar(const Viewport& place, const QuantityInfo& quantity, const ValueRange& range) {
  const Viewport bar{place.x + 10, place.y + 64, 20, std::max(20.0, place.height - 64 - 20)};
  write(bar.x, place.y + 12, quantity.name);
  write(bar.x, place.y + 12 + ImGui::GetTextLineHeight(),
        *quantity.unit != 0 ? fmt::format("[{}]", quantity.unit) : "");
  ImDrawList* list = ImGui::GetWindowDrawList();
  constexpr int bands = 128;
  for (int i = 0; i < bands; ++i) {
    const Colour c = map_colour((i + 0.5) / bands);
    list->AddRectFilled(at(bar.x, bar.y + bar.height * (bands - 1 - i) / bands),
                        at(bar.x + bar.width, bar.y + bar.height * (bands - i) / bands),
                        ImGui::ColorConvertFloat4ToU32({c[0], c[1], c[2], 1}));
  }
  list->AddRect(at(bar.x, bar.y), at(bar.x + bar.width, bar.y + bar.height), ink);
  for (const double tick : range.ticks()) {
    const double y = bar.y + bar.height * (1 - range.share(tick));
    list->AddLine(at(bar.x + bar.width, y), at(bar.x + bar.width + 4, y), ink);
    write(bar.x + bar.width + 7, y - ImGui::GetTextLineHeight() / 2, tick_text(tick, range));
  }
}

void draw_graphs(const Viewport& place, const Session& session) {
  constexpr double narrow = 440;  // room for one graph only
  const bool has_volume = session.body().config().is_solid();
  const double share = place.width < narrow || !has_volume ? 1 : 0.56;
  const Viewport left{place.x, place.y, share * place.width, place.height};
  const Viewport right{place.x + left.width, place.y, place.width - left.width, place.height};
  draw_graph(left, "energy [J]", energy_curves(session), session.history(), 1e-12);
  if (share == 1) return;
  const Curve ratio{"whole body", IM_COL32(0, 114, 178, 255),
                    [](const Measures& m) { return m.volume_ratio; }};
  draw_graph(right, "volume / volume at rest", {ratio}, session.history(), 1e-4);
}

}  // namespace mss::view
