// MuJoCo (@mujoco/mujoco 3.14.0, Apache-2.0): a flex, of the hexahedra (`--dof trilinear`, boxes only) or of the
// tetrahedra (`--dof full`), by its integrator "discrete" in double precision.
//
//     node reference/peers/mujoco.mjs EXPORT_DIR RESULT_DIR --step 0.002 --recalibrate yes
//
// MuJoCo 3.14 counts the shear modulus of a trilinear flex half. `--recalibrate yes` gives it the E and nu whose shear
// modulus is twice as large and whose first Lame constant is the same; `no` what the scene says.
import {InputError, load, main} from './exchange.mjs';

let mj;
const version = async () => {
  if (!mj) mj = await (await load('@mujoco/mujoco'))();
  return `MuJoCo ${mj.mj_versionString()}`;
};

/// E and nu of the same first Lame constant and twice the shear modulus.
export function recalibrated({young, poisson}) {
  const shear = young / (1 + poisson), lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  return {young: shear * (3 * lame + 2 * shear) / (lame + shear), poisson: lame / (2 * (lame + shear))};
}

/// Particles in the order of nodes: of a flex of cells z is fastest, where a box's particles have x fastest.
function nodeOrder({scene: {cells}, count}) {
  if (!cells) return Array.from({length: count}, (_, a) => a);
  const [nx, ny, nz] = cells.map(n => n + 1), order = [];
  for (let i = 0; i < nx; ++i)
    for (let j = 0; j < ny; ++j)
      for (let k = 0; k < nz; ++k) order.push(i + nx * (j + ny * k));
  return order;
}

const planeText = ({point, normal, friction}, solref) =>
  `<geom type="plane" size="20 20 1" pos="${point.join(' ')}" zaxis="${normal.join(' ')}" ` +
  `friction="${friction} 0.005 0.0001" condim="3"${solref ? ` solref="${solref}"` : ''}/>`;

function modelText(exported, options, order, place) {
  const {scene} = exported, trilinear = options.dof === 'trilinear';
  const {young, poisson} = options.recalibrate === 'yes' ? recalibrated(scene) : scene;
  const numbers = list => list.join(' ');
  const held = order.map((_, q) => q).filter(q => exported.held[order[q]]);
  const friction = scene.planes[0]?.friction ?? 1;  // the larger one of a pair acts
  return `<mujoco>
  <option timestep="${options.step}" integrator="discrete" solver="CG" tolerance="1e-8" iterations="${options.iterations ?? 100}" gravity="${numbers(scene.gravity)}">
    <flag autoreset="disable" contact="${scene.planes.length ? 'enable' : 'disable'}"/>
  </option>
  <size memory="200M"/>
  <worldbody>
    ${scene.planes.map(plane => planeText(plane, options.solref)).join('\n    ')}
    <flexcomp name="body" type="direct" dim="3" dof="${options.dof}"${trilinear ? ` cellcount="${numbers(scene.cells)}"` : ''} mass="${exported.mass.reduce((a, b) => a + b)}" radius="0.001" point="${numbers(order.map(a => numbers([...exported.rest.subarray(3 * a, 3 * a + 3)])))}" element="${numbers(exported.tetrahedra.map(t => numbers(t.map(a => place[a]))))}">
      <elasticity young="${young}" poisson="${poisson}" damping="0"/>
      <contact selfcollide="none" internal="false" friction="${friction} 0.005 0.0001"${options.solref ? ` solref="${options.solref}"` : ''}/>
      ${held.length ? `<pin id="${numbers(held)}"/>` : ''}
    </flexcomp>
  </worldbody>
</mujoco>
`;
}

/// MuJoCo gives all nodes the same mass; the scene's particles have those of their cells' shares.
function setMasses(model, data, exported, body, drag) {
  for (let a = 0; a < exported.count; ++a) {
    if (body[a] === 0) continue;
    model.body_mass[body[a]] = exported.mass[a];
    for (let i = 0; i < 3; ++i) model.dof_damping[model.body_dofadr[body[a]] + i] = drag * exported.mass[a];
  }
  mj.mj_setConst(model, data);
}

function setStart(model, data, exported, body) {
  mj.mj_resetData(model, data);
  for (let a = 0; a < exported.count; ++a) {
    if (body[a] === 0) continue;
    const place = model.body_dofadr[body[a]];
    for (let i = 0; i < 3; ++i) {
      data.qpos[place + i] = exported.start[3 * a + i] - exported.rest[3 * a + i];
      data.qvel[place + i] = exported.velocity[3 * a + i];
    }
  }
  mj.mj_forward(model, data);
}

function make(exported, options) {
  const {count} = exported;
  if (exported.scene.young === null || exported.scene.poisson === null)
    throw new InputError('this scene has no single E and nu, which MuJoCo needs');
  if (options.dof === 'trilinear' && !exported.scene.cells)
    throw new InputError('--dof trilinear is for boxes of cells; this body is none, so --dof full');
  const order = nodeOrder(exported), place = new Int32Array(count);
  order.forEach((a, q) => { place[a] = q; });
  const text = modelText(exported, options, order, place);
  const model = mj.MjModel.from_xml_string(text), data = new mj.MjData(model);
  const bodies = options.dof === 'full' ? model.flex_vertbodyid : model.flex_nodebodyid;
  const body = Int32Array.from({length: count}, (_, a) => bodies[place[a]]);  // 0: held, part of the world
  setMasses(model, data, exported, body, options.drag);
  setStart(model, data, exported, body);
  const read = (of, held) => Float64Array.from({length: 3 * count}, (_, i) => {
    const a = Math.floor(i / 3);
    return body[a] > 0 ? of(body[a], i % 3) : held[i];
  });
  const still = new Float64Array(3 * count);
  return {
    name: 'MuJoCo', version: mj.mj_versionString(), precision: 'double',
    settings: {dof: options.dof, recalibrate: options.recalibrate, solref: options.solref ?? 'default'},
    scene: ['mujoco.xml', text],
    step: () => mj.mj_step(model, data),
    positions: () => { const x = data.xpos; return read((b, i) => x[3 * b + i], exported.rest); },
    release: () => { data.delete(); model.delete(); },
    velocities: () => { const v = data.qvel, at = model.body_dofadr; return read((b, i) => v[at[b] + i], still); },
  };
}

await main({
  own: {
    dof: {meaning: 'trilinear (hexahedra) or full (tetrahedra); trilinear', number: ['trilinear', 'full'], value: 'trilinear'},
    recalibrate: {meaning: 'yes or no: E and nu of twice the shear modulus; no', number: ['yes', 'no'], value: 'no'},
    solref: {meaning: 'of contacts, as in "0.004 1"; MuJoCo\'s default'},
  },
  version,
  make,
});
