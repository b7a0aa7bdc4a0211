#include "core/mesh/inside_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <tuple>

#include "core/base/error.hpp"
#include "core/mesh/winding.hpp"

namespace mss {

std::array<int, 3> SampleGrid::cell(std::size_t index) const {
  const auto nx = std::size_t(cells[0]);
  const auto ny = std::size_t(cells[1]);
  return {int(index % nx), int(index / nx % ny), int(index / nx / ny)};
}

Vec3 SampleGrid::centre(std::size_t index) const {
  const auto [i, j, k] = cell(index);
  return origin + cell_size * Vec3(i + 0.5, j + 0.5, k + 0.5);
}

Vec3 SampleGrid::sample(std::size_t index, int bit) const {
  const auto [i, j, k] = cell(index);
  const int x = bit % samples, y = bit / samples % samples, z = bit / samples / samples;
  const Vec3 within(x + 0.5, y + 0.5, z + 0.5);
  return origin + cell_size * (Vec3(i, j, k) + within / samples);
}

namespace {

/// A line through samples meets the surface: all samples of the line from `from` on wind once more or less.
/// Ordered by line, then along it.
struct Crossing {
  Crossing(int line, int from, bool enters, double depth)
      : key(std::uint64_t(line) << 32 | std::uint64_t(from) << 1 | std::uint64_t(enters)),
        gap(float(from - depth)) {}
  int line() const { return int(key >> 32); }
  int from() const { return int(key >> 1 & 0x7fffffff); }
  int change() const { return (key & 1) != 0 ? 1 : -1; }
  bool operator<(const Crossing& other) const { return key < other.key; }

  std::uint64_t key;
  float gap;  ///< from the surface to the sample `from`, in steps
};

constexpr std::size_t most_crossings = std::size_t(1) << 25;

/// All lines along one axis, one layer of cells after the other. Coordinates count samples, from the first;
/// u and v are the axes after the lines' own, v is the one across layers.
class LineSweep {
 public:
  LineSweep(const TriangleMesh& mesh, const std::vector<Vec3>& positions, double orientation,
            const SampleGrid& grid, int axis)
      : mesh_(mesh),
        x_(positions),
        orientation_(orientation),
        s_(grid.samples),
        w_(axis),
        u_((axis + 1) % 3),
        v_((axis + 2) % 3) {
    for (int a = 0; a < 3; ++a) samples_[std::size_t(a)] = grid.cells[std::size_t(a)] * s_;
    bin(grid.cells[std::size_t(v_)]);
  }

  /// The crossings of all lines in the next layer. Lines are numbered cell by cell along u:
  /// s^2 (cell) + (u in it) + s (v in it).
  const std::vector<Crossing>& next_layer() {
    crossings_.clear();
    for (std::size_t t = first_[std::size_t(layer_)]; t < first_[std::size_t(layer_) + 1]; ++t)
      active_.push_back(order_[t]);
    for (const int t : active_)
      for (int line = layer_ * s_; line < (layer_ + 1) * s_; ++line) cross(t, line);
    std::erase_if(active_, [&](int t) { return lines_of(t).second <= (layer_ + 1) * s_; });
    std::sort(crossings_.begin(), crossings_.end());
    ++layer_;
    return crossings_;
  }

 private:
  double at(int vertex, int axis) const { return x_[std::size_t(vertex)][axis]; }

  /// Lines v = first to second - 1 meet the triangle.
  std::pair<int, int> lines_of(int t) const {
    const auto& [a, b, c] = mesh_.triangles[std::size_t(t)];
    const auto [low, high] = std::minmax({at(a, v_), at(b, v_), at(c, v_)});
    return {clamped(low, v_), clamped(high, v_)};
  }

  /// The first sample at or after a coordinate.
  int clamped(double coordinate, int axis) const {
    return int(std::clamp(std::ceil(coordinate), 0.0, double(samples_[std::size_t(axis)])));
  }

  /// Triangles ordered by the first layer that they meet; those between lines are left out.
  void bin(int layers) {
    first_.assign(std::size_t(layers) + 1, 0);
    const auto each = [&](const auto& visit) {
      for (int t = 0; t < int(mesh_.triangles.size()); ++t)
        if (const auto [begin, end] = lines_of(t); begin < end) visit(std::size_t(begin / s_), t);
    };
    each([&](std::size_t layer, int) { ++first_[layer + 1]; });
    for (std::size_t layer = 0; layer < std::size_t(layers); ++layer) first_[layer + 1] += first_[layer];
    order_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    each([&](std::size_t layer, int t) { order_[next[layer]++] = t; });
  }

  struct Point {
    double u;
    double w;
  };
  /// Where an edge meets a line v. From its lower end, so that it is the same for both its triangles.
  Point on_edge(int low, int high, int line) const {
    const double t = (line - at(low, v_)) / (at(high, v_) - at(low, v_));
    return {at(low, u_) + t * (at(high, u_) - at(low, u_)), at(low, w_) + t * (at(high, w_) - at(low, w_))};
  }

  /// Adds the crossings of a triangle with the lines of one v. An edge meets v where one end lies at or below
  /// it and the other above: of a triangle's edges none does, or one upwards and one downwards. The triangle
  /// covers the u from the left one to before the right one.
  void cross(int t, int line) {
    const auto& triangle = mesh_.triangles[std::size_t(t)];
    Point up{};
    Point down{};
    bool met = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = triangle[c];
      const int b = triangle[(c + 1) % 3];
      const bool a_below = at(a, v_) <= line;
      if (a_below == (at(b, v_) <= line)) continue;
      met = true;
      (a_below ? up : down) = a_below ? on_edge(a, b, line) : on_edge(b, a, line);
    }
    if (!met) return;
    // counter-clockwise in (u, v), so facing along the line, if the edge upwards is on the right
    const bool leaves = (down.u < up.u) == (orientation_ > 0);
    const int begin = clamped(std::min(down.u, up.u), u_);
    const int end = clamped(std::max(down.u, up.u), u_);
    for (int u = begin; u < end; ++u) {
      const double share = std::clamp((u - down.u) / (up.u - down.u), 0.0, 1.0);
      const double depth = down.w + share * (up.w - down.w);
      crossings_.emplace_back(u / s_ * s_ * s_ + u % s_ + line % s_ * s_, clamped(depth, w_), !leaves, depth);
    }
    if (crossings_.size() > most_crossings)
      throw InputError(
          "has more than 33 million crossings with one layer of cells; give a mesh of the surface of a "
          "solid");
  }

  const TriangleMesh& mesh_;
  const std::vector<Vec3>& x_;
  double orientation_;
  int s_, w_, u_, v_;
  std::array<int, 3> samples_{};
  int layer_ = 0;
  std::vector<std::size_t> first_;  ///< by layer, into order_
  std::vector<int> order_;          ///< triangles
  std::vector<int> active_;         ///< those that meet this layer or the next
  std::vector<Crossing> crossings_;
};

/// Marks the samples inside along the s^2 lines of one column of cells.
class ColumnMasks {
 public:
  ColumnMasks(const SampleGrid& grid, int axis)
      : s_(grid.samples),
        step_(grid.bit_steps()[std::size_t(axis)]),
        step_u_(grid.bit_steps()[std::size_t(axis + 1) % 3]),
        step_v_(grid.bit_steps()[std::size_t(axis + 2) % 3]),
        masks_(std::size_t(grid.cells[std::size_t(axis)]) + 1),
        whole_(masks_.size()) {}

  void clear() {
    std::fill(masks_.begin(), masks_.end(), 0);
    std::fill(whole_.begin(), whole_.end(), 0);
  }

  /// From a sample on, inside becomes outside or the reverse.
  void toggle(int line_in_cell, int from) {
    const int shift = line_in_cell % s_ * step_u_ + line_in_cell / s_ * step_v_;
    std::uint64_t all = 0;
    std::uint64_t rest = 0;  // of the cell
    for (int i = 0; i < s_; ++i) {
      const std::uint64_t bit = std::uint64_t(1) << (i * step_ + shift);
      all |= bit;
      if (i >= from % s_) rest |= bit;
    }
    const auto cell = std::size_t(from / s_);
    masks_[cell] ^= rest;
    if (cell + 1 < whole_.size()) whole_[cell + 1] ^= all;
  }

  /// One mask per cell of the column.
  const std::vector<std::uint64_t>& finish() {
    std::uint64_t running = 0;
    for (std::size_t cell = 0; cell < masks_.size(); ++cell) {
      running ^= whole_[cell];
      masks_[cell] ^= running;
    }
    return masks_;
  }

 private:
  int s_;
  int step_;
  int step_u_;
  int step_v_;
  std::vector<std::uint64_t> masks_;  ///< one more than cells: lines may end behind the last
  std::vector<std::uint64_t> whole_;  ///< toggles of whole cells, from a cell on
};

/// Samples [begin, end) of a line along x have a winding number other than 0.
struct Run {
  int y;
  int z;
  int begin;
  int end;
  int winding;
};

/// One column of cells along an axis: `base`, `base + stride`, ...
struct Column {
  std::size_t base;
  std::size_t stride;
  int u;  ///< of its cells, along the axis after the column's
  int v;
};

/// What a sweep finds, for those who want it.
struct SweepVisitor {
  /// One mask per cell of a column, and one behind.
  std::function<void(const Column&, const std::vector<std::uint64_t>& masks)> on_column;
  /// The pieces of lines that are not outside. May be empty.
  std::function<void(const Run&)> on_run{};
};

/// Adds the samples before and after a crossing, if they are near.
void add_border(const Crossing& crossing, bool enters, const Column& column, int axis, const SampleGrid& grid,
                std::vector<BorderSample>& border) {
  const int s = grid.samples;
  const int in_cell = crossing.line() % (s * s);
  const std::array<int, 3> step = grid.bit_steps();
  const auto ax = std::size_t(axis);
  for (const bool after : {false, true}) {
    const int along = after ? crossing.from() : crossing.from() - 1;
    const float gap = after ? crossing.gap : 1 - crossing.gap;
    if (!(gap >= 0 && gap < 0.5F) || along < 0 || along >= grid.cells[ax] * s) continue;
    const int bit =
        along % s * step[ax] + in_cell % s * step[(ax + 1) % 3] + in_cell / s * step[(ax + 2) % 3];
    border.push_back({gap, std::uint32_t(column.base + std::size_t(along / s) * column.stride),
                      std::uint8_t(bit), after == enters});
  }
}

/// All lines along an axis.
void sweep(const TriangleMesh& mesh, const std::vector<Vec3>& positions, double orientation,
           const SampleGrid& grid, int axis, const SweepVisitor& visitor, std::vector<BorderSample>& border) {
  LineSweep lines(mesh, positions, orientation, grid, axis);
  const std::array<std::size_t, 3> strides{1, std::size_t(grid.cells[0]),
                                           std::size_t(grid.cells[0]) * std::size_t(grid.cells[1])};
  const auto u = std::size_t(axis + 1) % 3;
  const auto v = std::size_t(axis + 2) % 3;
  const int s = grid.samples;
  ColumnMasks masks(grid, axis);
  Column column{.base = 0, .stride = strides[std::size_t(axis)], .u = 0, .v = 0};
  for (column.v = 0; column.v < grid.cells[v]; ++column.v) {
    const std::vector<Crossing>& crossings = lines.next_layer();
    auto next = crossings.begin();
    for (column.u = 0; column.u < grid.cells[u]; ++column.u) {
      column.base = std::size_t(column.u) * strides[u] + std::size_t(column.v) * strides[v];
      masks.clear();
      int winding = 0;  // returns to 0 at the end of every line, because the surface is closed
      for (; next != crossings.end() && next->line() / (s * s) == column.u; ++next) {
        const int in_cell = next->line() % (s * s);
        const int after = winding + next->change();
        if ((winding > 0) != (after > 0)) {
          masks.toggle(in_cell, next->from());
          add_border(*next, after > 0, column, axis, grid, border);
        }
        winding = after;
        if (winding != 0 && visitor.on_run)
          visitor.on_run(Run{.y = column.u * s + in_cell % s,
                             .z = column.v * s + in_cell / s,
                             .begin = next->from(),
                             .end = std::next(next)->from(),
                             .winding = winding});
      }
      visitor.on_column(column, masks.finish());
    }
  }
}

/// Winding numbers of the closed surface at the samples of a few cells.
class CellsNearCaps {
 public:
  CellsNearCaps(const SampleGrid& grid, std::vector<std::size_t> cells)
      : grid_(grid), cells_(std::move(cells)), winding_(cells_.size() * grid.per_cell()) {
    if (cells_.empty()) return;
    slot_.assign(grid.cell_count(), -1);
    for (std::size_t i = 0; i < cells_.size(); ++i) slot_[cells_[i]] = int(i);
  }

  void set(const Run& run) {
    if (cells_.empty()) return;
    const int s = grid_.samples;
    for (int x = run.begin; x < run.end; ++x) {
      const int slot = slot_[grid_.index({x / s, run.y / s, run.z / s})];
      if (slot < 0) {
        x = x / s * s + s - 1;  // on to the next cell
        continue;
      }
      const int bit = x % s + s * (run.y % s + s * (run.z % s));
      winding_[std::size_t(slot) * grid_.per_cell() + std::size_t(bit)] =
          std::int16_t(std::clamp(run.winding, -1000, 1000));
    }
  }

  /// Calls visit(cell, bit, winding) for all their samples.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t i = 0; i < cells_.size(); ++i)
      for (std::size_t bit = 0; bit < grid_.per_cell(); ++bit)
        visit(cells_[i], int(bit), winding_[i * grid_.per_cell() + bit]);
  }

 private:
  const SampleGrid& grid_;
  std::vector<std::size_t> cells_;
  std::vector<int> slot_;              ///< by cell; -1: none of them
  std::vector<std::int16_t> winding_;  ///< by slot and bit
};

/// Finds the cells where caps may decide, and counts the samples that they leave undecided.
std::vector<std::size_t> cells_near(const WindingTree& caps, const SampleGrid& grid,
                                    std::int64_t& undecided) {
  std::vector<std::size_t> cells;
  const double half_diagonal = std::sqrt(3.0) / 2 * grid.cell_size;
  for (std::size_t cell = 0; cell < grid.cell_count(); ++cell) {
    const auto [winding, change] = caps.at(grid.centre(cell), half_diagonal);
    if (std::abs(winding - std::round(winding)) > 0.1) undecided += std::int64_t(grid.per_cell());
    if (std::abs(winding) + change >= 0.48) cells.push_back(cell);  // .02 for the dipoles
  }
  return cells;
}

/// The same samples by lines along y and z, and the majority of the three.
void vote(const TriangleMesh& mesh, const std::vector<Vec3>& positions, double orientation,
          const SampleGrid& grid, InsideSamples& result) {
  std::vector<std::uint64_t> differ(result.masks.size());
  std::int64_t contested = 0;
  for (const int axis : {1, 2}) {
    const auto on_column = [&](const Column& column, const std::vector<std::uint64_t>& masks) {
      for (std::size_t i = 0; i + 1 < masks.size(); ++i) {
        std::uint64_t& both = result.masks[column.base + i * column.stride];
        std::uint64_t& doubtful = differ[column.base + i * column.stride];
        if (axis == 1) {
          doubtful = both ^ masks[i];
          both &= masks[i];
        } else {
          contested += std::popcount(doubtful | (both ^ (masks[i] & ~doubtful)));
          both |= doubtful & masks[i];
        }
      }
    };
    sweep(mesh, positions, orientation, grid, axis, {.on_column = on_column}, result.border);
  }
  result.contested = double(contested);
}

}  // namespace

InsideSamples find_inside(const TriangleMesh& closed_mesh, std::size_t first_cap, double orientation,
                          const SampleGrid& grid) {
  std::vector<Vec3> positions(closed_mesh.vertices);  // in samples, from the first
  for (Vec3& x : positions) x = (x - grid.origin) / grid.spacing() - Vec3::Constant(0.5);

  // caps of large openings are long triangles, of which a tree of pieces knows more
  const WindingTree caps(closed_mesh, first_cap, 2 * grid.cell_size);
  std::int64_t undecided = 0;
  CellsNearCaps near(grid, first_cap < closed_mesh.triangles.size() ? cells_near(caps, grid, undecided)
                                                                    : std::vector<std::size_t>{});
  InsideSamples result;
  result.masks.resize(grid.cell_count());
  const auto on_column = [&](const Column& column, const std::vector<std::uint64_t>& masks) {
    std::copy(masks.begin(), masks.end() - 1, result.masks.begin() + std::ptrdiff_t(column.base));
  };
  const auto on_run = [&](const Run& run) {
    if (run.winding < 0) result.reversed += run.end - run.begin;
    if (run.winding > 1) result.overlapping += run.end - run.begin;
    near.set(run);
  };
  sweep(closed_mesh, positions, orientation, grid, 0, {on_column, on_run}, result.border);
  vote(closed_mesh, positions, orientation, grid, result);

  const auto count = [&] {
    result.inside = 0;
    for (const std::uint64_t mask : result.masks) result.inside += std::popcount(mask);
    return std::max(double(result.inside), 1.0);
  };
  result.undecided = double(undecided) / count();
  if (result.undecided <= most_undecided)
    near.for_each([&](std::size_t cell, int bit, int winding) {
      const double caps_there = orientation * caps.at(grid.sample(cell, bit)).winding;
      const std::uint64_t one = std::uint64_t(1) << bit;
      if (winding - caps_there > 0.5)
        result.masks[cell] |= one;
      else
        result.masks[cell] &= ~one;
    });
  const double all = count();
  result.overlapping /= all;
  result.reversed /= all;
  result.contested /= all;
  return result;
}

Vec3 centre_of(const std::vector<std::uint64_t>& masks, const SampleGrid& grid) {
  Vec3 sum = Vec3::Zero();  // from the origin
  double count = 0;
  for (std::size_t cell = 0; cell < masks.size(); ++cell)
    for (std::uint64_t rest = masks[cell]; rest != 0; rest &= rest - 1) {
      sum += grid.sample(cell, std::countr_zero(rest)) - grid.origin;
      ++count;
    }
  return grid.origin + sum / count;
}

void match_volume(InsideSamples& samples, double volume, const SampleGrid& grid) {
  const auto missing = std::int64_t(std::llround(volume / std::pow(grid.spacing(), 3))) - samples.inside;
  std::vector<BorderSample>& border = samples.border;
  std::erase_if(border, [&](const BorderSample& b) { return b.inside == (missing > 0); });
  const auto order = [](const BorderSample& b) {
    const std::uint64_t place = (std::uint64_t(b.cell) << 6 | b.bit) * 0x9e3779b97f4a7c15ULL;
    return std::tuple(std::lround(b.gap * 1e6F), (place ^ place >> 29) * 0xbf58476d1ce4e5b9ULL);
  };
  // each sample is there up to three times
  const std::size_t enough = std::min(border.size(), 3 * std::size_t(std::abs(missing)));
  const auto nearer = [&](const BorderSample& a, const BorderSample& b) { return order(a) < order(b); };
  std::partial_sort(border.begin(), border.begin() + std::ptrdiff_t(enough), border.end(), nearer);
  std::int64_t left = std::abs(missing);
  for (std::size_t i = 0; i < enough && left > 0; ++i) {
    std::uint64_t& mask = samples.masks[border[i].cell];
    const std::uint64_t bit = std::uint64_t(1) << border[i].bit;
    if (((mask & bit) != 0) != border[i].inside) continue;  // moved already
    mask ^= bit;
    --left;
  }
  samples.inside += (missing > 0 ? 1 : -1) * (std::abs(missing) - left);
}

}  // namespace mss
