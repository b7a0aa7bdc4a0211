#include "experiments/simulation/vtk_series.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <numeric>
#include <span>

#include "core/base/error.hpp"
#include "core/base/field_part.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/spring_law.hpp"
#include "core/measures/cell_stress.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"

namespace mss {

namespace {

namespace fs = std::filesystem;

constexpr const char* kinds[] = {"cells", "springs", "surface"};

/// VTK's numbers for shapes, and its order of a hexahedron's corners: around the bottom, around the top.
constexpr std::uint8_t vtk_line = 3, vtk_triangle = 5, vtk_quad = 9, vtk_hexahedron = 12;

/// A cell, a square of a sheet or a link of a rope: its kind, and its corners in the order of that.
struct VtkShape {
  std::uint8_t kind;
  std::vector<int> corners;
};
VtkShape vtk_shape(const Body& body) {
  const std::vector<int>& c = body.corners();
  if (c.size() == 2) return {vtk_line, c};
  if (c.size() == 4) return {vtk_quad, {c[0], c[1], c[3], c[2]}};
  return {vtk_hexahedron, {0, 1, 3, 2, 4, 5, 7, 6}};
}

/// HDF5 reports failure by a negative number; errno may have the reason.
void check(std::int64_t result) {
  if (result < 0) throw InputError(errno != 0 ? std::strerror(errno) : "HDF5 gives no reason");
}

/// Where ranks write that have no file: only the lowest has one.
constexpr hid_t nowhere = H5I_INVALID_HID;

/// An HDF5 identifier, closed by the destructor. Throws if it could not be opened.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) { check(id); }
  /// Nowhere.
  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (close_) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): HDF5 takes numbers

 private:
  hid_t id_ = nowhere;
  herr_t (*close_)(hid_t) = nullptr;
};

/// In messages whose size an int can count.
template <class T>
void pass_to_lowest(const Communicator& ranks, int from, std::vector<T>& values) {
  constexpr std::size_t most = std::size_t(1) << 27U;
  for (std::size_t first = 0; first < values.size(); first += most)
    ranks.pass(
        from, 0,
        std::as_writable_bytes(std::span(values).subspan(first, std::min(most, values.size() - first))));
}

hid_t type_of(double) { return H5T_NATIVE_DOUBLE; }
hid_t type_of(std::int64_t) { return H5T_NATIVE_INT64; }
hid_t type_of(std::uint8_t) { return H5T_NATIVE_UINT8; }

/// A dataset of rows of `columns` numbers, opened to be written in portions.
template <class T>
class Dataset {
 public:
  Dataset(hid_t group, const char* name, hsize_t numbers, hsize_t columns)
      : columns_(columns),
        space_(H5Screate_simple(columns == 1 ? 1 : 2, std::array{numbers / columns, columns}.data(), nullptr),
               H5Sclose),
        untimed_(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
        set_(H5Dcreate2(group, name, type_of(T{}), space_, H5P_DEFAULT, untimed(), H5P_DEFAULT), H5Dclose) {}

  /// The rows after those before.
  void add(const std::vector<T>& values) {
    if (values.empty()) return;
    const std::array<hsize_t, 2> first{done_, 0}, count{values.size() / columns_, columns_};
    const Handle part(H5Screate_simple(columns_ == 1 ? 1 : 2, count.data(), nullptr), H5Sclose);
    check(H5Sselect_hyperslab(space_, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr));
    check(H5Dwrite(set_, type_of(T{}), part, space_, H5P_DEFAULT, values.data()));
    done_ += count[0];
  }

 private:
  /// Without the time of its making, so that equal runs leave equal files.
  hid_t untimed() {
    check(H5Pset_obj_track_times(untimed_, false));
    return untimed_;
  }

  hsize_t columns_, done_ = 0;
  Handle space_, untimed_, set_;
};

template <class T>
void write(hid_t group, const char* name, const std::vector<T>& values, hsize_t columns = 1) {
  if (group != nowhere) Dataset<T>(group, name, values.size(), columns).add(values);
}

/// The same of ranks that each have some of the rows, those of the lowest first: it gets the others' one
/// after the other.
template <class T>
void write_all(const Communicator& ranks, hid_t group, const char* name, std::vector<T> values,
               hsize_t columns = 1) {
  std::vector<std::size_t> sizes(std::size_t(ranks.count()), values.size());
  for (int rank = 1; rank < ranks.count(); ++rank)
    ranks.pass(rank, 0, std::as_writable_bytes(std::span(&sizes[std::size_t(rank)], 1)));
  if (!ranks.is_lowest()) return pass_to_lowest(ranks, ranks.rank(), values);
  Dataset<T> set(group, name, std::accumulate(sizes.begin(), sizes.end(), hsize_t(0)), columns);
  set.add(values);
  for (int rank = 1; rank < ranks.count(); ++rank) {
    values.resize(sizes[std::size_t(rank)]);
    pass_to_lowest(ranks, rank, values);
    set.add(values);
  }
}

void write_text(hid_t group, const char* name, const std::string& text) {
  if (group == nowhere) return;
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  check(H5Tset_size(type, text.size()));
  const Handle attribute(H5Acreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(attribute, type, text.data()));
}

void write_version(hid_t group) {
  if (group == nowhere) return;
  const hsize_t two = 2;
  const std::int64_t version[] = {1, 0};
  const Handle space(H5Screate_simple(1, &two, nullptr), H5Sclose);
  const Handle attribute(H5Acreate2(group, "Version", H5T_NATIVE_INT64, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  check(H5Awrite(attribute, H5T_NATIVE_INT64, version));
}

Handle new_group(hid_t parent, const char* name) {
  if (parent == nowhere) return {};
  return {H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}

/// Lets a name stand for what another file of the directory holds.
void link(hid_t group, const char* name, const fs::path& file, const std::string& object) {
  if (group == nowhere) return;
  check(H5Lcreate_external(file.filename().c_str(), object.c_str(), group, name, H5P_DEFAULT, H5P_DEFAULT));
}

/// Makes an HDF5 file beside its place, lets `fill` fill it, and puts it there: on the lowest rank. On others
/// fill(nowhere) hands over what they have of it.
template <class Fill>
void write_file(const Communicator& ranks, const fs::path& file, Fill&& fill) {
  if (!ranks.is_lowest()) return fill(nowhere);
  replace_atomically(file, [&](const fs::path& beside) {
    errno = 0;
    const Handle h5(H5Fcreate(beside.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    fill(h5);
    check(H5Fflush(h5, H5F_SCOPE_LOCAL));
  });
}

/// The shapes of an unstructured grid, all with the same number of corners: those of all ranks.
void write_shapes(const Communicator& ranks, hid_t group, std::uint8_t type, std::int64_t corners,
                  std::int64_t points, const std::vector<std::int64_t>& connectivity) {
  const std::int64_t own = std::int64_t(connectivity.size()) / corners;
  std::int64_t count = 0;
  std::vector<std::int64_t> offsets;
  ranks.add_in_order(count, [&] {
    for (const std::int64_t end = count + own; count < end; ++count) offsets.push_back(corners * count);
  });
  if (ranks.is_highest()) offsets.push_back(corners * count);
  write(group, "NumberOfPoints", std::vector<std::int64_t>{points});
  write(group, "NumberOfCells", std::vector<std::int64_t>{count});
  write(group, "NumberOfConnectivityIds", std::vector<std::int64_t>{corners * count});
  write_all(ranks, group, "Types", std::vector<std::uint8_t>(std::size_t(own), type));
  write_all(ranks, group, "Offsets", offsets);
  write_all(ranks, group, "Connectivity", connectivity);
}

/// Makes a group VTK's, with what `kind` has in common with all frames.
void describe_grid(hid_t group, const char* kind, const fs::path& mesh) {
  write_version(group);
  write_text(group, "Type", "UnstructuredGrid");
  for (const char* name :
       {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds", "Types", "Offsets", "Connectivity"})
    link(group, name, mesh, fmt::format("/{}/{}", kind, name));
}

template <class Real>
std::vector<double> by_point(const std::vector<Level>& levels, const Field<Real>& field) {
  std::vector<double> values;
  for (const auto& [body, first] : levels)
    for (const std::ptrdiff_t site : body.sites())
      for (int axis = 0; axis < 3; ++axis) values.push_back(double(field.axis(axis)[first + site]));
  return values;
}

std::vector<double> by_vertex(const std::vector<Vec3>& vectors) {
  std::vector<double> values;
  values.reserve(3 * vectors.size());
  for (const Vec3& vector : vectors) values.insert(values.end(), {vector[0], vector[1], vector[2]});
  return values;
}

/// Of all one after the other; their vertices are counted together.
std::vector<std::int64_t> triangle_corners(const std::vector<VtkSurface>& surfaces, std::int64_t& vertices) {
  std::vector<std::int64_t> corners;
  vertices = 0;
  for (const VtkSurface& surface : surfaces) {
    for (const std::array<int, 3>& triangle : surface.mesh.triangles)
      for (const int corner : triangle) corners.push_back(vertices + corner);
    vertices += std::int64_t(surface.mesh.vertices.size());
  }
  return corners;
}

template <class Real>
void write_cell_values(hid_t group, const std::vector<Level>& levels, const Field<Real>& x) {
  std::vector<double> volume_ratio, jacobian;
  for (const Level& level : levels)
    level.body.for_each_cell([&](std::ptrdiff_t site) {
      const std::array<Vec3, 8> corners = corners_of(level.body, x, level.first + site);
      double smallest = corner_volume(corners, 0);
      for (int c = 1; c < 8; ++c) smallest = std::min(smallest, corner_volume(corners, c));
      volume_ratio.push_back(trilinear_volume(corners) / level.body.cell_volume());
      jacobian.push_back(smallest / level.body.cell_volume());
    });
  const Communicator& ranks = levels.front().body.ranks();
  write_all(ranks, group, "volume_ratio", volume_ratio);
  write_all(ranks, group, "jacobian", jacobian);
}

/// As ParaView numbers a symmetric tensor's components: xx, yy, zz, xy, yz, xz.
void write_stress(const Communicator& ranks, hid_t group, const std::vector<Eigen::Matrix3d>& stress) {
  std::vector<double> components, equivalent;
  for (const Eigen::Matrix3d& s : stress) {
    components.insert(components.end(), {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)});
    equivalent.push_back(von_mises(s));
  }
  write_all(ranks, group, "stress", components, 6);
  write_all(ranks, group, "von_mises", equivalent);
}

template <class Real>
void write_spring_values(hid_t group, const std::vector<Level>& levels, const Field<Real>& x) {
  std::vector<double> stretch;
  std::vector<std::uint8_t> classes;
  for (const Level& level : levels)
    level.body.for_each_spring(
        [&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double, double) {
          classes.push_back(std::uint8_t(slot.kind));
          const double length = (x.at(level.first + b) - x.at(level.first + a)).norm();
          stretch.push_back(spring_strain(length, level.body.rest_length(slot.kind)));
        });
  const Communicator& ranks = levels.front().body.ranks();
  write_all(ranks, group, "stretch", stretch);
  write_all(ranks, group, "class", classes);
}

/// One vector each, as field data.
void write_reactions(hid_t grid, const Reactions& reactions) {
  if (reactions.holds.empty() && reactions.planes.empty() && reactions.obstacles.empty()) return;
  const Handle group = new_group(grid, "FieldData");
  for_each(reactions, [&](const std::string& name, const Vec3& force) {
    write(group, name.c_str(), std::vector<double>{force[0], force[1], force[2]}, 3);
  });
}

/// Whether a file is one of ours: cells_000012.vtkhdf, springs_000012.vtkhdf, mesh.h5.
bool is_part(const fs::path& file) {
  const std::string name = file.filename();
  return name == "mesh.h5" || (file.extension() == ".vtkhdf" &&
                               std::any_of(std::begin(kinds), std::end(kinds), [&](const char* kind) {
                                 return name.rfind(std::string(kind) + "_", 0) == 0;
                               }));
}

}  // namespace

void remove_vtk_series(const fs::path& directory) {
  std::error_code ignored;  // what cannot be removed cannot be written either, which is reported then
  for (const char* kind : kinds) fs::remove(directory / fmt::format("{}.vtkhdf.series", kind), ignored);
  std::vector<fs::path> parts;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory / "vtk", ignored))
    if (is_part(entry.path())) parts.push_back(entry.path());
  for (const fs::path& part : parts) fs::remove(part, ignored);
  fs::remove(directory / "vtk", ignored);  // if nothing else is in it
}

VtkSeries::VtkSeries(fs::path directory, std::vector<Level> levels, const std::vector<VtkSurface>& surfaces,
                     bool several_bodies)
    : directory_(std::move(directory)), levels_(std::move(levels)), several_bodies_(several_bodies) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // failures are exceptions, not pages on stderr
  for (const Level& level : levels_)
    if (level.body.config().voxels.dimensions() != levels_.front().body.config().voxels.dimensions())
      throw InputError("files for ParaView are of bodies that are all solid, all sheets or all ropes");
  number_points();
  for (const auto& [mesh, level] : surfaces) {
    const BodyConfig& config = levels_[level].body.config();
    surfaces_.push_back({EmbeddedSurface(mesh, config.voxels, config.cell_size, config.origin), level});
  }
  if (ranks().is_lowest()) {
    remove_vtk_series(directory_);
    prepare_directory(directory_ / "vtk");
  }
  write_mesh(surfaces);
}

/// In the order of particles; each rank those of its own planes and of the ghosts above, where its cells end.
void VtkSeries::number_points() {
  for (const Level& level : levels_) {
    const Body& body = level.body;
    const std::ptrdiff_t first = level.first;
    point_of_.resize(std::size_t(first + body.lattice().size), -1);
    std::int64_t next = 0;  // of the rank above
    ranks().add_in_order(points_, [&] {
      for (const std::ptrdiff_t site : body.sites()) point_of_[std::size_t(first + site)] = points_++;
      next = points_;
    });
    const Lattice& lattice = body.lattice();
    const std::ptrdiff_t above = lattice.plane * body.own_planes().last;
    for (std::ptrdiff_t site = above; site < lattice.sites; ++site)
      if (body.weights_at(site).mass > 0) point_of_[std::size_t(first + site)] = next++;
  }
}

fs::path VtkSeries::frame_file(const std::string& kind, std::size_t frame) const {
  return directory_ / "vtk" / fmt::format("{}_{:06}.vtkhdf", kind, frame);
}

void VtkSeries::write_mesh(const std::vector<VtkSurface>& surfaces) const {
  std::vector<std::int64_t> cells, springs;
  const VtkShape shape = vtk_shape(levels_.front().body);
  for (const Level& level : levels_) {
    const auto point = [&](std::ptrdiff_t site) { return point_of_[std::size_t(level.first + site)]; };
    level.body.for_each_piece([&](std::ptrdiff_t site) {
      for (const int c : shape.corners) cells.push_back(point(site + level.body.lattice().corner(c)));
    });
    level.body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double, double) {
      springs.push_back(point(a));
      springs.push_back(point(b));
    });
  }
  write_file(ranks(), directory_ / "vtk" / "mesh.h5", [&](hid_t file) {
    write_text(file, "mss", program_version());
    write_shapes(ranks(), new_group(file, "cells"), shape.kind, std::int64_t(shape.corners.size()), points_,
                 cells);
    write_shapes(ranks(), new_group(file, "springs"), vtk_line, 2, points_, springs);
    if (surfaces.empty()) return;
    std::int64_t vertices = 0;
    const std::vector<std::int64_t> corners = triangle_corners(surfaces, vertices);
    write_shapes(ranks(), new_group(file, "surface"), vtk_triangle, 3, vertices, corners);
  });
}

template <class Real>
void VtkSeries::add(double t, const Field<Real>& x, const Field<Real>& v, const CellStress& stress,
                    const Reactions& reactions) {
  const std::size_t frame = times_.size();
  const fs::path mesh = "mesh.h5", cells = frame_file("cells", frame);
  write_file(ranks(), cells, [&](hid_t file) {
    const Handle grid = new_group(file, "VTKHDF");
    describe_grid(grid, "cells", mesh);
    write_all(ranks(), grid, "Points", by_point(levels_, x), 3);
    write_all(ranks(), new_group(grid, "PointData"), "velocity", by_point(levels_, v), 3);
    if (levels_.front().body.config().is_solid()) {
      const Handle values = new_group(grid, "CellData");
      write_cell_values(values, levels_, x);
      if (stress) write_stress(ranks(), values, *stress);
      if (several_bodies_) write_bodies(values);
    }
    write_reactions(grid, reactions);
  });
  write_file(ranks(), frame_file("springs", frame), [&](hid_t file) {
    const Handle grid = new_group(file, "VTKHDF");
    describe_grid(grid, "springs", mesh);
    link(grid, "Points", cells, "/VTKHDF/Points");
    write_spring_values(new_group(grid, "CellData"), levels_, x);
  });
  if (!surfaces_.empty()) add_surface(frame_file("surface", frame), x, v);
  times_.push_back(t);
}

void VtkSeries::write_bodies(std::int64_t group) const {
  std::vector<std::uint8_t> bodies;
  for (std::size_t b = 0; b < levels_.size(); ++b)
    levels_[b].body.for_each_cell([&](std::ptrdiff_t) { bodies.push_back(std::uint8_t(b)); });
  write_all(ranks(), group, "body", bodies);
}

/// By vertex.
template <class Real>
std::vector<double> VtkSeries::on_surfaces(const Field<Real>& field) const {
  std::vector<double> values;
  for (const auto& [surface, level] : surfaces_) {
    const auto& [body, first] = levels_[level];
    const std::vector<double> of_one =
        by_vertex(surface.interpolate(part_of(field, first, body.lattice().size)));
    values.insert(values.end(), of_one.begin(), of_one.end());
  }
  return values;
}

template <class Real>
void VtkSeries::add_surface(const fs::path& file, const Field<Real>& x, const Field<Real>& v) const {
  write_file(ranks(), file, [&](hid_t h5) {
    const Handle grid = new_group(h5, "VTKHDF");
    describe_grid(grid, "surface", "mesh.h5");
    write(grid, "Points", on_surfaces(x), 3);
    write(new_group(grid, "PointData"), "velocity", on_surfaces(v), 3);
  });
}

void VtkSeries::finish() const {
  if (!ranks().is_lowest()) return;
  for (const std::string kind : kinds) {
    if (kind == "surface" && surfaces_.empty()) continue;
    Json frames = Json::array();
    for (std::size_t i = 0; i < times_.size(); ++i)
      frames.push_back({{"name", "vtk/" + frame_file(kind, i).filename().string()}, {"time", times_[i]}});
    write_atomically(directory_ / (kind + ".vtkhdf.series"),
                     Json{{"file-series-version", "1.0"}, {"files", frames}}.dump(1) + "\n");
  }
}

template void VtkSeries::add(double, const Field<float>&, const Field<float>&, const CellStress&,
                             const Reactions&);
template void VtkSeries::add(double, const Field<double>&, const Field<double>&, const CellStress&,
                             const Reactions&);

}  // namespace mss
