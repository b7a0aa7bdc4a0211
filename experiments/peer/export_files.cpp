#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/harness/number_file.hpp"
#include "experiments/io/output.hpp"
#include "experiments/peer/exchange.hpp"

namespace mss::peer {

namespace {

namespace fs = std::filesystem;

Json to_json(const Vec3& v) { return {v[0], v[1], v[2]}; }

Json planes_of(const Environment& environment) {
  Json planes = Json::array();
  for (const Plane& plane : environment.planes)
    planes.push_back({{"normal", to_json(plane.normal)},
                      {"point", to_json(plane.point)},
                      {"law", to_string(plane.contact)},
                      {"friction", plane.friction},
                      {"restitution", plane.restitution}});
  return planes;
}

/// Forces on particles, of all loads together.
Json loads_of(const Exchange& exchange) {
  const Body& body = *exchange.body;
  Field<double> force(body.lattice().size);
  exchange.system->loads().add(0.0, 0, body.lattice().size,
                               std::array{force.axis(0), force.axis(1), force.axis(2)});
  Json loads = Json::array();
  for (std::size_t id = 0; id < body.particle_count(); ++id)
    if (const Vec3 f = force.at(body.sites()[id]); !f.isZero(0))
      loads.push_back({{"id", id}, {"force", to_json(f)}});
  return loads;
}

Json damping_of(const BodyConfig& body) {
  const Damping& damping = body.damping;
  switch (damping.law) {
    case Damping::Law::none:
      return {{"law", "none"}};
    case Damping::Law::ratio:
      return {{"law", "ratio"}, {"ratio", damping.zeta}};
    case Damping::Law::thesis:
      return {{"law", "thesis"}};
    case Damping::Law::viscosity:
      return {{"law", "viscosity"}, {"viscosity", damping.viscosity}};
  }
  return {};
}

/// Null where parts differ, or where springs were given in place of a material.
Json elastic_of(const BodyConfig& body, double ElasticConstants::*constant) {
  if (!body.elastic || !body.parts.empty()) return {};
  return (*body.elastic).*constant;
}

Json scene_json(const Exchange& exchange) {
  const Scene& scene = exchange.scene;
  const BodyConfig& body = scene.body;
  const bool is_box = scene.voxel_file.empty() && !scene.mesh;
  const bool no_dampers = body.damping.law == Damping::Law::none;
  Json cells;
  if (is_box)
    for (const int count : body.voxels.size()) cells.push_back(count);
  return {
      {"format", exchange_format},
      {"name", scene.name},
      {"units", "SI: m, kg, s, N, Pa; z is up where gravity points down"},
      {"particles", exchange.body->particle_count()},
      {"gravity", to_json(scene.environment.gravity)},
      {"model", scene.model},
      {"density", body.parts.empty() ? Json(body.density) : Json()},
      {"young", elastic_of(body, &ElasticConstants::young)},
      {"poisson", elastic_of(body, &ElasticConstants::poisson)},
      {"viscosity",
       no_dampers || body.damping.law == Damping::Law::viscosity ? Json(body.damping.viscosity) : Json()},
      {"damping", damping_of(body)},
      {"cells", cells},
      {"cell_size", body.cell_size},
      {"planes", planes_of(scene.environment)},
      {"loads", loads_of(exchange)},
      {"duration", scene.solve.duration},
      {"sample_spacing", exchange.spacing},
      {"sample_times", exchange.times},
      {"tolerances", mss::to_json(scene)["expect"]},
      {"reference",
       {{"integrator", exchange.facts.integrator},
        {"dt", exchange.facts.dt},
        {"uncertainty", exchange.facts.uncertainty},
        {"provenance", exchange.provenance}}},
  };
}

std::string numbers(const Vec3& v) { return fmt::format("{},{},{}", v[0], v[1], v[2]); }

void write_particles(const Exchange& exchange, const fs::path& file) {
  const Body& body = *exchange.body;
  write_atomically(file, [&](std::ostream& stream) {
    stream << "id,x,y,z,mass,held,start_x,start_y,start_z,start_vx,start_vy,start_vz\n";
    for (std::size_t id = 0; id < body.particle_count(); ++id) {
      const std::ptrdiff_t site = body.sites()[id];
      stream << fmt::format("{},{},{},{:d},{},{}\n", id, numbers(body.rest_position(site)), body.mass(site),
                            !exchange.system->held().empty() && exchange.system->held().holds(site, 0),
                            numbers(exchange.start.x.at(site)), numbers(exchange.start.v.at(site)));
    }
  });
}

void write_springs(const Body& body, const fs::path& file) {
  write_atomically(file, [&](std::ostream& stream) {
    stream << "a,b,stiffness,rest_length,damping\n";
    body.for_each_spring(
        [&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double stiffness, double damping) {
          stream << fmt::format("{},{},{},{},{}\n", body.particle(a), body.particle(b), stiffness,
                                body.rest_length(slot.kind), damping);
        });
  });
}

void write_hexahedra(const Body& body, const fs::path& file) {
  write_atomically(file, [&](std::ostream& stream) {
    stream << "n0,n1,n2,n3,n4,n5,n6,n7,volume_stiffness,fold_guard_stiffness\n";
    body.for_each_cell([&](std::ptrdiff_t site) {
      for (int corner = 0; corner < 8; ++corner)
        stream << body.particle(site + body.lattice().corner(corner)) << ',';
      const SiteElements elements = body.elements_at(site);
      stream << fmt::format("{},{}\n", elements.volume, elements.fold_guard);
    });
  });
}

/// Kuhn's: of a cell one for each order in which its axes are gone along from corner 0 to 7.
void write_tetrahedra(const Body& body, const fs::path& file) {
  constexpr std::array<std::array<int, 4>, 6> kuhn{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  write_atomically(file, [&](std::ostream& stream) {
    stream << "a,b,c,d\n";
    body.for_each_cell([&](std::ptrdiff_t site) {
      const auto id = [&](int corner) { return body.particle(site + body.lattice().corner(corner)); };
      for (const auto& [a, b, c, d] : kuhn)
        stream << fmt::format("{},{},{},{}\n", id(a), id(b), id(c), id(d));
    });
  });
}

void write_reference(const Exchange& exchange, const fs::path& file) {
  const std::vector<std::ptrdiff_t>& sites = exchange.body->sites();
  write_atomically(file, [&](std::ostream& stream) {
    stream << "t,id,x,y,z,vx,vy,vz\n";
    for (const State<double>& sample : exchange.reference)
      for (std::size_t id = 0; id < sites.size(); ++id)
        stream << fmt::format("{},{},{},{}\n", sample.t, id, numbers(sample.x.at(sites[id])),
                              numbers(sample.v.at(sites[id])));
  });
}

/// The scene with the files that it refers to beside it, so that the folder can be moved.
void write_scene(Scene scene, const fs::path& directory) {
  const fs::path from = scene.file.parent_path();
  const auto copied = [&](const std::string& file, const std::string& stem) {
    std::string name = stem + fs::path(file).extension().string();
    write_atomically(directory / name, read_file(from / file));
    return name;
  };
  if (!scene.voxel_file.empty()) scene.voxel_file = copied(scene.voxel_file, "voxels");
  if (scene.mesh) {
    scene.mesh->file = copied(scene.mesh->file, "mesh");
    int part = 0;
    for (std::string& file : scene.mesh->part_files) file = copied(file, fmt::format("mesh_part_{}", ++part));
  }
  scene.file = directory / "scene.toml";
  write_atomically(scene.file, to_toml(scene, directory));
}

Json read_scene_json(const fs::path& file) {
  Json scene = Json::parse(read_file(file), nullptr, false);
  if (!scene.is_object() || scene.value("format", Json()) != exchange_format)
    throw InputError(
        fmt::format("{} is not the scene.json of an export of the format {}; make one with "
                    "`mss peer export`",
                    file.string(), exchange_format));
  return scene;
}

void read_reference(Exchange& exchange, const fs::path& path) {
  const NumberFile file(path);
  const std::vector<std::ptrdiff_t>& sites = exchange.body->sites();
  if (file.rows() != sites.size() * exchange.times.size())
    throw InputError(fmt::format(
        "{} has {} rows, and {} particles at {} times make {}; export the scene again", path.string(),
        file.rows(), sites.size(), exchange.times.size(), sites.size() * exchange.times.size()));
  const std::array<const char*, 6> names{"x", "y", "z", "vx", "vy", "vz"};
  std::array<const std::vector<double>*, 6> columns{};
  for (std::size_t c = 0; c < names.size(); ++c) columns[c] = &file.column(names[c]);
  const std::vector<double>& times = file.column("t");
  const std::vector<std::size_t> ids = file.ids("id");
  constexpr double rounding = 1e-6;  // of the time between samples
  std::size_t row = 0;
  for (const double t : exchange.times) {
    State<double>& sample = exchange.reference.emplace_back(exchange.start);
    sample.t = t;
    for (std::size_t id = 0; id < sites.size(); ++id) {
      if (ids[row] != id || !(std::abs(times[row] - t) <= rounding * exchange.spacing))
        throw InputError(fmt::format(
            "{}:{}: particle {} at t = {:.6g} is in the place of particle {} at t = {:.6g}; export the scene "
            "again",
            path.string(), file.line(row), ids[row], times[row], id, t));
      const std::ptrdiff_t site = sites[id];
      const auto at = [&](std::size_t c) { return (*columns[c])[row]; };
      sample.x.set(site, {at(0), at(1), at(2)});
      sample.v.set(site, {at(3), at(4), at(5)});
      if (!sample.x.at(site).allFinite() || !sample.v.at(site).allFinite())
        throw InputError(fmt::format("{}:{}: a number is not finite; export the scene again", path.string(),
                                     file.line(row)));
      ++row;
    }
  }
}

}  // namespace

void write_export(const Exchange& exchange, const fs::path& directory) {
  prepare_directory(directory);
  const DirectoryClaim claim(directory);
  fs::remove(directory / "scene.json");  // which is written last: without it the folder is no export
  write_scene(exchange.scene, directory);
  write_particles(exchange, directory / "particles.csv");
  write_springs(*exchange.body, directory / "springs.csv");
  write_hexahedra(*exchange.body, directory / "hexahedra.csv");
  write_tetrahedra(*exchange.body, directory / "tetrahedra.csv");
  if (!exchange.reference.empty()) write_reference(exchange, directory / "reference.csv");
  write_atomically(directory / "scene.json", scene_json(exchange).dump(2) + "\n");
}

Exchange read_export(const fs::path& directory) {
  if (!fs::is_directory(directory))
    throw InputError(
        fmt::format("{} is no folder; give one that `mss peer export` made", directory.string()));
  const fs::path file = directory / "scene.json";
  const Json json = read_scene_json(file);
  Scene scene = load_scene(directory / "scene.toml");
  try {
    scene.name = json.at("name").get<std::string>();
    Exchange exchange = make_exchange(scene, json.at("sample_spacing").get<double>());
    const Json& facts = json.at("reference");
    exchange.facts = {facts.at("integrator").get<std::string>(), facts.at("dt").get<double>(),
                      facts.at("uncertainty").get<double>()};
    exchange.provenance = facts.at("provenance");
    read_reference(exchange, directory / "reference.csv");
    return exchange;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{} is incomplete ({}); export the scene again", file.string(), error.what()));
  }
}

}  // namespace mss::peer
