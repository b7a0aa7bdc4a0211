#include "experiments/simulation/result_files.hpp"

#include <fmt/format.h>

#include <ostream>

namespace mss {

Table series_table(const std::vector<Measures>& series) {
  std::vector<Column> columns;
  for (const MeasureColumn& column : measure_columns)
    columns.push_back({std::string(column.name), std::string(column.unit)});
  Table table(std::move(columns));
  for (const Measures& m : series) {
    std::vector<Cell> row;
    for (const MeasureColumn& column : measure_columns) row.emplace_back(column.value(m));
    table.add(std::move(row));
  }
  return table;
}

void write_particles(std::ostream& stream, const std::vector<ParticleRecord>& particles) {
  stream << "id,rest_x,rest_y,rest_z,x,y,z,vx,vy,vz,mass\n";
  for (std::size_t id = 0; id < particles.size(); ++id) {
    const auto& [rest, x, v, mass] = particles[id];
    stream << fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", id, rest[0], rest[1], rest[2], x[0], x[1],
                          x[2], v[0], v[1], v[2], mass);
  }
}

}  // namespace mss
