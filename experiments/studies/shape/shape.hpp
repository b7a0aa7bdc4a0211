#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::shape {

/// A body whose surface is a mesh, and what its free vibrations are compared with.
struct ShapeBody {
  std::string name;
  TriangleMesh mesh;
  double across;          ///< what is counted in cells: a diameter or an edge [m]
  bool aligned = false;   ///< faces lie on faces of cells: the mesh is not moved in the lattice
  bool sphere = false;    ///< else a bar
  int most_cells = 1000;  ///< across it that are tried
};

/// How the cells at the surface are filled.
struct Filling {
  std::string name;                       ///< "staircase", "even", "local"
  std::optional<double> blend_mass = {};  ///< of BodyConfig, for "local"
  std::string label() const;
};

/// Settings of `mss shape`.
struct ShapeConfig {
  std::vector<ShapeBody> bodies;
  std::vector<Filling> fillings;
  std::vector<int> cells;             ///< across a body
  std::vector<int> reference_cells;   ///< of the aligned bar: three sizes, each twice the one before
  int offsets = 3;                    ///< random places in the lattice that frequencies are averaged over
  int step_offsets = 24;              ///< that the largest step is the worst of
  std::vector<double> step_poissons;  ///< of the bodies whose largest step is measured
  ElasticConstants material{.young = 1e5, .poisson = 0.3};
  double density = 1000;
  double face_share = 1;
  std::uint64_t seed = 1;
};
ShapeConfig shape_config(const ExperimentOptions& options);

/// The body in cells at a place in the lattice, given in cells.
BodyConfig in_cells(const ShapeConfig& config, const ShapeBody& body, const Filling& filling, int across,
                    const Vec3& place, double poisson);

struct ShapeTables {
  Table rows;  ///< a body's frequencies at one place in the lattice
  /// Its largest frequency beside that of a full body of the same cells, its slowest beside the slowest that
  /// there should be.
  Table steps;
  Table reference;  ///< frequencies of the bar
  Status status = Status::ok;
};
/// A case per size of the aligned bar, then one per body, size and filling; see compute_cases().
ShapeTables measure_shape(const ShapeConfig& config, int processes, Journal& journal, Progress& progress);

/// Root mean squares over places in the lattice, and the order from one number of cells to the next.
Table shape_summary(const Table& rows);
/// The worst over places in the lattice.
Table step_summary(const Table& steps);

std::vector<NamedTable> shape_files(const ShapeConfig& config, const ShapeTables& tables);

}  // namespace mss::studies::shape
