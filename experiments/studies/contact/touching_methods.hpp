#pragma once

#include <string>
#include <vector>

namespace mss::studies::contact {

inline constexpr double frame_step = 1.0 / 60;  ///< of methods without a stability limit [s]

/// Of symplectic explicit methods of several evaluations a step: contact, which is not smooth, does not let
/// them have their order.
bool is_of_high_order(const std::string& integrator);

/// Which of the methods, all but explicit ones of high order if none is named, move bodies that touch with
/// friction: those of fixed step that move materials by forces.
std::vector<std::string> touching_methods(const std::vector<std::string>& named);

/// The lines of [solve] that choose a method and its step: the safe one, or 1/60 s of methods without a
/// limit.
std::string solve_text(const std::string& integrator, double duration, double every);

}  // namespace mss::studies::contact
