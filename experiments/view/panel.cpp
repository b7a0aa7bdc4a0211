#include "experiments/view/panel.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "experiments/view/graph.hpp"

namespace mss::view {

namespace {

constexpr float label_width = 116;

/// A window of ImGui that fills its place and cannot be moved, while this object exists. It has no background
/// of its own: the renderer has cleared the screen, and filling it again is most of the work where a
/// processor draws.
class Pane {
 public:
  Pane(const char* name, const Viewport& place) {
    ImGui::SetNextWindowPos({float(place.x), float(place.y)});
    ImGui::SetNextWindowSize({float(place.width), float(place.height)});
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoNav);
  }
  Pane(const Pane&) = delete;
  Pane& operator=(const Pane&) = delete;
  ~Pane() { ImGui::End(); }
};

/// While it exists, and if `disabled`, widgets are grey and take no input.
class Disabled {
 public:
  explicit Disabled(bool disabled) { ImGui::BeginDisabled(disabled); }
  Disabled(const Disabled&) = delete;
  Disabled& operator=(const Disabled&) = delete;
  ~Disabled() { ImGui::EndDisabled(); }
};

void label(const char* text) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(text);
  ImGui::SameLine(label_width);
  ImGui::SetNextItemWidth(-1);
}

void heading(const char* text) {
  ImGui::Spacing();
  ImGui::Separator();
  ImGui::TextColored({0.0F, 0.30F, 0.52F, 1}, "%s", text);
}

void text(const std::string& text) { ImGui::TextUnformatted(text.c_str()); }

void wrap(const std::string& text) { ImGui::TextWrapped("%s", text.c_str()); }

void text_in_red(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, {0.75F, 0.1F, 0.05F, 1});
  wrap(text);
  ImGui::PopStyleColor();
}

std::string pace(const Session& session, const Display& display) {
  if (session.status() != Status::ok) return "failed";
  if (!display.playing) return "paused";
  if (display.slower < 1.1) return "real time";
  return fmt::format("slower than real time x{:.1f}", display.slower);
}

void draw_state(const Session& session, const Display& display) {
  const Measures& m = session.measures();
  text(fmt::format("{}   {} cells, {} particles", session.scene().name, session.cell_count(),
                   session.particle_count()));
  text(fmt::format("t = {:.3f} s   {}", session.time(), pace(session, display)));
  if (display.frame_seconds > 0)
    text(fmt::format("frame {:.1f} ms, of it {:.1f} ms for {:.3g} steps", 1e3 * display.frame_seconds,
                     1e3 * display.step_seconds, display.steps_per_frame));
  if (session.settings().device != "cpu") wrap(fmt::format("on {}", display.device));
  wrap(fmt::format("largest stretch {:.3g}, smallest Jacobian {:.3g}", m.max_stretch, m.min_jacobian));
  if (session.status() != Status::ok)
    text_in_red(fmt::format(
        "The simulation failed: {}. The body is shown in its last state; change something and restart.",
        to_string(session.status())));
  if (!display.message.empty()) text_in_red(display.message);
}

/// Another method, with a step it can use: where "safe" means nothing, the step that was in use.
void choose(const IntegratorInfo& method, double dt, SceneEdit& settings) {
  settings.integrator = method.name;
  if (method.stepping == Stepping::fixed && !method.limit && !settings.dt) settings.dt = dt > 0 ? dt : 1e-3;
}

}  // namespace

Layout layout(double width, double height) {
  const double column = std::min(316.0, width / 2), bar = 96, graphs = std::min(180.0, height / 3);
  const double middle = std::max(1.0, width - column - bar), above = std::max(1.0, height - graphs);
  return {.column = {0, 0, column, height},
          .graphs = {column, above, std::max(1.0, width - column), graphs},
          .bar = {column + middle, 0, bar, above},
          .body = {column, 0, middle, above}};
}

Panel::Requests Panel::draw(const Session& session, Display& display, const Layout& places) {
  Requests requests;
  {
    const Pane pane("column", places.column);
    draw_state(session, display);
    draw_buttons(session, display, requests);
    SceneEdit settings = session.settings();
    const bool material = draw_material(session, settings), method = draw_method(session, display, settings);
    if (material || method) requests.settings = settings;
    draw_display(display, requests);
  }
  {
    const Pane pane("bar", places.bar);
    draw_colour_bar(places.bar, info_of(display.quantity), display.range);
  }
  {
    const Pane pane("graphs", places.graphs);
    draw_graphs(places.graphs, session);
  }
  return requests;
}

void Panel::draw_buttons(const Session& session, const Display& display, Requests& requests) {
  const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  const auto add = [&](const char* name, PanelCommand command) {
    if (button(name, width)) requests.commands.push_back(command);
  };
  {
    const Disabled disabled(session.status() != Status::ok);
    add(display.playing ? "Pause###play" : "Play###play", PanelCommand::play_or_pause);
    ImGui::SameLine();
    add("Step###step", PanelCommand::step);
  }
  ImGui::SameLine();
  add("Restart###restart", PanelCommand::restart);
}

bool Panel::draw_material(const Session& session, SceneEdit& settings) {
  const std::string& model = session.scene().model;
  const bool springs = has_springs(model);
  std::string title = "Material";
  if (!session.scene().others.empty())  // sliders change that one alone
    title += " of " + (session.scene().body_name.empty() ? "the first body" : session.scene().body_name);
  if (model != spring_model) title += ": " + model + (springs ? "" : " finite elements");
  heading(title.c_str());
  bool changed = false;
  const bool solid = session.body().config().is_solid();
  if (settings.elastic) {
    changed |= slider("young [Pa]", settings.elastic->young, 1e2, 1e9, true);
    if (solid) changed |= slider("poisson", settings.elastic->poisson, -0.45, 0.495, false);
  } else {
    changed |= draw_springs(session, settings);
  }
  changed |= draw_damping(settings.damping);
  if (!springs || !solid) return changed;  // the rest is about springs of cells
  static const std::vector<std::string> names{"all springs", "edges and body", "one diagonal a face"};
  auto topology = static_cast<std::size_t>(settings.topology);
  if (choice("topology", names, topology)) {
    settings.topology = static_cast<Topology>(topology);
    changed = true;
  }
  const bool none = !settings.elastic && settings.springs.volume == 0;
  const Disabled disabled(none);
  return toggle("volume force", settings.volume_force) || changed;
}

/// The viscosity of a scene that has one, else the ratio.
bool Panel::draw_damping(Damping& damping) {
  if (damping.law == Damping::Law::viscosity)
    return slider("viscosity [Pa s]", damping.viscosity, 1e-2, 1e6, true);
  if (!slider("damping ratio", damping.zeta, 0, 1, false)) return false;
  damping.law = damping.zeta > 0 ? Damping::Law::ratio : Damping::Law::none;
  return true;
}

/// Springs as they are given, or those of an isotropic material as stiff along an axis.
bool Panel::draw_springs(const Session& session, SceneEdit& settings) {
  bool changed = slider("edge [N/m]", settings.springs.edge, 1e-1, 1e7, true);
  const int dimensions = session.body().config().voxels.dimensions();
  if (dimensions > 1) changed |= slider("face [N/m]", settings.springs.face, 1e-1, 1e7, true);
  if (dimensions > 2) {
    changed |= slider("body [N/m]", settings.springs.body, 1e-1, 1e7, true);
    changed |= slider("volume [Pa]", settings.springs.volume, 1e-3, 1e7, true);
  }
  if (!button("Use young and poisson instead###isotropic", -1)) return changed;
  const double young = session.body().config().young_of(settings.springs, 0);
  settings.elastic = {.young = young > 0 ? young : 1e5, .poisson = 0.25};
  return true;
}

bool Panel::draw_method(const Session& session, const Display& display, SceneEdit& settings) {
  heading("Method");
  std::vector<std::string> names;
  std::size_t chosen = 0;
  for (const IntegratorInfo& info : integrators()) {
    if (info.name == settings.integrator) chosen = names.size();
    names.push_back(info.name);
  }
  bool changed = false;
  if (choice("integrator", names, chosen)) {
    choose(integrators()[chosen], session.dt(), settings);
    changed = true;
  }
  changed |= draw_device(display, settings);
  if (find_integrator(settings.integrator).stepping != Stepping::fixed) return changed;
  bool safe = !settings.dt;
  if (toggle("safe step", safe)) {
    settings.dt = safe ? std::nullopt : std::optional(session.dt());
    changed = true;
  }
  double dt = session.dt();
  const Disabled disabled(safe);
  if (slider("dt [s]", dt, 1e-6, 0.1, true)) {
    settings.dt = dt;
    changed = true;
  }
  return changed;
}

/// Whether the device that draws takes the steps too.
bool Panel::draw_device(const Display& display, SceneEdit& settings) {
  bool there = settings.device != "cpu";
  const bool changed = toggle("on the device that draws", there);
  if (ImGui::IsItemHovered() && !display.device.empty()) ImGui::SetTooltip("%s", display.device.c_str());
  if (changed) settings.device = there ? "gpu" : "cpu";
  return changed;
}

void Panel::draw_display(Display& display, Requests& requests) {
  if (button("As in the scene's file###file", -1)) requests.settings = original_;
  heading("Picture");
  std::vector<std::string> names;
  for (const QuantityInfo& info : quantities()) names.emplace_back(info.name);
  auto chosen = static_cast<std::size_t>(display.quantity);
  if (choice("colours", names, chosen)) {
    display.quantity = static_cast<DisplayedQuantity>(chosen);
    requests.commands.push_back(PanelCommand::fit_colours);
  }
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", info_of(display.quantity).meaning);
  if (display.has_mesh) {
    static const std::vector<std::string> shapes{"faces of cells", "surface of the mesh"};
    std::size_t shown = display.shows_mesh ? 1 : 0;
    if (choice("shape", shapes, shown)) display.shows_mesh = shown == 1;
  }
  toggle("surface", display.surface);
  ImGui::SameLine();
  {
    const Disabled disabled(display.shows_mesh);
    toggle("cells", display.edges);
  }
  ImGui::SameLine();
  toggle("springs", display.springs);
  toggle("particles", display.particles);
  ImGui::SameLine();
  toggle("ground", display.ground);
  const float width = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
  if (button("Fit colours###fit", width)) requests.commands.push_back(PanelCommand::fit_colours);
  ImGui::SameLine();
  if (button("See all###see", width)) requests.commands.push_back(PanelCommand::see_all);
  ImGui::Spacing();
  ImGui::Separator();
  ImGui::TextWrapped(
      "Mouse: drag the body; drag beside it to turn, right button to shift, wheel to zoom. With Ctrl the "
      "body is left "
      "alone.\nKeys: Space play, S step, R restart, F see all, C fit colours, Ctrl+Q close.");
  text(fmt::format("A square of the ground is {:.3g} m wide.", display.ground_spacing));
}

/// With `by_powers` equal distances are equal ratios. ImGui's own logarithmic sliders round to the digits
/// they show.
bool Panel::slider(const char* name, double& value, double least, double most, bool by_powers) {
  label(name);
  const std::string id = std::string("##") + name, text = fmt::format("{:.4g}", value);
  double place = by_powers ? std::log10(std::max(value, least)) : value;
  if (by_powers) {
    least = std::log10(least);
    most = std::log10(most);
  }
  const ImGuiSliderFlags flags = ImGuiSliderFlags_NoRoundToFormat | ImGuiSliderFlags_NoInput;
  const bool moved = remember(name, ImGui::SliderScalar(id.c_str(), ImGuiDataType_Double, &place, &least,
                                                        &most, text.c_str(), flags));
  if (moved) value = by_powers ? std::pow(10, place) : place;
  return moved;
}

bool Panel::button(const char* name, float width) {
  const char* id = std::strstr(name, "###");
  return remember(id + 3, ImGui::Button(name, {width, 0}));
}

bool Panel::choice(const char* name, const std::vector<std::string>& names, std::size_t& chosen) {
  label(name);
  const std::string id = std::string("##") + name;
  const bool open =
      remember(name, ImGui::BeginCombo(id.c_str(), names[chosen].c_str(), ImGuiComboFlags_HeightLarge));
  if (!open) return false;
  const std::size_t before = chosen;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (ImGui::Selectable(names[i].c_str(), i == before)) chosen = i;
  ImGui::EndCombo();
  return chosen != before;
}

bool Panel::toggle(const char* name, bool& value) { return remember(name, ImGui::Checkbox(name, &value)); }

bool Panel::remember(const char* name, bool used) {
  const ImVec2 least = ImGui::GetItemRectMin(), size = ImGui::GetItemRectSize();
  widgets_[name] = {least.x, least.y, size.x, size.y};
  return used;
}

}  // namespace mss::view
