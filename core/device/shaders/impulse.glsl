// The law `impulse` for one particle and one plane: functions have the names of core/environment/contact.hpp.

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
