#include "integrators/position_based/shape_matching_solver.hpp"

#include <algorithm>

namespace mss {

namespace {

/// Newton steps of a region's rotation from that of the step before, and from no rotation.
constexpr int few_turns = 3, many_turns = 30;

ConstStreams<double> const_streams(const std::array<AlignedArray<double>, 3>& field) {
  return {{field[0].data(), field[1].data(), field[2].data()}};
}

}  // namespace

ShapeMatching::ShapeMatching(const SpringSystem<double>& springs, System<double>& system, double dt,
                             int width, double alpha)
    : body_(springs.body()),
      system_(system),
      kernel_(fastest_copy<ShapeKernel>()),
      dt_(dt),
      width_(width),
      whole_body_(width == 0) {
  const std::array<int, 3>& cells = body_.lattice().cells;
  constexpr std::ptrdiff_t align = Lattice::plane_align;
  const auto whole_vectors = [](std::ptrdiff_t n) { return (n + align - 1) / align * align; };
  row_ = cells[0] + 1 + 2 * width_;
  plane_ = whole_vectors(row_ * (cells[1] + 1 + 2 * width_)) + align;  // what the last vector reaches
  size_ = plane_ * (cells[2] + 1 + 2 * width_) + whole_vectors(width_ + align);
  for (auto* field : {&rest_, &rest_centre_, &x_, &v_, &u_, &acceleration_, &freedom_})
    field->fill(Array(size_));
  for (Array* field : {&share_, &region_mass_, &inverse_regions_}) *field = Array(size_);
  rotation_.fill(Array(size_));
  affine_.fill(Array(size_));
  scratch_.fill(Array(size_));
  place(springs.held(), alpha);
  find_regions();
  reset();
  if (system.bounds())
    contact_ = std::make_unique<DisplacementContact<double>>(*system.bounds(), body_, size_, index_,
                                                             system.plane_impulses());
}

void ShapeMatching::place(const HeldSites& held, double alpha) {
  const Lattice& lattice = body_.lattice();
  Vec3 middle = Vec3::Zero();
  for (const std::ptrdiff_t site : body_.sites())
    middle += body_.mass(site) / body_.total_mass() * body_.rest_position(site);
  for (const std::ptrdiff_t site : body_.sites()) {
    const auto [i, j, k] = lattice.coordinates(site);
    const std::ptrdiff_t index = i + width_ + row_ * (j + width_) + plane_ * (k + width_);
    index_.push_back(index);
    const Vec3 rest = body_.rest_position(site) - middle;
    for (int axis = 0; axis < 3; ++axis) {
      rest_[std::size_t(axis)][index] = rest[axis];
      freedom_[std::size_t(axis)][index] = held.holds(site, axis) ? 0 : alpha;
    }
  }
}

/// How many regions every particle is in, and masses and centres of the regions.
void ShapeMatching::find_regions() {
  Array count(size_);
  for (const std::ptrdiff_t i : index_) count[i] = 1;
  if (whole_body_) {
    for (const std::ptrdiff_t i : index_) inverse_regions_[i] = 1;
  } else {
    sum_over_regions(count);
    for (const std::ptrdiff_t i : index_) inverse_regions_[i] = 1 / count[i];
  }
  for (std::size_t p = 0; p < index_.size(); ++p)
    share_[index_[p]] = body_.mass(body_.sites()[p]) * inverse_regions_[index_[p]];
  region_mass_ = share_;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::ptrdiff_t i : index_) rest_centre_[axis][i] = share_[i] * rest_[axis][i];
  sum_over_regions(region_mass_);
  for (Array& centre : rest_centre_) {
    sum_over_regions(centre);
    for (const std::ptrdiff_t i : index_) centre[i] /= region_mass_[i];
  }
  Array mass(size_);
  mass.fill(1);
  for (const std::ptrdiff_t i : index_) mass[i] = region_mass_[i];
  region_mass_ = mass;
}

void ShapeMatching::reset() {
  for (std::size_t n = 0; n < 4; ++n) rotation_[n].fill(n == 3 ? 1 : 0);
  turned_before_ = false;
}

void ShapeMatching::remember(Record& record) {
  record.keep(turned_before_);
  for (Array& rotation : rotation_) record.keep_values(std::span(rotation.data(), std::size_t(size_)));
  if (contact_) record.keep(*contact_);
}

/// Calls part(first, last) for the rows of every plane that has particles.
template <class Part>
void ShapeMatching::for_each_plane(Part&& part) {
  const std::array<int, 3>& cells = body_.lattice().cells;
  system_.parallel(cells[2] + 1, [&](std::ptrdiff_t k) {
    const std::ptrdiff_t first = plane_ * (k + width_) + row_ * width_;
    const std::ptrdiff_t used = row_ * (cells[1] + 1);
    part(first, first + (used + kernel_.lanes - 1) / kernel_.lanes * kernel_.lanes);
  });
}

/// Sums along x, y and z, one after the other. Sites beyond the body are 0 before each.
void ShapeMatching::sum_over_regions(Affine& fields, Affine& scratch) {
  const auto along = [&](std::ptrdiff_t step, Affine& from, Affine& to) {
    for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) {
      for (std::size_t n = 0; n < affine_size; ++n)
        kernel_.sum({first, last, step, width_, from[n].data(), to[n].data()});
    });
  };
  along(1, fields, scratch);
  along(row_, scratch, fields);
  along(plane_, fields, scratch);
  std::swap(fields, scratch);
}

/// The same of one field, when regions are made.
void ShapeMatching::sum_over_regions(Array& field) {
  if (whole_body_) {
    double total = 0;
    for (const std::ptrdiff_t i : index_) total += field[i];
    for (const std::ptrdiff_t i : index_) field[i] = total;
    return;
  }
  Array scratch(size_);
  for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, row_, plane_}) {
    for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) {
      kernel_.sum({first, last, step, width_, field.data(), scratch.data()});
    });
    std::swap(field, scratch);
  }
}

ShapeSites ShapeMatching::sites(std::ptrdiff_t first, std::ptrdiff_t last) {
  ShapeSites s{};
  s.first = first;
  s.last = last;
  s.turns = turned_before_ ? few_turns : many_turns;
  s.share = share_.data();
  s.region_mass = region_mass_.data();
  s.inverse_regions = inverse_regions_.data();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    s.rest[axis] = rest_[axis].data();
    s.rest_centre[axis] = rest_centre_[axis].data();
    s.x[axis] = x_[axis].data();
    s.freedom[axis] = freedom_[axis].data();
    s.moved[axis] = u_[axis].data();
  }
  for (std::size_t n = 0; n < affine_size; ++n) s.affine[n] = affine_[n].data();
  for (std::size_t n = 0; n < 4; ++n) s.rotation[n] = rotation_[n].data();
  return s;
}

void ShapeMatching::iterate() {
  const auto run = [&](void (*pass)(const ShapeSites&)) {
    for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) { pass(sites(first, last)); });
  };
  run(kernel_.moments);
  if (whole_body_) {
    match_whole_body();
  } else {
    sum_over_regions(affine_, scratch_);
    run(kernel_.match);
    sum_over_regions(affine_, scratch_);
  }
  run(kernel_.approach);
  turned_before_ = true;
}

/// There is one region, that of the first particle: what it says is said to all.
void ShapeMatching::match_whole_body() {
  for (Array& field : affine_) sum_over_regions(field);
  const std::ptrdiff_t first = index_.front();
  kernel_.match(sites(first, first + kernel_.lanes));
  for (Array& field : affine_)
    for (const std::ptrdiff_t i : index_) field[i] = field[first];
}

void ShapeMatching::load_state(const State<double>& state) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t p = 0; p < index_.size(); ++p) {
      x_[axis][index_[p]] = state.x.axis(int(axis))[body_.sites()[p]];
      v_[axis][index_[p]] = state.v.axis(int(axis))[body_.sites()[p]];
    }
}

void ShapeMatching::load_acceleration(const Field<double>& acceleration) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t p = 0; p < index_.size(); ++p)
      acceleration_[axis][index_[p]] =
          freedom_[axis][index_[p]] > 0 ? acceleration.axis(int(axis))[body_.sites()[p]] : 0;
}

void ShapeMatching::store_state(State<double>& state) const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t p = 0; p < index_.size(); ++p) {
      state.x.axis(int(axis))[body_.sites()[p]] = x_[axis][index_[p]];
      state.v.axis(int(axis))[body_.sites()[p]] = v_[axis][index_[p]];
    }
}

void ShapeMatching::begin_step(double t) {
  const double dt2 = dt_ * dt_;
  for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::ptrdiff_t i = first; i < last; ++i)
        u_[axis][i] = dt_ * v_[axis][i] + dt2 * acceleration_[axis][i];
  });
  if (contact_) contact_->begin_step(t + dt_, dt_, const_streams(x_), const_streams(v_), const_streams(u_));
}

void ShapeMatching::end_passes() {
  if (!contact_) return;
  const Streams<double> u{{u_[0].data(), u_[1].data(), u_[2].data()}};
  contact_->project(const_streams(x_), u);
  contact_->end_passes(dt_, const_streams(x_), u);
}

void ShapeMatching::rebound(State<double>& state) const {
  if (contact_) contact_->rebound({.dt = dt_, .drift = 1}, state);
}

void ShapeMatching::iterate_into_next_step() {
  iterate();
  const double dt2 = dt_ * dt_, rate = 1 / dt_;
  for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::ptrdiff_t i = first; i < last; ++i) {
        x_[axis][i] += u_[axis][i];
        u_[axis][i] = dt_ * (rate * u_[axis][i]) + dt2 * acceleration_[axis][i];
      }
  });
}

void ShapeMatching::set_displacement(std::ptrdiff_t site, int axis, double u) {
  u_[std::size_t(axis)][index_[std::size_t(body_.particle(site))]] = u;
}

void ShapeMatching::finish(double dt) {
  const double rate = 1 / dt;
  for_each_plane([&](std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::ptrdiff_t i = first; i < last; ++i) {
        x_[axis][i] += u_[axis][i];
        v_[axis][i] = rate * u_[axis][i];
      }
  });
}

}  // namespace mss
