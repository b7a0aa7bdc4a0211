#include "experiments/cli/mesh_slices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace mss::cli {

namespace {

constexpr int up = 2;

/// An upright slice across one axis.
class Slice {
 public:
  Slice(const TriangleMesh& mesh, const MeshFill& fill, int across, double at)
      : mesh_(mesh), fill_(fill), across_(across), along_(1 - across), at_(at) {
    const double layer = std::floor((at - fill.origin[across]) / fill.cell_size);
    layer_ = int(std::clamp(layer, 0.0, double(fill.voxels.size()[std::size_t(across)] - 1)));
    for (const LostFeature& feature : fill.reports.at(0).lost)
      lost_.insert(feature.cells.begin(), feature.cells.end());
  }

  MapPanel panel() const {
    const char* names[]{"x", "y"};
    return {.title = fmt::format("slice at {} = {:.4g} m", names[across_], at_),
            .cells = cells(),
            .line = section()};
  }

 private:
  enum Kind { full, part, lost, none };

  Kind kind(int i, int k) const {
    std::array<int, 3> cell{};
    cell[std::size_t(across_)] = layer_;
    cell[std::size_t(along_)] = i;
    cell[up] = k;
    const std::size_t index = fill_.voxels.index(cell[0], cell[1], cell[2]);
    if (!fill_.voxels.at(cell[0], cell[1], cell[2])) return lost_.contains(index) ? lost : none;
    double share = 0;
    for (const PartFill& content : fill_.contents[fill_.content_of[index]])
      share += double(content.fill.share());
    return share > 1 - 1e-6 ? full : part;
  }

  /// Cells of a row that are of one kind make one rectangle.
  std::vector<MapCell> cells() const {
    const double h = fill_.cell_size, left = fill_.origin[along_], low = fill_.origin[up];
    std::vector<MapCell> all;
    const int columns = fill_.voxels.size()[std::size_t(along_)];
    for (int k = 0; k < fill_.voxels.nz(); ++k)
      for (int begin = 0, end = 0; begin < columns; begin = end) {
        const Kind first = kind(begin, k);
        while (end < columns && kind(end, k) == first) ++end;
        if (first == none) continue;
        all.push_back({.x_low = left + h * begin,
                       .x_high = left + h * end,
                       .y_low = low + h * k,
                       .y_high = low + h * (k + 1),
                       .kind = first});
      }
    return all;
  }

  /// Where the triangles meet the plane, a gap after each piece.
  std::vector<ChartPoint> section() const {
    constexpr double gap = std::numeric_limits<double>::quiet_NaN();
    std::vector<ChartPoint> line;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const auto corners = mesh_.corners(t);
      const std::size_t before = line.size();
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 &a = corners[c], &b = corners[(c + 1) % 3];
        if ((a[across_] <= at_) == (b[across_] <= at_)) continue;
        const Vec3 x = a + (at_ - a[across_]) / (b[across_] - a[across_]) * (b - a);
        line.push_back({x[along_], x[up]});
      }
      if (line.size() > before) line.push_back({gap, gap});
    }
    return line;
  }

  const TriangleMesh& mesh_;
  const MeshFill& fill_;
  int across_, along_;
  double at_;
  int layer_;
  std::set<std::size_t> lost_;
};

/// An axis around the middle of a range.
ChartAxis axis(const std::string& name, double middle, double extent) {
  return {.label = name + " [m]", .low = middle - extent / 2, .high = middle + extent / 2};
}

}  // namespace

MapChart mesh_slices(const TriangleMesh& mesh, const MeshFill& fill) {
  constexpr double width = 490, height = 480;  // of a panel's inner part [px], about
  const MeshReport& report = fill.reports.at(0);
  const Vec3 at = report.lost.empty() ? report.true_centre
                                      : Vec3((report.lost[0].box.lower + report.lost[0].box.upper) / 2);
  const Vec3 extent = fill.cell_size * Vec3(fill.voxels.nx() + 1, fill.voxels.ny() + 1, fill.voxels.nz() + 1);
  const Vec3 middle = fill.origin + (extent - Vec3::Constant(fill.cell_size)) / 2;
  const double pixel = std::max({extent.x() / width, extent.y() / width, extent.z() / height});
  MapChart chart{
      .title = "What cells have of the mesh",
      .subtitle =
          fmt::format("cells of {:.4g} m; slices through {}", fill.cell_size,
                      report.lost.empty() ? "the mesh's centre" : "the largest part that no cell has"),
      .x = {},
      .y = axis("z", middle.z(), pixel * height),
      .kinds = {"full cells", "cells filled in part", "cells without the part of the mesh in them"},
      .line_label = "mesh",
      .panel_height = height + 84};
  for (const int across : {1, 0}) {
    MapPanel panel = Slice(mesh, fill, across, at[across]).panel();
    panel.x = axis(across == 1 ? "x" : "y", middle[1 - across], pixel * width);
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

}  // namespace mss::cli
