// Jolt Physics (jolt-physics, MIT): a soft body by XPBD in single precision. Every spring of the lattice is an
// edge constraint of compliance 1/k, every tetrahedron a volume constraint. Its `iterations` are substeps.
//
//     node reference/peers/jolt.mjs EXPORT_DIR RESULT_DIR --step 0.0166667 --iterations 20
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {dirname, join} from 'node:path';

import {InputError, load, main, surface} from './exchange.mjs';

/// Of the package, as Jolt says none.
function packageVersion() {
  const dist = dirname(createRequire(import.meta.url).resolve('jolt-physics/wasm'));
  return JSON.parse(readFileSync(join(dist, '..', 'package.json'), 'utf8')).version;
}

let J;
const version = async () => {
  if (!J) J = await (await load('jolt-physics/wasm'))();
  return `jolt-physics ${packageVersion()}`;
};

const vector = ([x, y, z]) => new J.Vec3(x, y, z);

let world;  // one for all runs: its memory does not come back

/// A world of two layers, of which the first is what moves, and the planes.
function makeWorld({gravity, planes}) {
  const settings = new J.JoltSettings();
  settings.mMaxBodies = 16;
  const pairs = new J.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(0, 1);
  const layers = new J.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [0, 1]) layers.MapObjectToBroadPhaseLayer(layer, new J.BroadPhaseLayer(layer));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  world = new J.JoltInterface(settings);
  world.GetPhysicsSystem().SetGravity(vector(gravity));
  for (const plane of planes) addPlane(world.GetPhysicsSystem().GetBodyInterface(), plane);
}

/// A box of 40 m whose upper face is the plane.
function addPlane(bodies, {point, normal, friction, restitution}) {
  const length = Math.hypot(...normal), unit = normal.map(u => u / length);
  const centre = point.map((p, i) => p - 0.5 * unit[i]);
  const turn = J.Quat.prototype.sFromTo(vector([0, 0, 1]), vector(unit));
  const settings = new J.BodyCreationSettings(new J.BoxShape(new J.Vec3(20, 20, 0.5)), new J.RVec3(...centre), turn,
    J.EMotionType_Static, 1);
  settings.mFriction = friction;
  settings.mRestitution = restitution;
  bodies.CreateAndAddBody(settings, J.EActivation_DontActivate);
}

/// 1/2 k V0 (V / V0 - 1)^2 of a tetrahedron is 1/2 (6 V - 6 V0)^2 / compliance with compliance = 36 V0 / k.
function addVolumes(shared, exported) {
  const perCell = exported.tetrahedra.length / exported.hexahedra.length;
  exported.tetrahedra.forEach((tetrahedron, i) => {
    const stiffness = exported.volumeStiffness[Math.floor(i / perCell)];
    if (stiffness < 0)
      throw new InputError(`the lattice has a volume force of negative stiffness (Poisson's ratio below 1/4), which no constraint has`);
    if (stiffness === 0 || tetrahedron.every(a => exported.held[a])) return;
    const compliance = 36 * restVolume(exported.rest, tetrahedron) / stiffness;
    shared.mVolumeConstraints.push_back(new J.SoftBodySharedSettingsVolume(...tetrahedron, compliance));
  });
}

function restVolume(x, [a, b, c, d]) {
  const [u, v, w] = [b, c, d].map(p => [0, 1, 2].map(i => x[3 * p + i] - x[3 * a + i]));
  return (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6;
}

/// Particles at rest, edges, volumes, and the surface for contact.
function makeShared(exported) {
  const shared = new J.SoftBodySharedSettings();
  const vertex = new J.SoftBodySharedSettingsVertex();
  for (let a = 0; a < exported.count; ++a) {
    vertex.mPosition = new J.Float3(...exported.rest.subarray(3 * a, 3 * a + 3));
    vertex.mVelocity = new J.Float3(...exported.velocity.subarray(3 * a, 3 * a + 3));
    vertex.mInvMass = exported.held[a] ? 0 : 1 / exported.mass[a];
    shared.mVertices.push_back(vertex);
  }
  for (const [a, b, stiffness] of exported.springs)
    if (stiffness > 0 && !(exported.held[a] && exported.held[b]))
      shared.mEdgeConstraints.push_back(new J.SoftBodySharedSettingsEdge(a, b, 1 / stiffness));
  addVolumes(shared, exported);
  for (const [a, b, c] of surface(exported.tetrahedra))
    shared.AddFace(new J.SoftBodySharedSettingsFace(a, b, c, 0));
  shared.CalculateEdgeLengths();
  shared.CalculateVolumeConstraintVolumes();
  shared.Optimize();
  return shared;
}

/// The numbers of all vertices of a soft body where Jolt keeps them; positions are relative to its centre of mass.
function vertexMemory(body) {
  const motion = J.castObject(body.GetMotionProperties(), J.SoftBodyMotionProperties);
  const vertices = motion.GetVertices(), traits = J.SoftBodyVertexTraits.prototype;
  const first = J.getPointer(vertices.at(0)), stride = J.getPointer(vertices.at(1)) - first;
  const centre = body.GetCenterOfMassPosition(), shift = [centre.GetX(), centre.GetY(), centre.GetZ()];
  const index = (a, member) => (first + a * stride + member) >> 2;
  return {
    shift,
    position: a => index(a, traits.mPositionOffset),
    velocity: a => index(a, traits.mVelocityOffset),
  };
}

function make(exported, options) {
  const {scene, count} = exported;
  const iterations = options.iterations ?? 5;
  if (!world) makeWorld(scene);
  const bodies = world.GetPhysicsSystem().GetBodyInterface();
  const creation = new J.SoftBodyCreationSettings(makeShared(exported), new J.RVec3(0, 0, 0), new J.Quat(0, 0, 0, 1), 0);
  Object.assign(creation, {mNumIterations: iterations, mLinearDamping: options.drag, mUpdatePosition: false,
    mAllowSleeping: false, mMaxLinearVelocity: 1e4, mRestitution: scene.planes[0]?.restitution ?? 0,
    mFriction: scene.planes[0]?.friction ?? 0.4});
  const id = bodies.CreateAndAddSoftBody(creation, J.EActivation_Activate);
  const memory = vertexMemory(world.GetPhysicsSystem().GetBodyLockInterface().TryGetBody(id));
  // Rest lengths are those of the vertices as given, so where the body starts is written afterwards.
  for (let a = 0; a < count; ++a)
    for (let i = 0; i < 3; ++i) J.HEAPF32[memory.position(a) + i] = exported.start[3 * a + i] - memory.shift[i];
  const read = (place, shift) =>
    Float64Array.from({length: 3 * count}, (_, i) => J.HEAPF32[place(Math.floor(i / 3)) + i % 3] + shift[i % 3]);
  const settings = {iterations, linear_damping: options.drag, edges: exported.springs.length,
    volumes: exported.tetrahedra.length, friction: creation.mFriction, restitution: creation.mRestitution};
  return {
    name: 'Jolt', version: packageVersion(), precision: 'single', settings,
    scene: ['jolt.json', JSON.stringify({...settings, step: options.step, gravity: scene.gravity, planes: scene.planes,
      vertices: 'particles.csv: x, y, z; inverse mass 1 / mass, 0 if held',
      edge_constraints: 'springs.csv: compliance 1 / stiffness',
      volume_constraints: 'tetrahedra.csv: compliance 36 rest volume / volume_stiffness of its cell',
      faces: 'the surface of the tetrahedra'}, null, 2) + '\n'],
    step: () => world.Step(options.step, 1),
    positions: () => read(memory.position, memory.shift),
    velocities: () => read(memory.velocity, [0, 0, 0]),
    release: () => {
      bodies.RemoveBody(id);
      bodies.DestroyBody(id);
    },
  };
}

await main({own: {}, version, make});
