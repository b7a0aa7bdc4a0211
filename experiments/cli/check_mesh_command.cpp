// `mss check-mesh`: what was repaired in a mesh, what is wrong with it, and what cells would lose of it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/mesh/read_mesh.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/mesh_slices.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

struct CheckMeshChoice {
  std::string file;
  std::optional<double> cell_size, cells;
  double scale = 1;
  std::string directory = "out/check-mesh";
};

double cell_size(const CheckMeshChoice& choice, const TriangleMesh& mesh) {
  if (choice.cell_size && choice.cells)
    throw InputError("--cell-size conflicts with --cells; give one of the two");
  const Box box = bounding_box(mesh);
  const double across = choice.cells.value_or(20);
  if (!(across >= 1))
    throw InputError(fmt::format("--cells is {}; give at least 1 along the longest extent", across));
  const double h = choice.cell_size.value_or((box.upper - box.lower).maxCoeff() / across);
  if (!(h > 0)) throw InputError(fmt::format("--cell-size is {}; give a length in metres, above 0", h));
  return h;
}

std::string shown(const Vec3& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x.x(), x.y(), x.z()); }

void print_line(const char* name, const std::string& value) { fmt::print("  {:<12} {}\n", name, value); }

void print_mesh(const TriangleMesh& mesh, const MeshReport& report) {
  const Box box = bounding_box(mesh);
  print_line("mesh", fmt::format("{} triangles, {} vertices, {} shell{}", report.triangles, report.vertices,
                                 report.shells, report.shells == 1 ? "" : "s"));
  print_line("box", shown(box.lower) + " to " + shown(box.upper));
  print_line("closed", report.open_edges == 0 ? "yes" : fmt::format("no, {} open edges", report.open_edges));
  print_line("volume", fmt::format("{:.6g} m^3", report.true_volume));
  print_line("centre", shown(report.true_centre));
}

void print_cells(const MeshFill& fill, const MeshReport& report) {
  print_line("cells", fmt::format("{} of {:.6g} m", fill.voxels.count(), fill.cell_size));
  print_line("their volume", fmt::format("{:.6g} m^3", report.filled_volume));
  print_line("their centre", shown(report.filled_centre));
}

/// What a scene warns of too: a size that nobody simulates in metres.
std::optional<std::string> other_unit(const CheckMeshChoice& choice, const TriangleMesh& mesh) {
  constexpr double largest = 50, smallest = 1e-3;  // [m]
  const Box box = bounding_box(mesh);
  const double extent = (box.upper - box.lower).maxCoeff();
  if (extent < smallest)
    return fmt::format(
        "it is {:.3g} m long: if it was meant larger, give another --scale, and the same body.mesh_scale "
        "in a scene",
        extent);
  if (extent <= largest) return std::nullopt;
  return fmt::format(
      "it is {:.3g} m long: if the file is in millimetres, give --scale {:g}, and body.mesh_scale = {:g} "
      "in a scene",
      extent, choice.scale / 1000, choice.scale / 1000);
}

void print_notes(const MeshReport& report, const std::optional<std::string>& more) {
  const std::vector<std::string> notes = report.notes();
  for (std::size_t i = 0; i < notes.size(); ++i)
    print_line(i < report.repairs.size() ? "file" : "note", notes[i]);
  if (more) print_line("note", *more);
  if (notes.empty() && !more) print_line("note", "nothing is wrong with it");
}

void draw_slices(const CheckMeshChoice& choice, const TriangleMesh& mesh, const MeshFill& fill) {
  if (gnuplot_version().empty()) {
    fmt::print(stderr, "mss: no picture, there is no gnuplot; install it\n");
    return;
  }
  prepare_directory(choice.directory);
  const fs::path stem = fs::path(choice.directory) / fs::path(choice.file).stem();
  draw(mesh_slices(mesh, fill), stem);
  print_line("picture", stem.string() + ".svg, " + stem.string() + ".png");
}

void check_mesh(const CheckMeshChoice& choice, int& exit_status) {
  if (!(choice.scale > 0))
    throw InputError(fmt::format("--scale is {}; give a positive number", choice.scale));
  MeshOfFile read = read_mesh(choice.file);
  place(read.mesh, {.scale = choice.scale});
  const MeshFill fill = fill_meshes({{.mesh = read.mesh, .name = choice.file, .repairs = read.repairs}},
                                    {.cell_size = cell_size(choice, read.mesh)});
  const MeshReport& report = fill.reports.at(0);
  fmt::print("{}\n", choice.file);
  print_mesh(read.mesh, report);
  print_cells(fill, report);
  print_notes(report, other_unit(choice, read.mesh));
  draw_slices(choice, read.mesh, fill);
  if (!report.lost.empty()) exit_status = exit_check_failed;
}

void add_check_mesh(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "check-mesh", "what is wrong with a mesh, what was repaired, and what cells would lose of it");
  const auto choice = std::make_shared<CheckMeshChoice>();
  command->add_option("file", choice->file, "An OBJ, STL or PLY file")->required();
  command->add_option("--cell-size", choice->cell_size, "Edge of a cell [m]");
  command->add_option("--cells", choice->cells, "Cells along the longest extent (default 20)");
  command->add_option("--scale", choice->scale, "Metres to a unit of the file (default 1)");
  command->add_option("--out", choice->directory, "Directory for the picture (default out/check-mesh)");
  command->footer("Exit status: 0 cells have all of it; 1 they miss parts of it; 2 it makes no body.");
  command->callback([choice, &exit_status] { check_mesh(*choice, exit_status); });
}

}  // namespace

Command check_mesh_command() { return add_check_mesh; }

}  // namespace mss::cli
