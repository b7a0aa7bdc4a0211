#pragma once

#include "experiments/view/camera.hpp"
#include "experiments/view/colour_map.hpp"
#include "experiments/view/picture.hpp"
#include "experiments/view/session.hpp"

namespace mss::view {

// Pictures of numbers, drawn into the current window of Dear ImGui at places of the screen.

/// What the colours of a body stand for.
void draw_colour_bar(const Viewport& place, const QuantityInfo& quantity, const ValueRange& range);

/// Energies and volume ratio over time, side by side.
void draw_graphs(const Viewport& place, const Session& session);

}  // namespace mss::view
