// Before every shader: the words of formulas (core/base/formula.hpp) for one number, threads, and fields. The
// program puts `real`, float or double, before it, rvec3 of these, and what a shader is to contain.

#define MSS_FORMULA
#define MSS_FORMULA_WITH_STIFFNESS
#define MSS_VECTOR_FORMULA
#define MSS_UNUSED
#define MSS_NUMBER(value) real(value)
#define MSS_SCALAR real
#define MSS_SPRING_LAW(law, linear) const bool law_is_linear = linear;
#define Number real
#define Stiffness real
#define Vector rvec3

uniform int thread_count, threads_in_row;

/// Number of this thread; main() ends at once for those from thread_count on.
int thread() { return int(gl_GlobalInvocationID.x) + threads_in_row * int(gl_GlobalInvocationID.y); }

// Fields are three streams, one per axis, of a number per site of the lattice, with room before the first and
// behind the last site for neighbours that are none.
uniform int stride, pad;

#define FIELD(place, Block, field) layout(std430, binding = place) restrict buffer Block { real field[]; };
#define CONST_FIELD(place, Block, field) \
  layout(std430, binding = place) restrict readonly buffer Block { real field[]; };
#define AT(field, i) rvec3(field[pad + (i)], field[pad + stride + (i)], field[pad + 2 * stride + (i)])
#define SET(field, i, value) \
  { \
    rvec3 set_value = value; \
    field[pad + (i)] = set_value.x; \
    field[pad + stride + (i)] = set_value.y; \
    field[pad + 2 * stride + (i)] = set_value.z; \
  }

// The kind of every site, 0 where there is no particle, and the coefficients of every kind, one row each:
// stiffness and, of damped bodies, dampers of the springs to the 27 sites around; of the 8 cells around
// k_vol / (64 V0); inverse masses by axis, 0 along held ones; and the mass.
#ifdef DAMPED
#define VOLUMES 54
#else
#define VOLUMES 27
#endif
#define MASSES (VOLUMES + 8)
#define COEFFICIENTS (MASSES + 4)

layout(std430, binding = 14) restrict readonly buffer Kinds { uint kind_of[]; };
layout(std430, binding = 15) restrict readonly buffer Coefficients { real coefficients[]; };

/// Where the coefficients of a kind begin.
int coefficients_of(uint kind) { return int(kind) * COEFFICIENTS; }
rvec3 inverse_mass(int row) {
  return rvec3(coefficients[row + MASSES], coefficients[row + MASSES + 1], coefficients[row + MASSES + 2]);
}
/// 1 along free axes, 0 along held ones.
rvec3 free_axes(int row) { return sign(inverse_mass(row)); }
real mass(int row) { return coefficients[row + MASSES + 3]; }

#ifdef TETHERED
uniform int tether_site;  // -1: nothing is tied
uniform real tether_stiffness, tether_damping, anchor_x, anchor_y, anchor_z;

/// See Tether in core/environment/tethered_system.hpp.
rvec3 tether_force(rvec3 at, rvec3 velocity) {
  return tether_stiffness * (rvec3(anchor_x, anchor_y, anchor_z) - at) - tether_damping * velocity;
}
#endif
