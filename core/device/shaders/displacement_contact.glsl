// Contact inside passes, see integrators/position_based/displacement_contact.hpp: functions have the names
// that they have there. In double precision always.

FIELD(0, Positions, x)      // x_n until END
FIELD(1, Velocities, v)
FIELD(3, Displacements, u)
layout(std430, binding = 4) restrict buffer Meetings {
  uint any_pushed;  ///< whether a plane has pushed a particle in this step
  uint comes_to;    ///< the plane that a particle comes to
};
uniform double step_size;
uniform int first_site;
uniform real gravity_x, gravity_y, gravity_z;

#ifdef BEGIN
void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  dvec3 before = dvec3(AT(x, i)), after = before + dvec3(AT(u, i));
  bool is_near = false;
  for (int p = 0; p < plane_count; ++p) {
    Plane plane = plane_number(p);
    is_near = is_near || min(gap(plane, before), gap(plane, after)) < cell_size;
  }
  is_near = is_near && inverse_mass(coefficients_of(kind_of[i])) != rvec3(0);
  bool was_pushed = is_pushed(i);
  near[i] = is_near ? (was_pushed ? 2u : 1u) : 0u;
  for (int p = 0; is_near && p < plane_count; ++p) set_multipliers(p, i, 0.0lf, dvec3(0));
}
#endif

#ifdef PROJECT
void project(int p, int i, dvec3 w, dvec3 x_before, inout dvec3 moved) {
  Plane plane = plane_number(p);
  double along = dot(plane.normal, w * plane.normal), normal = normal_of(p, i);
  double missing = gap(plane, x_before + moved) - push_out_gap(plane, x_before, step_size);
  if (along == 0.0lf || (missing >= 0.0lf && normal == 0.0lf)) return;
  double pressed = max(0.0lf, normal - missing / along);
  moved += (pressed - normal) * w * plane.normal;
  dvec3 tangential = tangential_of(p, i), sliding = moved - dot(plane.normal, moved) * plane.normal;
  dvec3 held = tangential - sliding / max(w.x, max(w.y, w.z));
  double limit = plane.friction * pressed, size = length(held);
  if (size > limit) held *= size > 0.0lf ? limit / size : 0.0lf;
  moved += w * (held - tangential);
  set_multipliers(p, i, pressed, held);
}

void main() {
  int i = thread() + first_site;
  if (i >= thread_count + first_site || kind_of[i] == 0u || near[i] == 0u) return;
  int row = coefficients_of(kind_of[i]);
  dvec3 w = dvec3(free_axes(row)) / double(mass(row)), x_before = dvec3(AT(x, i)), start = dvec3(AT(u, i));
  dvec3 moved = start;
  for (int p = 0; p < plane_count; ++p) project(p, i, w, x_before, moved);
  if (moved != start) SET(u, i, rvec3(moved))
}
#endif

#if defined(PUT_IN_FRONT) || defined(END)
/// move_in_front(), where `scale` times a move is what the plane gives.
dvec3 moved_in_front(int i, dvec3 free, dvec3 before, dvec3 moved, double scale) {
  for (int round = 0; round < 8; ++round) {
    bool changed = false;
    for (int p = 0; p < plane_count; ++p) {
      Plane plane = plane_number(p);
      dvec3 n = free * plane.normal;
      double missing = gap(plane, before + moved) - push_out_gap(plane, before, step_size);
      if (!(missing < 0.0lf) || n == dvec3(0)) continue;
      dvec3 by = -missing / dot(n, n) * n;
      moved += by;
      if (scale > 0.0lf) give(p, i, scale * by);
      changed = true;
    }
    if (!changed) break;
  }
  return moved;
}
#endif

#ifdef PUT_IN_FRONT
/// DisplacementContact::impact(): atomicMin() finds the first such plane.
void note_impacts(int i) {
  Motion before = Motion(dvec3(AT(x, i)), dvec3(AT(v, i)));
  double slow = 2.0lf * length(dvec3(gravity_x, gravity_y, gravity_z)) * step_size;
  for (int p = 0; p < plane_count; ++p) {
    Plane plane = plane_number(p);
    bool comes = -dot(plane.normal, before.v) > slow;
    if (comes && gap(plane, before.x + step_size * before.v) < 0.0lf) atomicMin(comes_to, uint(p));
  }
}

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  dvec3 start = dvec3(AT(u, i)), free = dvec3(free_axes(coefficients_of(kind_of[i])));
  dvec3 moved = moved_in_front(i, free, dvec3(AT(x, i)), start, 0.0lf);
  if (moved != start) SET(u, i, rvec3(moved))
  if (near[i] == 1u) note_impacts(i);
}
#endif

#ifdef END
uniform real rate;  // 1 / dt
uniform int may_leave;

/// rebound() of core/environment/contact.cpp, for steps that are exact to first order.
void rebound(Plane plane, dvec3 gravity, Motion before, inout Motion after) {
  double dt = step_size, speed = dot(plane.normal, after.v);
  Motion free = Motion(before.x + dt * before.v + dt * dt * gravity, before.v + dt * gravity);
  bool leaves = may_leave != 0 && -dot(plane.normal, before.v) > 2.0lf * length(gravity) * dt;
  if (leaves) leaves = collide_impulse(plane, before, dt, free);
  leaves = leaves && dot(plane.normal, free.v) > 0.0lf;
  double speed_after = leaves ? dot(plane.normal, free.v) : 0.0lf;
  dvec3 sliding = after.v - speed * plane.normal;
  double slides = length(sliding), slows = min(plane.friction * speed_after, slides);
  after.v += (speed_after - speed) * plane.normal;
  if (slides > 0.0lf) after.v -= slows / slides * sliding;
  if (leaves) after.x += (gap(plane, free.x) - gap(plane, after.x)) * plane.normal;
}

/// PlaneBounds::rebound().
void rebound_all(int i, dvec3 free, double particle_mass, Motion before, inout Motion after) {
  Motion start = after;
  for (int p = 0; p < plane_count; ++p) {
    if (!(normal_of(p, i) > 0.0lf)) continue;
    dvec3 v_old = after.v;
    rebound(plane_number(p), dvec3(gravity_x, gravity_y, gravity_z), before, after);
    give(p, i, particle_mass * free * (after.v - v_old));
  }
  after.x = start.x + free * (after.x - start.x);
  after.v = start.v + free * (after.v - start.v);
  bool behind = false;
  for (int p = 0; p < plane_count; ++p) {
    Plane plane = plane_number(p);
    behind = behind || gap(plane, after.x) < min(0.0lf, gap(plane, start.x));
  }
  if (behind) after.x = start.x;
}

/// end_passes(), finish() and rebound().
void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  int row = coefficients_of(kind_of[i]);
  dvec3 free = dvec3(free_axes(row)), start = dvec3(AT(u, i));
  double particle_mass = double(mass(row));
  for (int p = 0; near[i] != 0u && p < plane_count; ++p) {
    dvec3 given = normal_of(p, i) * plane_number(p).normal + tangential_of(p, i);
    if (given != dvec3(0)) give(p, i, free * given / step_size);
  }
  Motion before = Motion(dvec3(AT(x, i)), dvec3(AT(v, i)));
  rvec3 moved = rvec3(moved_in_front(i, free, before.x, start, particle_mass / step_size));
  rvec3 x_end = AT(x, i) + moved, v_end = rate * moved;
  if (near[i] != 0u) {
    Motion after = Motion(dvec3(x_end), dvec3(v_end));
    rebound_all(i, free, particle_mass, before, after);
    x_end = rvec3(after.x);
    v_end = rvec3(after.v);
  }
  SET(x, i, x_end)
  SET(v, i, v_end)
  if (is_pushed(i)) any_pushed = 1u;
}
#endif
