#include "core/mesh/mesh_fill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/limits.hpp"
#include "core/mesh/inside_samples.hpp"
#include "core/mesh/mesh_repair.hpp"

namespace mss {

namespace {

constexpr double most_reversed = 0.01;

Box box_of(const std::vector<MeshPart>& parts) {
  Box all = bounding_box(parts.front().mesh);
  for (const MeshPart& part : parts) {
    const Box box = bounding_box(part.mesh);
    all.lower = all.lower.cwiseMin(box.lower);
    all.upper = all.upper.cwiseMax(box.upper);
  }
  return all;
}

SampleGrid grid_around(const std::vector<MeshPart>& parts, const MeshFillConfig& config) {
  const double h = config.cell_size;
  const Box box = box_of(parts);
  SampleGrid grid{.cell_size = h, .samples = config.mode == FillMode::local ? 4 : 1};
  double sites = 1;
  for (int a = 0; a < 3; ++a) {
    // Coordinates of most STL and PLY files are in single precision: a body of whole cells may come out
    // longer by rounding.
    const double cells = (box.upper[a] - box.lower[a]) / h,
                 fitting = std::max(1.0, std::ceil(cells * (1 - 1e-6)));
    const double shift = config.offset[a] - std::floor(config.offset[a]);
    const double count = shift > 0 ? fitting + 1 : fitting;
    sites *= count + 1;
    grid.cells[std::size_t(a)] = int(std::min(count, 1e9));
    grid.origin[a] = (box.lower[a] + box.upper[a] - fitting * h) / 2 + (shift > 0 ? shift - 1 : 0) * h;
  }
  if (!(sites <= most_sites()))
    throw InputError(
        fmt::format("{}: cells of {:.3g} m make a lattice of {:.3g} million particles around it; give "
                    "larger cells, at most {:.0f} million particles fit",
                    parts.front().name, h, sites / 1e6, most_sites() / 1e6));
  constexpr double farthest = 1e10;  // cells: beyond it rounding moves vertices by a millionth of one
  const double far = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
  if (!(far <= farthest * h))
    throw InputError(fmt::format(
        "{}: it is {:.3g} m from the origin, where cells of {:.3g} m are lost in rounding; move it "
        "nearer, to at most {:.3g} m",
        parts.front().name, far, h, farthest * h));
  return grid;
}

[[noreturn]] void refuse(const MeshPart& part, const std::string& sentence) {
  throw InputError(part.name + ": " + sentence);
}

/// Refuses a mesh without an inside where the reason is how its triangles are turned.
void refuse_turned(const MeshPart& part, const MeshReport& report) {
  if (report.inconsistent_edges > 0)
    refuse(part,
           fmt::format("triangles are turned inconsistently along {} of its edges, so that inside has no "
                       "meaning; turn them the same way",
                       report.inconsistent_edges));
}

/// Samples inside one mesh; fills the report.
std::vector<std::uint64_t> samples_of(const MeshPart& part, const SampleGrid& grid, MeshReport& report) {
  const TriangleMesh& mesh = part.mesh;
  const std::vector<OpenEdge> open = open_edges(mesh);
  report = {.repairs = part.repairs,
            .triangles = mesh.triangles.size(),
            .vertices = mesh.vertices.size(),
            .open_edges = open.size(),
            .inconsistent_edges = inconsistent_edges(mesh),
            .zero_faces = zero_faces(mesh),
            .shells = shells(mesh)};
  const TriangleMesh whole = open.empty() ? TriangleMesh{} : closed(mesh, open);
  const TriangleMesh& surface = open.empty() ? mesh : whole;
  const double volume = enclosed_volume(surface);
  if (!(std::abs(volume) > 1e-9 * std::pow(surface_area(mesh), 1.5))) {
    refuse_turned(part, report);
    if (!open.empty())
      refuse(part, fmt::format("is an open surface that encloses no volume, {} of its edges have no "
                               "partner; close it",
                               open.size()));
    refuse(part, report.shells == 1 ? "encloses no volume; give the surface of a solid"
                                    : "encloses no volume in all; turn around the shells that are inside "
                                      "out, or give the surface of a solid");
  }
  report.flipped = volume < 0;
  report.true_volume = std::abs(volume);
  InsideSamples samples;
  try {
    samples = find_inside(surface, mesh.triangles.size(), volume < 0 ? -1 : 1, grid);
  } catch (const InputError& error) {
    refuse(part, error.what());
  }
  const bool simple = open.empty() && samples.overlapping == 0 && samples.reversed == 0;
  if (simple && grid.samples > 1) match_volume(samples, report.true_volume, grid);
  report.filled_volume = double(samples.inside) * std::pow(grid.spacing(), 3);
  report.undecided = samples.undecided;
  report.overlapping = samples.overlapping;
  report.reversed = samples.reversed;
  report.contested = samples.contested;
  if (samples.undecided > most_undecided) {
    refuse_turned(part, report);
    refuse(part, fmt::format(
                     "has openings so large that inside has no meaning, {} of its edges have no partner and "
                     "{:.0f} percent of the volume is undecided; close it",
                     open.size(), 100 * samples.undecided));
  }
  if (samples.reversed > most_reversed)
    refuse(part,
           fmt::format("has a shell that is inside out, {:.0f} percent of the volume is in such; turn its "
                       "triangles around",
                       100 * samples.reversed));
  report.lost = find_lost_features(surface, mesh.triangles.size(), volume < 0 ? -1 : 1, samples.masks, grid);
  report.true_centre = centroid(surface);
  if (samples.inside > 0) report.filled_centre = centre_of(samples.masks, grid);
  report.cell_size = grid.cell_size;
  report.samples = grid.samples;
  return std::move(samples.masks);
}

/// What 4^3 samples say about a cell.
CellFill fill_of(std::uint64_t mask) {
  if (mask == ~std::uint64_t(0)) return CellFill::even(1);
  CellFill fill;
  for (int bit = 0; bit < 64; ++bit) {
    if ((mask >> bit & 1) == 0) continue;
    const std::array<int, 3> at{bit & 3, bit >> 2 & 3, bit >> 4};
    const int octant = at[0] / 2 + at[1] / 2 * 2 + at[2] / 2 * 4;
    fill.octant[std::size_t(octant)] += 1.0F / 8;
    for (unsigned c = 0; c < 8; ++c) {
      float weight = 1;  // in eighths along an axis, so that sums are exact
      for (unsigned a = 0; a < 3; ++a) {
        const float to_upper = (float(at[a]) + 0.5F) / 4;
        weight *= corner_bit(c, a) != 0 ? to_upper : 1 - to_upper;
      }
      fill.corner[c] += weight / 8;
    }
  }
  return fill;
}

/// The entry of a part in a cell, made if it is not there.
CellFill& entry(CellContent& content, int part) {
  const auto after =
      std::find_if(content.begin(), content.end(), [&](const PartFill& p) { return p.part >= part; });
  if (after != content.end() && after->part == part) return after->fill;
  return content.insert(after, {part, CellFill::even(0)})->fill;
}

/// Numbers for contents, equal ones for equal contents.
class ContentTable {
 public:
  ContentTable() { number({PartFill{}}); }

  std::uint32_t number(const CellContent& content) {
    const auto [found, is_new] = numbers_.emplace(content, std::uint32_t(contents_.size()));
    if (is_new) contents_.push_back(content);
    return found->second;
  }
  std::vector<CellContent> take() { return std::move(contents_); }

 private:
  struct Hash {
    std::size_t operator()(const CellContent& content) const {
      std::size_t hash = content.size();
      const auto add = [&](std::uint32_t bits) { hash = (hash ^ bits) * 0x9e3779b97f4a7c15ULL; };
      for (const PartFill& p : content) {
        add(std::uint32_t(p.part));
        for (const float f : p.fill.octant) add(std::bit_cast<std::uint32_t>(f));
        for (const float f : p.fill.corner) add(std::bit_cast<std::uint32_t>(f));
      }
      return hash ^ hash >> 32;
    }
  };
  std::unordered_map<CellContent, std::uint32_t, Hash> numbers_;
  std::vector<CellContent> contents_;
};

/// Turns samples into the contents of cells.
class CellFiller {
 public:
  CellFiller(const SampleGrid& grid, const std::vector<MeshPart>& parts,
             const std::vector<std::vector<std::uint64_t>>& masks)
      : grid_(grid), parts_(parts), masks_(masks), voxels_(grid.cells[0], grid.cells[1], grid.cells[2]) {
    for (std::size_t cell = 0; cell < grid.cell_count(); ++cell) {
      const auto [i, j, k] = grid.cell(cell);
      if (is_filled(cell)) voxels_.set(i, j, k, true);
    }
  }

  MeshFill finish() {
    MeshFill fill{.voxels = std::move(voxels_), .cell_size = grid_.cell_size, .origin = grid_.origin};
    fill.content_of.resize(grid_.cell_count());
    ContentTable table;
    for (std::size_t cell = 0; cell < grid_.cell_count(); ++cell) {
      const auto [i, j, k] = grid_.cell(cell);
      if (!fill.voxels.at(i, j, k)) continue;
      fill.content_of[cell] = table.number(content_of(cell));
    }
    fill.contents = table.take();
    return fill;
  }

 private:
  bool is_filled(std::size_t cell) const {
    return std::any_of(masks_.begin(), masks_.end(), [&](const auto& of_part) { return of_part[cell] != 0; });
  }

  CellContent content_of(std::size_t cell) const {
    CellContent content;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const std::uint64_t mask = masks_[p][cell];
      if (mask == 0) continue;
      CellFill& fill = entry(content, parts_[p].part);
      const CellFill more = grid_.samples == 1 ? CellFill::even(1) : fill_of(mask);
      for (std::size_t c = 0; c < 8; ++c) {
        fill.octant[c] += more.octant[c];
        fill.corner[c] += more.corner[c];
      }
    }
    return content;
  }

  const SampleGrid& grid_;
  const std::vector<MeshPart>& parts_;
  const std::vector<std::vector<std::uint64_t>>& masks_;
  VoxelGrid voxels_;
};

/// Removes from every mesh the samples that a later one has.
void give_way(std::vector<std::vector<std::uint64_t>>& masks, double sample_volume,
              std::vector<MeshReport>& reports) {
  for (std::size_t cell = 0; cell < masks.front().size(); ++cell) {
    std::uint64_t taken = 0;
    for (std::size_t p = masks.size(); p-- > 0;) {
      std::uint64_t& mask = masks[p][cell];
      reports[p].hidden_volume += std::popcount(mask & taken) * sample_volume;
      taken |= std::exchange(mask, mask & ~taken);
    }
  }
}

std::string shown(const Vec3& x) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", x.x(), x.y(), x.z()); }

/// A part that no cell carries: where, how thick, how much.
std::string sentence(const LostFeature& lost, const MeshReport& report) {
  std::string text = fmt::format(
      "cells of {:.3g} m miss its part from {} to {} m, about {:.2g} m thick: {:.3g} m^3, {:.2g} "
      "percent of the volume",
      report.cell_size, shown(lost.box.lower), shown(lost.box.upper), lost.thickness(), lost.volume,
      100 * lost.volume / report.true_volume);
  if (report.filled_volume > report.true_volume - lost.volume / 2) text += ", which other cells have instead";
  const double fine_enough = report.samples * lost.thickness();
  if (fine_enough > 0 && fine_enough < report.cell_size)
    text += fmt::format("; cells of at most {:.2g} m would have it", fine_enough);
  return text;
}

void add_lost(const MeshReport& report, std::vector<std::string>& notes) {
  constexpr std::size_t most = 3;
  if (report.lost.empty()) return;
  double rest = 0;
  for (std::size_t i = 0; i < report.lost.size(); ++i)
    if (i < most)
      notes.push_back(sentence(report.lost[i], report));
    else
      rest += report.lost[i].volume;
  if (report.lost.size() > most)
    notes.push_back(fmt::format("they miss {} smaller parts, {:.2g} percent of the volume together",
                                report.lost.size() - most, 100 * rest / report.true_volume));
  notes.push_back(fmt::format("so the centre of the cells' volume is {} m, and that of the mesh {} m",
                              shown(report.filled_centre), shown(report.true_centre)));
}

}  // namespace

std::vector<std::string> MeshReport::notes() const {
  std::vector<std::string> notes = repairs;
  const auto percent = [](double share) {
    return share < 0.995 ? fmt::format("{:.2g} percent", 100 * share)
                         : fmt::format("{:.0f} percent", 100 * share);
  };
  if (flipped) notes.emplace_back("it is inside out, and was turned around");
  if (open_edges > 0)
    notes.push_back(
        fmt::format("{} of its edges have no partner, and its openings leave {} of the volume undecided",
                    open_edges, percent(undecided)));
  if (inconsistent_edges > 0)
    notes.push_back(
        fmt::format("its triangles are turned inconsistently along {} of these", inconsistent_edges));
  if (zero_faces > 0) notes.push_back(fmt::format("{} of its triangles have no area", zero_faces));
  if (shells > 1) notes.push_back(fmt::format("it has {} shells", shells));
  if (overlapping > 0)
    notes.push_back(percent(overlapping) + " of the volume is inside more than once, and counts once");
  if (reversed > 0)
    notes.push_back(percent(reversed) + " of the volume is in parts that are inside out, and is left out");
  if (hidden_volume > 0)
    notes.push_back(percent(hidden_volume / filled_volume) +
                    " of the volume belongs to parts that come later");
  if (std::abs(filled_volume - true_volume) > 0.01 * true_volume)
    notes.push_back(fmt::format("cells fill {:.4g} m^3 where the surface encloses {:.4g} m^3", filled_volume,
                                true_volume));
  add_lost(*this, notes);
  return notes;
}

MeshFill fill_meshes(const std::vector<MeshPart>& parts, const MeshFillConfig& config) {
  for (const MeshPart& part : parts)
    if (part.mesh.triangles.empty()) refuse(part, "has no triangles; give the surface of a solid");
  const SampleGrid grid = grid_around(parts, config);
  std::vector<MeshReport> reports(parts.size());
  std::vector<std::vector<std::uint64_t>> masks;
  for (std::size_t p = 0; p < parts.size(); ++p) masks.push_back(samples_of(parts[p], grid, reports[p]));
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (reports[p].filled_volume == 0)
      refuse(
          parts[p],
          fmt::format("is too thin for cells of {:.3g} m, no point of them that was tried lies inside; give "
                      "smaller cells",
                      config.cell_size));
  give_way(masks, std::pow(grid.spacing(), 3), reports);
  MeshFill fill = CellFiller(grid, parts, masks).finish();
  fill.reports = std::move(reports);
  return fill;
}

MeshFill fill_mesh(const TriangleMesh& mesh, const MeshFillConfig& config, const std::string& name) {
  return fill_meshes({{mesh, 0, name}}, config);
}

}  // namespace mss
