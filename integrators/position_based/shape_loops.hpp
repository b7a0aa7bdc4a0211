#pragma once

// The loops of lattice shape matching, see shape_matching.hpp. Included once per instruction set, see
// simd.hpp.

#include "core/kernels/cell_vectors.hpp"
#include "integrators/position_based/shape_kernel.hpp"

namespace mss::MSS_ISA {

void sum(const BoxSum& p) {
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<double>) {
    Pack<double> total = load(p.in + i);
    for (int d = 1; d <= p.width; ++d)
      total = total + (load(p.in + i - d * p.step) + load(p.in + i + d * p.step));
    store(p.out + i, total);
  }
}

MSS_INLINE Vec<double> load3(const double* const (&from)[3], std::ptrdiff_t i) {
  return {load(from[0] + i), load(from[1] + i), load(from[2] + i)};
}

void moments(const ShapeSites& argument) {
  const ShapeSites p = argument;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<double>) {
    const Vec<double> x0 = load3(p.rest, i), x = load(p.share + i) * load3(p.x, i);
    const Pack<double> rows[3] = {x.x, x.y, x.z};
    for (std::ptrdiff_t r = 0; r < 3; ++r) {
      store(p.affine[3 * r] + i, rows[r] * x0.x);
      store(p.affine[3 * r + 1] + i, rows[r] * x0.y);
      store(p.affine[3 * r + 2] + i, rows[r] * x0.z);
      store(p.affine[9 + r] + i, rows[r]);
    }
  }
}

/// Columns of the rotation of a quaternion (x, y, z, w).
struct Rotation {
  Vec<double> x, y, z;
  MSS_INLINE explicit Rotation(const Pack<double> (&q)[4]) {
    const Pack<double> one = Pack<double>{} + 1.0, two = one + one;
    x = {one - two * (q[1] * q[1] + q[2] * q[2]), two * (q[0] * q[1] + q[3] * q[2]),
         two * (q[0] * q[2] - q[3] * q[1])};
    y = {two * (q[0] * q[1] - q[3] * q[2]), one - two * (q[0] * q[0] + q[2] * q[2]),
         two * (q[1] * q[2] + q[3] * q[0])};
    z = {two * (q[0] * q[2] + q[3] * q[1]), two * (q[1] * q[2] - q[3] * q[0]),
         one - two * (q[0] * q[0] + q[1] * q[1])};
  }
};

/// Turns a rotation towards that nearest to a matrix of columns a, which maximises along = r_x.a_x + r_y.a_y
/// + r_z.a_z: Newton's method, torque over the second derivative, where that is definite, else the step of
/// Mueller, Bender, Chentanez and Macklin, A robust method to extract the rotational part of deformations,
/// MIG 2016, torque over |along|. The turn is that of the quaternion (w / 2, 1), normalised.
MSS_INLINE void turn_towards(const Vec<double> (&a)[3], Pack<double> (&q)[4]) {
  const Rotation r(q);
  const Vec<double> torque = cross(r.x, a[0]) + (cross(r.y, a[1]) + cross(r.z, a[2]));
  const Pack<double> bxx = a[0].x * r.x.x + (a[1].x * r.y.x + a[2].x * r.z.x),
                     byy = a[0].y * r.x.y + (a[1].y * r.y.y + a[2].y * r.z.y),
                     bzz = a[0].z * r.x.z + (a[1].z * r.y.z + a[2].z * r.z.z);
  const auto mixed = [&](const Pack<double> Vec<double>::*m, const Pack<double> Vec<double>::*n) {
    return -0.5 * (((a[0].*m * r.x.*n) + (a[0].*n * r.x.*m)) +
                   (((a[1].*m * r.y.*n) + (a[1].*n * r.y.*m)) + ((a[2].*m * r.z.*n) + (a[2].*n * r.z.*m))));
  };
  const Symmetric<double> second{byy + bzz,
                                 bzz + bxx,
                                 bxx + byy,
                                 mixed(&Vec<double>::y, &Vec<double>::z),
                                 mixed(&Vec<double>::z, &Vec<double>::x),
                                 mixed(&Vec<double>::x, &Vec<double>::y)};
  const Pack<double> zero{}, along = bxx + (byy + bzz), size = (along > zero ? along : -along) + 1e-30;
  const auto definite = (second.xx > zero) & (second.xx * second.yy > second.xy * second.xy) &
                        (second.determinant() > 1e-6 * (size * size * size));
  const Vec<double> newton = second.solve(torque), scaled = (1.0 / size) * torque;
  const Pack<double> one_half = zero + 0.5;
  const Vec<double> half =
      one_half * Vec<double>{definite ? newton.x : scaled.x, definite ? newton.y : scaled.y,
                             definite ? newton.z : scaled.z};
  const Pack<double> w = q[3] - (half.x * q[0] + half.y * q[1] + half.z * q[2]),
                     x = q[0] + half.x * q[3] + (half.y * q[2] - half.z * q[1]),
                     y = q[1] + half.y * q[3] + (half.z * q[0] - half.x * q[2]),
                     z = q[2] + half.z * q[3] + (half.x * q[1] - half.y * q[0]);
  const Pack<double> squared = (x * x + y * y) + (z * z + w * w);
  const Pack<double> scale = (1.0 / rsqrt_scale<double>)*scaled_rsqrt(squared, rsqrt_estimate(squared));
  q[0] = scale * x;
  q[1] = scale * y;
  q[2] = scale * z;
  q[3] = scale * w;
}

void match(const ShapeSites& argument) {
  const ShapeSites p = argument;
  const Pack<double> zero{};
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<double>) {
    const Pack<double> mass = load(p.region_mass + i), inverse = 1.0 / mass;
    const Vec<double> c0 = load3(p.rest_centre, i);
    const Vec<double> sum{load(p.affine[9] + i), load(p.affine[10] + i), load(p.affine[11] + i)};
    const Vec<double> centre = inverse * sum;
    Vec<double> a[3];
    const Pack<double> c0s[3] = {c0.x, c0.y, c0.z};
    for (int c = 0; c < 3; ++c)
      a[c] = Vec<double>{load(p.affine[c] + i), load(p.affine[3 + c] + i), load(p.affine[6 + c] + i)} -
             c0s[c] * sum;
    Pack<double> q[4];
    for (int n = 0; n < 4; ++n) q[n] = load(p.rotation[n] + i);
    for (int n = 0; n < p.turns; ++n) turn_towards(a, q);
    for (int n = 0; n < 4; ++n) store(p.rotation[n] + i, q[n]);
    const Rotation r(q);
    const Vec<double> shift = centre - (c0.x * r.x + (c0.y * r.y + c0.z * r.z));
    const auto present = load(p.inverse_regions + i) > zero;
    const Pack<double> out[affine_size] = {r.x.x, r.y.x, r.z.x, r.x.y,   r.y.y,   r.z.y,
                                           r.x.z, r.y.z, r.z.z, shift.x, shift.y, shift.z};
    for (int n = 0; n < affine_size; ++n) store(p.affine[n] + i, present ? out[n] : zero);
  }
}

void approach(const ShapeSites& argument) {
  const ShapeSites p = argument;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<double>) {
    const Vec<double> x0 = load3(p.rest, i);
    const Pack<double> mean = load(p.inverse_regions + i);
    for (std::ptrdiff_t r = 0; r < 3; ++r) {
      const Pack<double> goal =
          mean * ((load(p.affine[3 * r] + i) * x0.x + load(p.affine[3 * r + 1] + i) * x0.y) +
                  (load(p.affine[3 * r + 2] + i) * x0.z + load(p.affine[9 + r] + i)));
      store(p.moved[r] + i, load(p.moved[r] + i) + load(p.freedom[r] + i) * (goal - load(p.x[r] + i)));
    }
  }
}

ShapeKernel make_shape_kernel(const char* name) {
  return {name, lanes<double>, sum, moments, match, approach};
}

}  // namespace mss::MSS_ISA
