#include "experiments/simulation/result_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <ostream>
#include <span>

#include "experiments/io/output.hpp"

namespace mss {

Table series_table(const std::vector<SeriesRow>& series) {
  std::vector<Column> columns;
  const std::span<const MeasureColumn> measured = columns_of(series.front());
  columns.reserve(measured.size());
  for (const MeasureColumn& column : measured)
    columns.push_back({std::string(column.name), std::string(column.unit)});
  for_each_component(series.front().reactions, [&](const std::string& name, double) {
    columns.push_back({name, "N"});
  });
  for_each_column(series.front().bodies, [&](const std::string& name, const char* unit, double) {
    columns.push_back({name, unit});
  });
  Table table(std::move(columns));
  for (const SeriesRow& m : series) {
    std::vector<Cell> row;
    row.reserve(table.columns().size());
    for (const MeasureColumn& column : measured) row.emplace_back(column.value(m));
    for_each_component(m.reactions, [&](const std::string&, double force) { row.emplace_back(force); });
    for_each_column(m.bodies,
                    [&](const std::string&, const char*, double number) { row.emplace_back(number); });
    table.add(std::move(row));
  }
  return table;
}

namespace {

constexpr const char* particle_columns = "id,rest_x,rest_y,rest_z,x,y,z,vx,vy,vz,mass\n";

void write_rows(std::ostream& stream, std::span<const ParticleRecord> particles, std::size_t first_id) {
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto& [rest, x, v, mass] = particles[p];
    stream << fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", first_id + p, rest[0], rest[1], rest[2], x[0],
                          x[1], x[2], v[0], v[1], v[2], mass);
  }
}

/// Calls take(records) with a rank's particles, some thousand at a time, on the lowest rank.
void move_to_lowest(const Communicator& ranks, int from, std::vector<ParticleRecord>& particles,
                    const std::function<void(std::span<const ParticleRecord>)>& take) {
  constexpr std::size_t most = 4096;
  const auto pass = [&](auto records) { ranks.pass(from, 0, std::as_writable_bytes(std::span(records))); };
  std::size_t left = particles.size();
  pass(std::span(&left, 1));
  std::vector<ParticleRecord> received(ranks.is_lowest() ? most : 0);
  for (std::size_t begin = 0; left > 0;) {
    const std::size_t count = std::min(left, most);
    const auto records = std::span(ranks.is_lowest() ? received : particles).subspan(begin, count);
    pass(records);
    if (ranks.is_lowest())
      take(records);
    else
      begin += count;
    left -= count;
  }
}

}  // namespace

void write_particles(std::ostream& stream, const std::vector<ParticleRecord>& particles) {
  stream << particle_columns;
  write_rows(stream, particles, 0);
}

void write_particles(const std::filesystem::path& file, const Communicator& ranks,
                     std::vector<ParticleRecord>& particles) {
  if (!ranks.is_lowest()) return move_to_lowest(ranks, ranks.rank(), particles, {});
  write_atomically(file, [&](std::ostream& stream) {
    write_particles(stream, particles);
    std::size_t id = particles.size();
    for (int rank = 1; rank < ranks.count(); ++rank)
      move_to_lowest(ranks, rank, particles, [&](std::span<const ParticleRecord> records) {
        write_rows(stream, records, id);
        id += records.size();
      });
  });
}

}  // namespace mss
