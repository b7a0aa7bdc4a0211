#pragma once

#include "core/scene/scene.hpp"

namespace mss {

/// Throws InputError if the scene's model cannot be made.
void check_model(const Scene& scene);

/// Whether the scene's method finds where it comes to rest, and no motion.
bool is_static(const Scene& scene);

/// Throws InputError if the scene cannot be simulated by several ranks that share its body.
void check_shared(const Scene& scene);

/// Throws InputError if the scene's model, method or step cannot be used.
void check_solve(const Scene& scene);

/// Throws InputError for a scene of several bodies, or of one that touches itself: `what`, such as "mss fit",
/// is for others.
void check_one_body(const Scene& scene, const std::string& what);

}  // namespace mss
