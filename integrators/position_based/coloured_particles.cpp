#include "integrators/position_based/coloured_particles.hpp"

#include <algorithm>
#include <map>

namespace mss {

template <class Real>
ColouredParticles<Real>::ColouredParticles(const SpringSystem<Real>& springs, System<Real>& system)
    : body_(springs.body()),
      system_(system),
      kernel_(fastest_copy<XpbdKernel<Real>>()),
      lattice_(body_.lattice()) {
  for (Field<Real>* field : {&x_, &v_, &u_, &acceleration_, &inverse_mass_})
    *field = Field<Real>(lattice_.size());
  const Lattice& sites = body_.lattice();
  for (const std::ptrdiff_t site : body_.sites()) {
    const auto [i, j, k] = sites.coordinates(site);
    index_.push_back(lattice_.index(i, j, k));
  }
  find_masses(springs.held());
}

template <class Real>
void ColouredParticles<Real>::find_masses(const HeldSites& held_sites) {
  mass_kind_.assign(std::size_t(lattice_.size()), 0);
  std::map<double, std::uint32_t> kind_of{{0, 0}};
  for (std::size_t p = 0; p < index_.size(); ++p) {
    const std::ptrdiff_t site = body_.sites()[p];
    const double inverse = 1 / body_.mass(site);
    int held = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool holds = held_sites.holds(site, axis);
      held += holds ? 1 : 0;
      inverse_mass_.axis(axis)[index_[p]] = static_cast<Real>(holds ? 0 : inverse);
    }
    partly_held_ = partly_held_ || (held > 0 && held < 3);
    const auto [known, is_new] = kind_of.try_emplace(held < 3 ? inverse : 0, std::uint32_t(masses_.size()));
    if (is_new) masses_.push_back(inverse);
    mass_kind_[std::size_t(index_[p])] = known->second;
  }
}

template <class Real>
template <class Visit>
void ColouredParticles<Real>::for_each_half_row(Visit&& visit) const {
  const Lattice& sites = body_.lattice();
  for (int k = 0; k <= sites.cells[2]; ++k)
    for (int j = 0; j <= sites.cells[1]; ++j)
      for (int parity = 0; parity <= std::min(1, sites.cells[0]); ++parity)
        visit(lattice_.index(parity, j, k), sites.site(parity, j, k), (sites.cells[0] - parity) / 2 + 1);
}

template <class Real>
void ColouredParticles<Real>::load_state(const State<Real>& state) {
  const auto copy = [&](Field<Real>& to, const Field<Real>& from) {
    for_each_half_row([&](std::ptrdiff_t index, std::ptrdiff_t site, int count) {
      for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < count; ++i)
          to.axis(axis)[index + i] = from.axis(axis)[site + std::ptrdiff_t(2) * i];
    });
  };
  copy(x_, state.x);
  copy(v_, state.v);
}

template <class Real>
void ColouredParticles<Real>::load_acceleration(const Field<Real>& acceleration) {
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t p = 0; p < index_.size(); ++p)
      acceleration_.axis(axis)[index_[p]] =
          inverse_mass_.axis(axis)[index_[p]] > 0 ? acceleration.axis(axis)[body_.sites()[p]] : Real(0);
}

template <class Real>
void ColouredParticles<Real>::store_state(State<Real>& state) const {
  const auto copy = [&](Field<Real>& to, const Field<Real>& from) {
    for_each_half_row([&](std::ptrdiff_t index, std::ptrdiff_t site, int count) {
      for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < count; ++i)
          to.axis(axis)[site + std::ptrdiff_t(2) * i] = from.axis(axis)[index + i];
    });
  };
  copy(state.x, x_);
  copy(state.v, v_);
}

template <class Real>
void ColouredParticles<Real>::pass_over_plane(double dt, Field<Real>& target, int parity,
                                              std::ptrdiff_t plane, StepPass pass) {
  const auto streams = [](Field<Real>& f) { return Streams<Real>{{f.axis(0), f.axis(1), f.axis(2)}}; };
  ProjectionStep<Real> range{0,
                             0,
                             streams(x_),
                             streams(v_),
                             streams(u_),
                             streams(target),
                             {{acceleration_.axis(0), acceleration_.axis(1), acceleration_.axis(2)}},
                             static_cast<Real>(dt)};
  for (int part = 4 * parity; part < 4 * parity + 4; ++part) {
    range.first = lattice_.neighbour(part, 0, 0, 0) + plane * lattice_.plane;
    range.last = range.first + lattice_.used(kernel_.lanes);
    pass(range);
  }
}

template <class Real>
void ColouredParticles<Real>::pass_over_all(double dt, Field<Real>& target, StepPass pass) {
  system_.parallel(lattice_.planes_in_part, [&](std::ptrdiff_t plane) {
    for (const int parity : {0, 1}) pass_over_plane(dt, target, parity, plane, pass);
  });
}

template <class Real>
void ColouredParticles<Real>::predict(double dt, Field<Real>& target) {
  pass_over_all(dt, target, kernel_.predict);
}

template <class Real>
void ColouredParticles<Real>::proceed(double dt, Field<Real>& target) {
  pass_over_all(dt, target, kernel_.proceed);
}

template <class Real>
void ColouredParticles<Real>::proceed(double dt, Field<Real>& target, int parity, std::ptrdiff_t plane) {
  pass_over_plane(dt, target, parity, plane, kernel_.proceed);
}

template <class Real>
void ColouredParticles<Real>::set_displacement(std::ptrdiff_t site, int axis, Real u) {
  u_.axis(axis)[index_[std::size_t(body_.particle(site))]] = u;
}

template <class Real>
void ColouredParticles<Real>::finish(double dt) {
  pass_over_all(dt, u_, kernel_.finish);
}

template <class Real>
ConstStreams<Real> ColouredParticles<Real>::before() const {
  return {{x_.axis(0), x_.axis(1), x_.axis(2)}};
}
template <class Real>
ConstStreams<Real> ColouredParticles<Real>::velocity_before() const {
  return {{v_.axis(0), v_.axis(1), v_.axis(2)}};
}
template <class Real>
Streams<Real> ColouredParticles<Real>::moved() {
  return {{u_.axis(0), u_.axis(1), u_.axis(2)}};
}
template <class Real>
ConstStreams<Real> ColouredParticles<Real>::inverse_mass() const {
  return {{inverse_mass_.axis(0), inverse_mass_.axis(1), inverse_mass_.axis(2)}};
}

ColouredBlocks::ColouredBlocks(const ColouredLattice& lattice, int lanes, int lane_size,
                               const Describe& describe)
    : lane_size_(lane_size) {
  std::map<Block, std::uint32_t> entry_of;
  for (int colour = 0; colour < ColouredLattice::colours; ++colour) {
    const std::array<int, 3> parity{colour & 1, (colour >> 1) & 1, colour >> 2};
    if (parity[0] > lattice.cells[0] || parity[1] > lattice.cells[1]) continue;
    for (int plane = 0; plane < lattice.planes(colour); ++plane)
      for (std::ptrdiff_t first = 0; first < lattice.plane; first += lanes) {
        Block block(std::size_t(lanes * lane_size), 0);
        for (int lane = 0; lane < lanes; ++lane) {
          const std::ptrdiff_t q = first + lane;
          const std::array<int, 3> site{int(2 * (q % lattice.row)) + parity[0],
                                        int(2 * (q / lattice.row)) + parity[1], 2 * plane + parity[2]};
          if (q < lattice.used() && site[0] <= lattice.cells[0] && site[1] <= lattice.cells[1])
            describe(colour, site, plane * lattice.plane + q, block.data() + std::size_t(lane * lane_size));
        }
        std::uint32_t entry = 0;
        if (std::any_of(block.begin(), block.end(), [](std::uint32_t n) { return n != 0; })) {
          const auto [known, is_new] = entry_of.try_emplace(block, std::uint32_t(blocks_.size()));
          entry = known->second;
          if (is_new) blocks_.push_back(std::move(block));
        }
        entries_[std::size_t(colour)].push_back(entry);
      }
  }
  if (blocks_.size() > 1) blocks_.front().assign(blocks_[1].size(), 0);
}

template class ColouredParticles<float>;
template class ColouredParticles<double>;

}  // namespace mss
