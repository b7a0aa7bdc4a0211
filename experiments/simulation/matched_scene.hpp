#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "experiments/harness/json.hpp"
#include "experiments/simulation/vibrations.hpp"

namespace mss {

/// A vibration of the body that moduli were matched to, and of the cells that have them.
struct MatchedVibration {
  SectionMotion motion;
  double frequency = 0;  ///< to match [Hz]
  /// What the matched cells' frequency is beyond it, over it; NaN: none of their slowest vibrations is alike.
  double mismatch = 0;
  bool is_matched = false;  ///< rather than reported only
  /// False: the limit is to be matched, and was not found for this one, whose frequency is that of the
  /// smallest cells computed.
  bool has_limit = true;
};

/// How the moduli of a scene were changed.
struct MatchReport {
  FrequencyMatch::Of of{};
  std::string to;  ///< the body that was matched, in words
  ElasticConstants before{}, after{};
  double face_share = 0;  ///< t of the springs
  std::vector<MatchedVibration> vibrations{};
  double seconds = 0;  ///< that it took

  /// The largest of the matched ones, and of the others; 0 where there are none.
  double error_of_matched() const { return largest(true); }
  double error_of_others() const { return largest(false); }

 private:
  double largest(bool matched) const;
};

/// A scene to be computed, and how it was matched if it asked for that.
struct MatchedScene {
  Scene scene;
  std::optional<MatchReport> report{};
};

/// Changes E of cells that are too large to resolve a body, or E and nu, so that vibrations are those of the
/// body in smaller cells, or in the limit of many by Richardson's extrapolation of second order. The scene
/// that it returns has no `match` left to be carried out; one without `match` is returned as it is.
///
/// One vibration sets E, since frequencies go with its root; several set E and nu, by least squares of
/// logarithms of frequencies over frequencies squared, with face_share = 1. Parts have E and shear modulus
/// changed by the same factors. A viscosity is changed with the shear modulus: vibrations keep their decay. A
/// damping ratio is changed with the root of E, which keeps it where E alone is changed; damping.thesis is
/// left alone, with a warning. Where one of the slowest six is off by more than 5 percent, the scene gets a
/// warning.
///
/// Throws InputError for a scene without a vibration of the kind that is to be matched, where no moduli are
/// found that serve several, and as slowest_vibrations() does.
MatchedScene matched(const Scene& scene);

/// The same of cells that are matched to those of another scene of the same body.
MatchedScene matched_to(Scene scene, FrequencyMatch::Of of, const Scene& fine);

/// load_scene(), and matched() of what it reads: what a driver begins with. Throws as both.
MatchedScene load_matched_scene(const std::filesystem::path& file,
                                const std::vector<std::string>& overrides = {});

/// Sentences about it, and the same for files; null where nothing was matched.
std::vector<std::string> description(const MatchReport& report);
Json to_json(const std::optional<MatchReport>& report);

}  // namespace mss
