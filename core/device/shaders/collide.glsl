// The collisions of a step, of every particle that is behind a plane at its end.

CONST_FIELD(0, PositionsBefore, x_before)
CONST_FIELD(1, VelocitiesBefore, v_before)
FIELD(3, Positions, x)
FIELD(4, Velocities, v)
layout(std430, binding = 12) buffer Flag { uint any_collided; };
uniform double step_size;

bool push_out(Plane plane, double goal, inout Motion after) {
  double missing = goal - gap(plane, after.x), speed = dot(plane.normal, after.v);
  if (missing <= 0.0lf && speed >= 0.0lf) return false;
  after.x += max(0.0lf, missing) * plane.normal;
  after.v -= min(0.0lf, speed) * plane.normal;
  return true;
}

bool act(Plane plane, Motion before, double dt, inout Motion after) {
  double goal = push_out_gap(plane, before.x, dt);
  return goal < 0.0lf ? push_out(plane, goal, after) : collide_impulse(plane, before, dt, after);
}

bool is_free(Plane plane, Motion motion, double dt) {
  double close = 1e-9lf * cell_size;
  return gap(plane, motion.x) > -close && dot(plane.normal, motion.v) * dt > -close;
}

/// PlaneContact::collide().
bool collide(int i, dvec3 free, double particle_mass, Motion before, double dt, inout Motion after) {
  bool any = false;
  for (int round = 0; round < 8; ++round) {
    bool changed = false;
    for (int p = 0; p < plane_count; ++p) {
      Plane plane = plane_number(p);
      dvec3 v_old = after.v;
      if (round > 0 && is_free(plane, after, dt)) continue;
      if (!act(plane, before, dt, after)) continue;
      give(p, i, particle_mass * free * (after.v - v_old));
      changed = true;
    }
    any = any || changed;
    if (!changed || plane_count == 1) break;
  }
  return any;
}

/// PlaneContact::collide_held().
void collide_held(int i, dvec3 free, double particle_mass, dvec3 goal, inout Motion after) {
  for (int p = 0; p < plane_count; ++p) {
    Plane plane = plane_number(p);
    dvec3 n = free * plane.normal;
    double missing = min(0.0lf, gap(plane, goal)) - gap(plane, after.x);
    if (length(n) < 1e-6lf || !(missing > 1e-12lf * cell_size)) continue;
    after.x += missing / dot(n, n) * n;
    double into = dot(plane.normal, after.v);
    if (!(into < 0.0lf)) continue;
    dvec3 dv = -into / dot(n, n) * n;
    after.v += dv;
    give(p, i, particle_mass * free * dv);
  }
}

void main() {
  int i = thread();
  if (i >= thread_count || kind_of[i] == 0u) return;
  dvec3 x_end = dvec3(AT(x, i));
  bool touches = false;
  for (int p = 0; p < plane_count; ++p) touches = touches || gap(plane_number(p), x_end) <= 0.0lf;
  if (!touches) return;
  int row = coefficients_of(kind_of[i]);
  dvec3 free = dvec3(free_axes(row));
  double particle_mass = double(mass(row));
  Motion before = Motion(dvec3(AT(x_before, i)), dvec3(AT(v_before, i)));
  Motion after = Motion(x_end, dvec3(AT(v, i))), held = after;
  if (!collide(i, free, particle_mass, before, step_size, after)) return;
  if (free != dvec3(1)) {
    dvec3 goal = after.x;
    after.x = mix(held.x, after.x, free);
    after.v = mix(held.v, after.v, free);
    collide_held(i, free, particle_mass, goal, after);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (free[axis] == 0.0lf) continue;
    x[pad + axis * stride + i] = real(after.x[axis]);
    v[pad + axis * stride + i] = real(after.v[axis]);
  }
  any_collided = 1u;
}
