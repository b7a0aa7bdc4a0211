#pragma once

#include <cstdint>
#include <vector>

#include "core/environment/obstacle.hpp"
#include "experiments/view/colour_map.hpp"
#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// What a body can be coloured by.
enum class DisplayedQuantity { stretch, volume_ratio, jacobian, speed };

struct QuantityInfo {
  DisplayedQuantity quantity;
  const char* name;
  const char* unit;  ///< empty: a bare number
  const char* meaning;
  double low,
      high;  ///< always on the colour bar: the value at rest, and differences worth seeing beside it
};

/// All of them, in the order of the enumeration.
const std::vector<QuantityInfo>& quantities();
const QuantityInfo& info_of(DisplayedQuantity quantity);

/// A quantity of the particles at some sites, of their level's springs and cells.
std::vector<float> values_at(const std::vector<std::ptrdiff_t>& sites, DisplayedQuantity quantity,
                             const std::vector<Level>& levels, const Field<double>& x,
                             const Field<double>& v);

/// A point, or one of the two ends of a line, as the graphics card takes it.
struct Mark {
  std::array<float, 3> position;
  std::array<std::uint8_t, 4> colour;  ///< red, green, blue, opacity
};
using Marks = std::vector<Mark>;

Mark mark(const Vec3& position, const Colour& colour, double opacity = 1);

/// A line per spring, coloured by its stretch if a range for that is given.
void add_springs(Marks& lines, const Level& level, const Field<double>& x, const ValueRange* stretch);

/// A point per particle; those held in all directions have another colour.
void add_particles(Marks& points, const std::vector<Level>& levels, const Field<double>& x,
                   const std::vector<Hold>& holds);

/// A plane in space, drawn as a square grid round a point of it.
struct GridPlane {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  double spacing = 1;  ///< between lines [m]
  int lines = 10;      ///< on either side of the point
};

void add_grid(Marks& lines, const GridPlane& plane);

/// An obstacle where it is at time t: its triangles, three marks each, paler where they face upwards, and
/// lines along their edges.
void add_obstacle(Marks& faces, Marks& lines, const ObstacleSurface& obstacle, double t);

/// The planes that a body may touch. Where there are none, one below it and all obstacles: where it stands,
/// if its whole lowest layer is held, otherwise so far down that what hangs or falls does not soon pass
/// through.
std::vector<GridPlane> grids_of(const Body& body, const Environment& environment);

}  // namespace mss::view
