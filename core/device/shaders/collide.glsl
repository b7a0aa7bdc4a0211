// The collisions of a step, of every particle that is behind a plane at its end.

CONST_FIELD(0, PositionsBefore, x_before)
CONST_FIELD(1, VelocitiesBefore, v_before)
FIELD(3, Positions, x)
FIELD(4, Velocities, v)
layout(std430, binding = 12) buffer Flag { uint any_collided; };
uniform double step_size;
uniform double push_out_speed, behind_by_rounding;  // [m/s], [m]

struct Motion {
  dvec3 x, v;
};
struct Push {
  double normal, lever;
  bool rests;
};

Push impact(Plane plane, double start, double end, double a, double dt) {
  double w = (end - start) / dt - a * dt / 2.0lf;
  double arrival = start > 0.0lf ? sqrt(max(0.0lf, w * w - 2.0lf * a * start)) : max(0.0lf, -w);
  double hop = 2.0lf * plane.restitution * arrival;
  if (a < 0.0lf && hop < -a * dt) return Push(0.0lf, 0.0lf, true);
  double time = start > 0.0lf && arrival > w ? min(dt, 2.0lf * start / (arrival - w)) : 0.0lf;
  return Push((1.0lf + plane.restitution) * arrival, dt - time, false);
}

bool collide_impulse(Plane plane, Motion before, double dt, inout Motion after) {
  double end = gap(plane, after.x), speed = dot(plane.normal, after.v);
  if (end > 0.0lf || (end == 0.0lf && speed >= 0.0lf)) return false;
  if (after.v == dvec3(0) && after.x == before.x) return false;
  Push push =
      impact(plane, gap(plane, before.x), end, (speed - dot(plane.normal, before.v)) / dt, dt);
  if (push.rests) {
    push.normal = max(0.0lf, -speed);
    push.lever = push.normal > 0.0lf ? min(-end / push.normal, dt) : 0.0lf;
  }
  dvec3 sliding = after.v - speed * plane.normal;
  double slides = length(sliding);
  bool stuck = slides <= plane.friction * push.normal;
  dvec3 friction = stuck ? -sliding : -plane.friction * push.normal / slides * sliding;
  after.x += push.lever * (push.normal * plane.normal + friction);
  after.v += push.normal * plane.normal + friction;
  if (push.rests && stuck) {
    if (before.v == dvec3(0)) after.x = before.x;
    after.v = dvec3(0);
  }
  double left = gap(plane, after.x);
  if (push.rests || left < 0.0lf) after.x -= left * plane.normal;
  return true;
}

double push_out_gap(Plane plane, dvec3 before, double dt) {
  double behind = gap(plane, before);
  return behind < -behind_by_rounding ? min(0.0lf, behind + push_out_speed * dt) : 0.0lf;
}

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
