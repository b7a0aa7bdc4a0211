#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/measures/cell_stress.hpp"
#include "core/measures/reactions.hpp"
#include "core/mesh/embedded_surface.hpp"

namespace mss {

/// Removes the series that an earlier run left in a directory, and nothing else.
void remove_vtk_series(const std::filesystem::path& directory);

/// A mesh that a body was given as.
struct VtkSurface {
  TriangleMesh mesh;
  std::size_t level = 0;  ///< whose cells carry it
};

/// A series that ParaView opens, in VTK's own format on HDF5: in a directory the files `cells.vtkhdf.series`,
/// `springs.vtkhdf.series` and, of a body given as a mesh, `surface.vtkhdf.series`, each of which lists its
/// frames with their times; the frames in `vtk/`.
///
/// Cells are hexahedra with their volume_ratio, their smallest corner's jacobian and, where the model knows
/// it, their stress (xx, yy, zz, xy, yz, xz) and its von_mises [Pa]; their points are the particles, with
/// velocity. A body with cells of several sizes has those of all its levels, one after the
/// other, and as points of a smaller cell the particles that follow those of larger ones too. Springs are
/// lines between the same points, with their stretch and their class (0 edge, 1 face diagonal, 2 body
/// diagonal). The surface is the mesh's triangles where the cells carry them, with the velocity of their
/// corners. Cells have the forces [N] of holds, planes and obstacles as field data, hold_0, ... plane_0, ...
/// obstacle_0, and torques, obstacle_0_torque [N m]. Which points belong together is stored once, in
/// `vtk/mesh.h5`. Several bodies are one after the other, and which one a cell is of is its `body`, from 0.
///
/// Where ranks share the body all of them make a series and call its functions; the lowest writes the files,
/// as one process would.
class VtkSeries {
 public:
  /// `levels`: the body's, which must outlive it, or of `several_bodies` one each. `surfaces`: of bodies in
  /// one process. Throws InputError if the directory cannot be written to, and for bodies of which some are
  /// solid and others sheets or ropes.
  VtkSeries(std::filesystem::path directory, std::vector<Level> levels,
            const std::vector<VtkSurface>& surfaces = {}, bool several_bodies = false);

  /// Writes a frame, whole or not at all; ghosts must be up to date. Throws InputError if that fails.
  template <class Real>
  void add(double t, const Field<Real>& x, const Field<Real>& v, const CellStress& stress,
           const Reactions& reactions);

  /// Writes the lists of frames.
  void finish() const;

 private:
  const Communicator& ranks() const { return levels_.front().body.ranks(); }
  void number_points();
  std::filesystem::path frame_file(const std::string& kind, std::size_t frame) const;
  void write_mesh(const std::vector<VtkSurface>& surfaces) const;
  void write_bodies(std::int64_t group) const;
  template <class Real>
  std::vector<double> on_surfaces(const Field<Real>& field) const;
  template <class Real>
  void add_surface(const std::filesystem::path& file, const Field<Real>& x, const Field<Real>& v) const;

  std::filesystem::path directory_;
  std::vector<Level> levels_;
  struct Carried {
    EmbeddedSurface surface;
    std::size_t level;
  };
  std::vector<Carried> surfaces_;
  bool several_bodies_;
  std::vector<std::int64_t> point_of_;  ///< by site
  std::int64_t points_ = 0;
  std::vector<double> times_;  ///< of the frames so far [s]
};

}  // namespace mss
