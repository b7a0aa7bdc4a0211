// What the adapters in JavaScript share: reads what `mss peer export` wrote, takes an engine through the sample
// times, and writes what `mss peer score` reads. experiments/peer/README.md describes these files.
//
// An adapter calls main() with its options and a function `make` from an export and the values of these options to
// an engine: {version, precision, settings, scene: [file name, text], step(), positions(), velocities()}; the last
// two return a Float64Array of 3 n numbers in the order of particles.csv; release() gives its memory back.
import {mkdirSync, readFileSync, renameSync, writeFileSync} from 'node:fs';
import {basename, join} from 'node:path';
import {parseArgs} from 'node:util';

/// What a user can mend: ends the program with status 2.
export class InputError extends Error {}
/// The engine is not installed: status 3.
export class MissingEngine extends Error {}

/// The package of an engine, as `npm ci` in this folder installs it.
export async function load(name) {
  try {
    return (await import(name)).default;
  } catch (error) {
    if (error.code === 'ERR_MODULE_NOT_FOUND')
      throw new MissingEngine(`${name} is not installed; "npm ci" in reference/peers installs it`);
    throw error;
  }
}

function read(file) {
  try {
    return readFileSync(file, 'utf8');
  } catch {
    throw new InputError(`${file}: cannot be read; "mss peer export SCENE --out DIR" writes it`);
  }
}

/// Columns of a CSV file of numbers, by name.
function readTable(file, names) {
  const [header, ...lines] = read(file).trimEnd().split(/\r?\n/);
  const found = header.split(',');
  const table = {};
  for (const name of names) {
    const column = found.indexOf(name);
    if (column < 0) throw new InputError(`${file}: has no column ${name}`);
    table[name] = Float64Array.from(lines, line => Number(line.split(',')[column]));
    const bad = table[name].findIndex(value => !Number.isFinite(value));
    if (bad >= 0) throw new InputError(`${file}:${bad + 2}: ${name}: a number is expected`);
  }
  return table;
}

const rows = (table, names) => Array.from(table[names[0]], (_, row) => names.map(name => table[name][row]));
const points = (table, [x, y, z]) =>
  Float64Array.from({length: 3 * table[x].length}, (_, i) => table[[x, y, z][i % 3]][Math.floor(i / 3)]);

function readScene(file) {
  const text = read(file);
  let scene;
  try {
    scene = JSON.parse(text);
  } catch {
    throw new InputError(`${file}: is not JSON`);
  }
  if (scene?.format !== 'mss-peer-1') throw new InputError(`${file}: format: "mss-peer-1" is expected`);
  for (const key of ['gravity', 'young', 'poisson', 'damping', 'cells', 'planes', 'loads', 'sample_times'])
    if (!(key in scene)) throw new InputError(`${file}: has no key ${key}`);
  return scene;
}

/// Refuses what no adapter gives its engine and what changes where a body goes.
function refuseOthers({loads, planes}) {
  if (loads.length > 0) throw new InputError('the scene has loads, which this adapter does not give to its engine');
  if (planes.some(({friction, restitution}) => friction !== planes[0].friction || restitution !== planes[0].restitution))
    throw new InputError('the scene has planes of different friction or restitution; this adapter gives all those of one');
}

/// What a user should know who compares a body that is damped.
function damped({law, ratio, viscosity}) {
  return law === 'thesis' || ratio > 0 || viscosity > 0;
}

/// A folder that `mss peer export` wrote.
export function readExport(directory) {
  const scene = readScene(join(directory, 'scene.json'));
  refuseOthers(scene);
  const particles = readTable(join(directory, 'particles.csv'),
    ['x', 'y', 'z', 'mass', 'held', 'start_x', 'start_y', 'start_z', 'start_vx', 'start_vy', 'start_vz']);
  const springs = readTable(join(directory, 'springs.csv'), ['a', 'b', 'stiffness', 'rest_length']);
  const corners = ['n0', 'n1', 'n2', 'n3', 'n4', 'n5', 'n6', 'n7'];
  const hexahedra = readTable(join(directory, 'hexahedra.csv'), [...corners, 'volume_stiffness']);
  return {
    scene,
    count: particles.mass.length,
    rest: points(particles, ['x', 'y', 'z']),       // [m]
    start: points(particles, ['start_x', 'start_y', 'start_z']),
    velocity: points(particles, ['start_vx', 'start_vy', 'start_vz']),  // [m/s]
    mass: particles.mass,                           // [kg]
    held: Array.from(particles.held, held => held !== 0),
    springs: rows(springs, ['a', 'b', 'stiffness', 'rest_length']),
    hexahedra: rows(hexahedra, corners),
    volumeStiffness: hexahedra.volume_stiffness,    // [Pa], by hexahedron
    tetrahedra: rows(readTable(join(directory, 'tetrahedra.csv'), ['a', 'b', 'c', 'd']), ['a', 'b', 'c', 'd']),
  };
}

/// Triangles of tetrahedra that no other one shares, seen from outside counter-clockwise.
export function surface(tetrahedra) {
  const open = new Map();
  for (const [a, b, c, d] of tetrahedra)
    for (const face of [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]) {
      const key = [...face].sort((p, q) => p - q).join();
      open.has(key) ? open.delete(key) : open.set(key, face);
    }
  return [...open.values()];
}

/// Whether the numbers are no longer those of a body: not finite, or further away than it can be.
function blownUp(x, limit) {
  return x.some(value => !(Math.abs(value) < limit));
}

/// Takes an engine through the sample times; between two steps, positions are on the straight line.
/// Only the engine's own steps are timed.
function simulate(engine, exported, step) {
  const limit = 100 * (1 + exported.rest.reduce((most, value) => Math.max(most, Math.abs(value)), 0));
  const snapshot = t => ({t, x: engine.positions().slice(), v: engine.velocities().slice()});
  const samples = [];
  let before = snapshot(0), now = before, taken = 0, wall = 0, cpu = 0, status = 'ok';
  for (const t of exported.scene.sample_times) {
    while (now.t < t - 1e-6 * step && status === 'ok') {
      const wallBefore = performance.now(), cpuBefore = process.cpuUsage();
      engine.step();
      const used = process.cpuUsage(cpuBefore);
      wall += (performance.now() - wallBefore) / 1e3;
      cpu += (used.user + used.system) / 1e6;
      before = now;
      now = snapshot(++taken * step);
      if (blownUp(now.x, limit)) status = `blew up at t = ${now.t.toPrecision(4)} s`;
    }
    if (status !== 'ok') break;
    const share = now.t > before.t ? Math.min(1, (t - before.t) / (now.t - before.t)) : 1;
    const between = name => share > 1 - 1e-6
      ? now[name] : now[name].map((value, i) => before[name][i] + share * (value - before[name][i]));
    samples.push({t, x: between('x'), v: between('v')});
  }
  return {samples, wall, cpu, status};
}

/// Writes a file whole or not at all.
function write(file, text) {
  writeFileSync(`${file}.part`, text);
  renameSync(`${file}.part`, file);
}

function writeResult(directory, engine, run, options) {
  mkdirSync(directory, {recursive: true});
  const lines = ['t,id,x,y,z,vx,vy,vz'];
  for (const {t, x, v} of run.samples)
    for (let id = 0; id < x.length / 3; ++id)
      lines.push([t, id, ...x.subarray(3 * id, 3 * id + 3), ...v.subarray(3 * id, 3 * id + 3)].join());
  write(join(directory, 'samples.csv'), lines.join('\n') + '\n');
  const [file, text] = engine.scene;
  write(join(directory, file), text);
  write(join(directory, 'cost.json'), JSON.stringify({
    engine: engine.name, version: engine.version, step: options.step, iterations: options.iterations ?? null,
    precision: engine.precision, wall_seconds: run.wall, cpu_seconds: run.cpu, threads: 1,
    settings: {...engine.settings, drag: options.drag, program: `WebAssembly in Node.js ${process.version}`},
    status: run.status}, null, 2) + '\n');
}

/// Runs again until half a second is spent, `repeat` times at most, and keeps the cost of the cheapest: a program
/// in WebAssembly is compiled better while it runs.
async function cheapest(make, exported, options) {
  let best, spent = 0;
  for (let round = 0; round < options.repeat && (round === 0 || spent < 0.5); ++round) {
    const engine = await make(exported, options);
    const run = simulate(engine, exported, options.step);
    engine.release();
    spent += run.wall;
    if (!best || run.cpu < best.run.cpu) best = {engine, run};
    if (run.status !== 'ok') break;
  }
  return best;
}

/// What all adapters understand; an adapter adds its own: {name: {meaning, number: true or a list of words}}. A
/// `whole` one counts from 1.
const common = {
  step: {meaning: 'of the engine [s]; 1/60', number: true, value: 1 / 60},
  iterations: {meaning: 'of the engine; its own default', number: true, whole: true},
  drag: {meaning: 'damping of all motion [1/s], to find rest; 0', number: true, value: 0},
  repeat: {meaning: 'runs at most, of which the cheapest counts; 1', number: true, whole: true, value: 1},
};

function usage(program, known) {
  const lines = Object.entries(known).map(([name, option]) => `  --${name} ${option.meaning}`);
  return `usage: node ${program} EXPORT_DIR RESULT_DIR [options]\n       node ${program} --version\n${lines.join('\n')}`;
}

function readOptions(program, known) {
  let parsed;
  try {
    parsed = parseArgs({allowPositionals: true, options: {version: {type: 'boolean'},
      ...Object.fromEntries(Object.keys(known).map(name => [name, {type: 'string'}]))}});
  } catch (error) {
    throw new InputError(`${error.message}\n${usage(program, known)}`);
  }
  const options = {};
  for (const [name, {number, whole, value}] of Object.entries(known)) {
    const given = parsed.values[name];
    options[name] = given === undefined ? value : number === true ? Number(given) : given;
    if (given === undefined) continue;
    if (number === true && !(given !== '' && options[name] >= 0 && Number.isFinite(options[name])))
      throw new InputError(`--${name}: a number of 0 or more is expected, found "${given}"`);
    if (whole && !(Number.isInteger(options[name]) && options[name] > 0))
      throw new InputError(`--${name}: a whole number of 1 or more is expected, found "${given}"`);
    if (Array.isArray(number) && !number.includes(given))
      throw new InputError(`--${name}: ${number.join(' or ')} is expected, found "${given}"`);
  }
  if (!(options.step > 0)) throw new InputError('--step: a number above 0 is expected');
  return {version: parsed.values.version, positionals: parsed.positionals, options};
}

/// The whole program of an adapter. `version` loads the engine and says what it is.
export async function main({own, version, make}) {
  const program = basename(process.argv[1]);
  const known = {...common, ...own};
  try {
    const {version: versionAsked, positionals, options} = readOptions(program, known);
    if (versionAsked) {
      console.log(await version());
      process.exit(0);
    }
    if (positionals.length !== 2) throw new InputError(usage(program, known));
    const exported = readExport(positionals[0]);
    if (damped(exported.scene.damping))
      console.error(`${program}: warning: the scene is damped, and this adapter does not give its engine the damping`);
    await version();
    const {engine, run} = await cheapest(make, exported, options);
    writeResult(positionals[1], engine, run, options);
    process.exit(0);  // engines keep workers and timers
  } catch (error) {
    console.error(`${program}: ${error?.message ?? error}`);
    process.exit(error instanceof MissingEngine ? 3 : error instanceof InputError ? 2 : 1);
  }
}
