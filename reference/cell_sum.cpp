#include "reference/cell_sum.hpp"

namespace mss {

CellCorners corners_at(const Body& body, const Field<double>& field, std::ptrdiff_t site) {
  CellCorners corners;
  for (int c = 0; c < 8; ++c) corners.col(c) = field.at(site + body.lattice().corner(c));
  return corners;
}

CellSum::CellSum(const Body& body) : body_(body), cells_at_(body.particle_count()) {
  std::vector<std::ptrdiff_t> particle_at(std::size_t(body.lattice().size), -1);
  for (std::size_t p = 0; p < body.particle_count(); ++p)
    particle_at[std::size_t(body.sites()[p])] = std::ptrdiff_t(p);
  for (auto& cells : cells_at_) cells.fill(-1);
  body.for_each_cell([&](std::ptrdiff_t site) {
    for (int c = 0; c < 8; ++c) {
      const auto p = particle_at[std::size_t(site + body.lattice().corner(c))];
      cells_at_[std::size_t(p)][std::size_t(c)] = std::ptrdiff_t(cells_.size());
    }
    cells_.push_back(site);
  });
  shares_.resize(cells_.size());
}

}  // namespace mss
