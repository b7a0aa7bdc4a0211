// Where a particle's quadratic model is least under contact, see integrators/position_based/block_in_cone.cpp,
// and how what holds it there is split by plane, see split_by_plane() in core/environment/contact.cpp:
// functions have the names that they have there. In double precision always; PLANE_COUNT planes.

/// Planes that a particle is on, in the order in which it came to them.
struct PlaneList {
  int count, at[PLANE_COUNT];
};

/// Of a positive definite matrix, as solve() in vbd.glsl.
dvec3 solve_definite(dmat3 h, dvec3 b) {
  double unit = 1.0lf / h[0][0], y = unit * h[1][1], z = unit * h[2][2], p = unit * h[2][1],
         q = unit * h[2][0], r = unit * h[1][0];
  double axx = y * z - p * p, axy = q * p - r * z, azx = r * p - q * y, ayy = z - q * q, ayz = r * q - p,
         azz = y - r * r;
  double scale = unit / (axx + (r * axy + q * azx));
  return scale * dvec3(axx * b.x + (axy * b.y + azx * b.z), axy * b.x + (ayy * b.y + ayz * b.z),
                       azx * b.x + (ayz * b.y + azz * b.z));
}

double trace(dmat3 a) { return a[0][0] + a[1][1] + a[2][2]; }
dvec3 unit_of(dvec3 a) {
  double size = length(a);
  return size > 0.0lf ? a / size : dvec3(0);
}
dmat3 diagonal(dvec3 a) { return dmat3(a.x, 0, 0, 0, a.y, 0, 0, 0, a.z); }

/// Of N p = given, N the planes' normals along free axes, the least squares' least solution: N^T (N N^T)^+ given,
/// inverted in the space that the normals span.
void split_by_normals(PlaneList on, dvec3 free, dvec3 given, out double pressures[PLANE_COUNT]) {
  dmat3 squares = dmat3(0), span = dmat3(0);
  int dimensions = 0;
  for (int k = 0; k < on.count; ++k) {
    dvec3 n = free * plane_number(on.at[k]).normal;
    squares += outerProduct(n, n);
    for (int d = 0; d < dimensions; ++d) n -= dot(span[d], n) * span[d];
    if (length(n) < 1e-6lf || dimensions == 3) continue;
    span[dimensions] = normalize(n);
    ++dimensions;
  }
  dmat3 inner = transpose(span) * squares * span;
  for (int d = dimensions; d < 3; ++d) inner[d][d] = 1.0lf;
  dvec3 y = span * solve_definite(inner, transpose(span) * (free * given));
  for (int p = 0; p < PLANE_COUNT; ++p) pressures[p] = 0.0lf;
  for (int k = 0; k < on.count; ++k)
    pressures[on.at[k]] = dot(free * plane_number(on.at[k]).normal, y);
}

/// The quadratic model, and where it is about.
struct VertexModel {
  dmat3 hessian;
  dvec3 force, free, before, u;
  double dt;
};
/// What Touching has.
struct Touching {
  dvec3 onto;
  dmat3 along;
};

double allowed_gap(int p, VertexModel model) {
  return push_out_gap(plane_number(p), model.before, model.dt);
}

Touching touching(PlaneList on, VertexModel model) {
  Touching t = Touching(dvec3(0), dmat3(0));
  dmat3 across = dmat3(0);
  for (int k = 0; k < on.count; ++k) {
    Plane plane = plane_number(on.at[k]);
    dvec3 n = model.free * plane.normal;
    n -= across * n;
    if (length(n) < 1e-6lf) continue;
    double missing = gap(plane, model.before + model.u + t.onto) - allowed_gap(on.at[k], model);
    t.onto -= missing / dot(n, n) * n;
    across += outerProduct(normalize(n), normalize(n));
  }
  t.along = diagonal(model.free) - across;
  return t;
}

dvec3 reaction(VertexModel model, dvec3 moved) { return model.hessian * moved - model.force; }

dvec3 slide(Touching t, VertexModel model, dvec3 friction) {
  dmat3 across = dmat3(1) - t.along;
  dmat3 block = t.along * model.hessian * t.along + trace(model.hessian) * across;
  return t.along * solve_definite(block, t.along * (model.force - model.hessian * t.onto + friction));
}

double friction_limit(PlaneList on, double pressures[PLANE_COUNT]) {
  double limit = 0.0lf;
  for (int k = 0; k < on.count; ++k)
    limit += plane_number(on.at[k]).friction * max(0.0lf, pressures[on.at[k]]);
  return limit;
}

/// Touching::move(): where it sticks, then where it slides, in turn with the friction there.
dvec3 move(PlaneList on, VertexModel model, out double pressures[PLANE_COUNT]) {
  Touching t = touching(on, model);
  dvec3 stuck = t.onto - t.along * (model.u + t.onto), moved = stuck, direction = dvec3(0);
  double pressures_stuck[PLANE_COUNT], limit = 0.0lf;
  for (int round = -1; round < 5; ++round) {
    if (round >= 0) moved = t.onto + slide(t, model, limit * direction);
    split_by_normals(on, model.free, reaction(model, moved), pressures);
    if (round < 0) {
      pressures_stuck = pressures;
      dvec3 held = t.along * reaction(model, stuck);
      limit = friction_limit(on, pressures);
      if (trace(t.along) < 0.5lf || (limit > 0.0lf && length(held) <= limit)) break;
      direction = unit_of(held);
      continue;
    }
    if (limit == 0.0lf && round > 0) break;
    dvec3 slid = t.along * (model.u + moved);
    if (limit > 0.0lf && dot(slid, direction) >= 0.0lf) {
      pressures = pressures_stuck;
      return stuck;
    }
    limit = friction_limit(on, pressures);
    direction = -unit_of(slid);
  }
  return moved;
}

bool contains(PlaneList on, int p) {
  for (int k = 0; k < on.count; ++k)
    if (on.at[k] == p) return true;
  return false;
}
PlaneList without(PlaneList on, int place) {
  for (int k = place; k + 1 < on.count; ++k) on.at[k] = on.at[k + 1];
  --on.count;
  return on;
}

dvec3 move_in_cone(VertexModel model, out double pressures[PLANE_COUNT]) {
  PlaneList on;
  on.count = 0;
  for (int p = 0; p < PLANE_COUNT; ++p) pressures[p] = 0.0lf;
  dvec3 moved = solve_definite(model.hessian, model.force);
  bool has_let_go = false;  // of a plane that pulled
  for (int left = 2 * PLANE_COUNT + 1; left > 0;) {
    int worst = -1;
    double deepest = 0.0lf;
    for (int p = 0; p < PLANE_COUNT && !has_let_go; ++p) {
      if (contains(on, p)) continue;
      double missing = gap(plane_number(p), model.before + model.u + moved) - allowed_gap(p, model);
      if (missing < deepest) deepest = missing, worst = p;
    }
    if (worst < 0 && !has_let_go) break;
    if (worst >= 0) {
      on.at[on.count] = worst;
      ++on.count;
    }
    moved = move(on, model, pressures);
    int pulls = -1;
    for (int k = on.count - 1; k >= 0 && !has_let_go; --k)
      if (pressures[on.at[k]] < 0.0lf) pulls = k;
    has_let_go = pulls >= 0 && on.count > 1;
    if (has_let_go) on = without(on, pulls);
    if (!has_let_go) --left;
  }
  for (int p = 0; p < PLANE_COUNT; ++p) pressures[p] = max(0.0lf, pressures[p]);
  return moved;
}

/// VertexContact::keep(): leaves what holds a particle in its multipliers. `force`: H d - f.
void keep(int i, dvec3 free, dvec3 force, double dt, double pressures[PLANE_COUNT]) {
  PlaneList on;
  on.count = 0;
  for (int p = 0; p < PLANE_COUNT; ++p)
    if (pressures[p] > 0.0lf) {
      on.at[on.count] = p;
      ++on.count;
    }
  double parts[PLANE_COUNT], sum = 0.0lf;
  split_by_normals(on, free, force, parts);
  dvec3 rest = free * force;
  for (int k = 0; k < on.count; ++k) {
    Plane plane = plane_number(on.at[k]);
    rest -= parts[on.at[k]] * free * plane.normal;
    sum += plane.friction * max(0.0lf, parts[on.at[k]]);
  }
  for (int p = 0; p < PLANE_COUNT; ++p) {
    dvec3 tangential = dvec3(0);
    if (pressures[p] > 0.0lf) {
      Plane plane = plane_number(p);
      double share = sum > 0.0lf ? plane.friction * max(0.0lf, parts[p]) / sum : 1.0lf / double(on.count);
      tangential = (parts[p] - pressures[p]) * free * plane.normal + share * rest;
    }
    set_multipliers(p, i, dt * dt * pressures[p], dt * dt * tangential);
  }
}
