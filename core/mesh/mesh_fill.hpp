#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/body/cell_fill.hpp"
#include "core/body/voxels.hpp"
#include "core/mesh/lost_features.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace mss {

enum class FillMode : std::uint8_t {
  local,     ///< what 4^3 samples of a cell say about its octants and corners
  staircase  ///< a cell is full where its centre is inside
};

struct MeshFillConfig {
  double cell_size = 1;  ///< h [m]
  /// Shifts the lattice, in cells; only the fractions count. At 0 the body's box is in the lattice's middle.
  Vec3 offset = Vec3::Zero();
  FillMode mode = FillMode::local;
};

/// What was found in a mesh, and how well cells fill it.
struct MeshReport {
  std::vector<std::string> repairs{};  ///< of its file
  std::size_t triangles = 0;
  std::size_t vertices = 0;
  std::size_t open_edges = 0;          ///< directed, without partner
  std::size_t inconsistent_edges = 0;  ///< of two triangles that face opposite ways
  std::size_t zero_faces = 0;          ///< without area
  std::size_t shells = 0;              ///< parts that no vertex joins
  bool flipped = false;                ///< was inside out
  double true_volume = 0;              ///< by the divergence theorem, openings closed [m^3]
  double filled_volume = 0;            ///< of the samples inside, before parts that come later [m^3]
  double hidden_volume = 0;            ///< of those that a later part has instead [m^3]
  double undecided = 0;                ///< share of samples near openings, winding number .1 to .9
  double overlapping = 0;              ///< share of samples that are inside more than once
  double reversed = 0;                 ///< share of samples in shells that are inside out, not filled
  double contested = 0;                ///< share of samples on the surface, within rounding
  Vec3 true_centre = Vec3::Zero();     ///< of the volume that the surface encloses [m]
  Vec3 filled_centre = Vec3::Zero();   ///< of the samples inside, before parts that come later [m]
  std::vector<LostFeature> lost{};     ///< what no cell carries, the largest first
  double cell_size = 1;                ///< [m]
  int samples = 4;                     ///< per edge of a cell

  /// What a user should know, a sentence each; none for a mesh without faults in cells that fit it.
  std::vector<std::string> notes() const;
};

/// Cells that a mesh fills, with what they hold.
struct MeshFill {
  VoxelGrid voxels;
  double cell_size = 1;                     ///< h [m]
  Vec3 origin = Vec3::Zero();               ///< lower corner of the lattice [m]
  std::vector<CellContent> contents{};      ///< all different; the first is {part 0, full}
  std::vector<std::uint32_t> content_of{};  ///< by VoxelGrid::index(); 0 where there is no cell
  std::vector<MeshReport> reports{};        ///< one per mesh
};

/// A mesh that one part of a body fills.
struct MeshPart {
  TriangleMesh mesh;
  int part = 0;
  std::string name = "the mesh";       ///< as sentences about it begin, its file
  std::vector<std::string> repairs{};  ///< of its file
};

/// Cells with the shares of their octants that meshes fill. Where meshes overlap, the later one has the
/// space: a tumour is given after the organ around it.
///
/// A cell is there if one of its samples is inside, so the mass is that of all these samples.
///
/// Throws InputError for a mesh that encloses no volume, for one with more than most_undecided, or 1 percent
/// reversed, of its samples, for cells that are too many for a body (most_sites), and where nothing is
/// inside.
MeshFill fill_meshes(const std::vector<MeshPart>& parts, const MeshFillConfig& config);

/// Of one mesh, part 0.
MeshFill fill_mesh(const TriangleMesh& mesh, const MeshFillConfig& config,
                   const std::string& name = "the mesh");

}  // namespace mss
