// What is drawn: body, box, states, cut planes, path and hand, as objects of three.js.
'use strict';

const size = Math.max(1e-6, norm([0, 1, 2].map(i => scene.extent.high[i] - scene.extent.low[i])));
const layers = {};  // name -> THREE.Object3D

function layer(name, object) {
  object.name = name;
  layers[name] = object;
  world.add(object);
  return object;
}

function points(positions, colour, pixels) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3));
  const disc = document.createElement('canvas');
  disc.width = disc.height = 32;
  const pen = disc.getContext('2d');
  pen.fillStyle = '#fff';
  pen.strokeStyle = '#666';
  pen.lineWidth = 3;
  pen.beginPath();
  pen.arc(16, 16, 13.5, 0, 2 * Math.PI);
  pen.fill();
  pen.stroke();
  return new THREE.Points(geometry, new THREE.PointsMaterial({
    size: pixels * window.devicePixelRatio, sizeAttenuation: false, vertexColors: THREE.VertexColors,
    map: new THREE.CanvasTexture(disc), alphaTest: 0.5}));
}

function filled(count, colour) {
  const all = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) all.set(colour, 3 * i);
  return all;
}

const world = new THREE.Scene();
world.background = new THREE.Color('#ffffff');

// ---- body
let bodyMaterials = [], bodyGeometry = null;
const marked = {};  // 'clamp', 'contact' -> indices of the surface's nodes

// Vertices that are drawn: the surface's nodes, once for each region that they touch.
const drawn = {node: [], region: []};

function drawnTriangles() {
  const {triangles, region, role} = scene.body, corners = new Uint32Array(triangles.length), place = new Map();
  if (!region.length) {
    drawn.node = [...role.keys()];
    drawn.region = drawn.node.map(() => 0);
    return triangles;
  }
  triangles.forEach((node, k) => {
    const own = region[Math.floor(k / 3)], key = own * role.length + node;
    if (!place.has(key)) {
      place.set(key, drawn.node.length);
      drawn.node.push(node);
      drawn.region.push(own);
    }
    corners[k] = place.get(key);
  });
  return corners;
}

function colourBody(group) {
  const colour = bodyGeometry.attributes.color.array, {role, groups} = scene.body;
  const chosen = new Set((groups.find(g => g.name === group) || {nodes: []}).nodes);
  drawn.node.forEach((node, i) => {
    const name = chosen.has(node) ? 'group' : role[node] ? ['clamp', 'contact'][role[node] - 1]
               : drawn.region[i] ? 'region_' + drawn.region[i] : 'body';
    colour.set(rgb(name), 3 * i);
  });
  bodyGeometry.attributes.color.needsUpdate = true;
}

// Where regions touch inside the body, at rest: one layer a region.
function makeRegions() {
  const {nodes, triangles, region} = scene.body.inside;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(nodes, 3));
  scene.body.regions.forEach((_, k) => {
    const own = [];
    region.forEach((r, t) => {
      if (r === k) own.push(...triple(triangles, t));
    });
    if (!own.length) return;
    const part = geometry.clone();
    part.setIndex(own);
    const material = new THREE.MeshPhongMaterial({color: colours['region_' + (k + 1)], side: THREE.DoubleSide,
                                                  flatShading: true, specular: 0});
    const mesh = layer('region_' + (k + 1), new THREE.Mesh(part, material));
    mesh.userData.region = k;
  });
}

// The springs of a pad on top of the surface: the contact's colour where they are strongest, the body's where they end.
function makePad() {
  const {pad, region} = scene.body, count = pad.facet.length, colour = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) {
    const own = region[pad.facet[i]], from = rgb(own ? 'region_' + own : 'body'), to = rgb('contact');
    colour.set(from.map((v, k) => v + pad.weight[i] * (to[k] - v)), 3 * i);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3));
  geometry.setIndex(new THREE.BufferAttribute(pad.triangles, 1));
  layer('contact', new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({
    vertexColors: THREE.VertexColors, side: THREE.DoubleSide, flatShading: true, specular: 0, polygonOffset: true,
    polygonOffsetFactor: -1, polygonOffsetUnits: -1})));
}

// The pad follows the surface at `place` (mm, 3 a node).
function movePad(place) {
  const {pad, triangles} = scene.body, {geometry} = layers.contact, at = geometry.attributes.position;
  for (let i = 0; i < pad.facet.length; ++i) {
    const [a, b, c] = triple(triangles, pad.facet[i]).map(node => triple(place, node)), l = triple(pad.at, i);
    at.array.set(a.map((_, k) => l[0] * a[k] + l[1] * b[k] + l[2] * c[k]), 3 * i);
  }
  at.needsUpdate = true;
  geometry.computeBoundingSphere();
}

function makeBody() {
  const body = scene.body;
  bodyGeometry = new THREE.BufferGeometry();
  const triangles = drawnTriangles(), count = drawn.node.length;
  bodyGeometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  bodyGeometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  bodyGeometry.setIndex(new THREE.BufferAttribute(triangles, 1));
  colourBody('');
  makeRegions();
  // The far side first, then the near one, so that a thin body looks right.
  const both = layer('body', new THREE.Group());
  bodyMaterials = [THREE.BackSide, THREE.FrontSide].map((side, i) => {
    const material = new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, side, flatShading: true,
                                                  specular: 0, transparent: true, depthWrite: false});
    const mesh = new THREE.Mesh(bodyGeometry, material);
    mesh.renderOrder = 3 + 0.5 * i;
    both.add(mesh);
    return material;
  });
  const edges = layer('edges', new THREE.Mesh(bodyGeometry, new THREE.MeshBasicMaterial({
    color: '#3a3a3a', wireframe: true, transparent: true, opacity: 0.16, depthWrite: false})));
  edges.renderOrder = 4;
  for (const [number, name] of [[1, 'clamp'], [2, 'contact']]) {
    marked[name] = [...body.role.keys()].filter(i => body.role[i] === number);
    if (!marked[name].length) continue;
    const at = new Float32Array(3 * marked[name].length);
    layer(name, points(at, filled(marked[name].length, rgb(name)), name === 'contact' ? 7 : 5));
  }
  if (body.pad) makePad();
  moveBody(null);
}

// Positions of the surface: at rest, or displaced (mm, 3 a node).
function moveBody(moved) {
  const at = bodyGeometry.attributes.position, place = scene.body.nodes.slice();
  if (moved) moved.forEach((by, i) => place[i] += by);
  drawn.node.forEach((node, i) => at.array.set(triple(place, node), 3 * i));
  at.needsUpdate = true;
  bodyGeometry.computeBoundingSphere();
  if (scene.body.pad) movePad(place);
  for (const name of Object.keys(marked)) {
    if (!marked[name].length) continue;
    const dots = layers[name].geometry.attributes.position;
    marked[name].forEach((node, k) => dots.array.set(triple(place, node), 3 * k));
    dots.needsUpdate = true;
    layers[name].geometry.computeBoundingSphere();
  }
}

// ---- box, axes
function makeBox() {
  const {low, high} = scene.box;
  const middle = low.map((v, i) => 0.5 * (v + high[i]));
  const sides = low.map((v, i) => Math.max(high[i] - v, 1e-6 * size));
  const edges = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxBufferGeometry(...sides)),
                                       new THREE.LineBasicMaterial({color: '#444444'}));
  edges.position.set(...middle);
  layer('box', edges);
}

function textSprite(text, colour) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext('2d');
  pen.font = '44px sans-serif';
  pen.fillStyle = colour;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillText(text, 32, 32);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), depthWrite: false}));
  sprite.scale.setScalar(0.05 * size);
  return sprite;
}

function makeAxes() {
  const axes = new THREE.Group();
  const length = 0.1 * size, ink = ['x', 'y', 'z'].map(axis => colours['axis_' + axis]);
  for (let i = 0; i < 3; ++i) {
    const direction = new THREE.Vector3().setComponent(i, 1);
    const from = new THREE.Vector3();
    axes.add(new THREE.ArrowHelper(direction, from, length, ink[i], 0.2 * length, 0.1 * length));
    const name = textSprite('xyz'[i], ink[i]);
    name.position.copy(direction).multiplyScalar(1.25 * length);
    axes.add(name);
  }
  axes.position.set(...scene.extent.low.map(v => v - 0.04 * size));
  layer('axes', axes);
}

// ---- states, in the order in which they became known
let stateOrder = [];

function stateColour(i, by) {
  const s = scene.states;
  const outcome = s.outcomes[s.outcome[i]];
  if (by === 'outcome') return rgb(outcome === 'converged' || outcome === 'measured' ? 'solved' : 'failed');
  if (by === 'force') {
    const share = norm(triple(s.force, i)) / largestForce();
    return Number.isFinite(share) ? ramp(share) : rgb('failed');
  }
  return rgb(s.label[i] === 3 ? 'blank_dot' : labelNames[s.label[i]]);
}

function largestForce() {
  let most = 1e-12;
  for (let i = 0; i < scene.states.label.length; ++i) {
    const f = norm(triple(scene.states.force, i));
    if (f > most) most = f;
  }
  return most;
}

// Light to dark, as share goes from 0 to 1.
function ramp(share) {
  const low = rgb('ramp_low'), high = rgb('ramp_high');
  const s = Math.min(1, Math.max(0, share));
  return low.map((v, i) => v + s * (high[i] - v));
}

function colourStates(by) {
  const colour = layers.states.geometry.attributes.color;
  stateOrder.forEach((state, k) => colour.array.set(stateColour(state, by), 3 * k));
  colour.needsUpdate = true;
}

function makeStates() {
  const s = scene.states;
  const from = i => Number.isFinite(s.known[i]) ? s.known[i] : -1;
  stateOrder = [...s.label.keys()].sort((a, b) => from(a) - from(b) || a - b);
  const at = new Float32Array(s.at.length);
  stateOrder.forEach((state, k) => at.set(triple(s.at, state), 3 * k));
  const count = stateOrder.length;
  layer('states', points(at, new Float32Array(at.length), count < 500 ? 7 : count < 4000 ? 5.5 : 4));
  colourStates('label');
}

// ---- cut planes through the labels
const planes = [];  // by axis: {mesh, texture, at}
let grid = null;    // of the time shown

function makePlanes() {
  grid = scene.labels[scene.labels.length - 1];
  for (let axis = 0; axis < 3; ++axis) {
    const u = axis === 0 ? 1 : 0, v = axis === 2 ? 1 : 2;
    const pixels = new Uint8Array(4 * grid.count[u] * grid.count[v]);
    const texture = new THREE.DataTexture(pixels, grid.count[u], grid.count[v], THREE.RGBAFormat);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(12), 3));
    geometry.setAttribute('uv', new THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const material = new THREE.MeshBasicMaterial({map: texture, side: THREE.DoubleSide, transparent: true,
                                                  opacity: 0.92});
    const mesh = layer('plane_' + 'xyz'[axis], new THREE.Mesh(geometry, material));
    mesh.renderOrder = 1;
    planes.push({mesh, texture, u, v, at: 0});
  }
}

function cellAt(axis, value) {
  const {low, high} = scene.box;
  const share = high[axis] > low[axis] ? (value - low[axis]) / (high[axis] - low[axis]) : 0;
  return Math.min(grid.count[axis] - 1, Math.max(0, Math.floor(share * grid.count[axis])));
}

function labelAt(place) {
  const [i, j, k] = [0, 1, 2].map(axis => cellAt(axis, place[axis]));
  return grid.label[(k * grid.count[1] + j) * grid.count[0] + i];
}

// Puts the plane across `axis` at `value` [mm] and colours it with the labels there.
function movePlane(axis, value) {
  const plane = planes[axis], {u, v} = plane, {low, high} = scene.box;
  plane.at = Math.min(high[axis], Math.max(low[axis], value));
  const corner = plane.mesh.geometry.attributes.position.array;
  [[low[u], low[v]], [high[u], low[v]], [high[u], high[v]], [low[u], high[v]]].forEach((c, k) => {
    corner[3 * k + axis] = plane.at;
    corner[3 * k + u] = c[0];
    corner[3 * k + v] = c[1];
  });
  plane.mesh.geometry.attributes.position.needsUpdate = true;
  plane.mesh.geometry.computeBoundingSphere();
  const stride = [1, grid.count[0], grid.count[0] * grid.count[1]];
  const start = cellAt(axis, plane.at) * stride[axis], pixels = plane.texture.image.data;
  for (let row = 0; row < grid.count[v]; ++row)
    for (let column = 0; column < grid.count[u]; ++column) {
      const label = grid.label[start + row * stride[v] + column * stride[u]];
      pixels.set(planeInk[label], 4 * (row * grid.count[u] + column));
    }
  plane.texture.needsUpdate = true;
}

const planeInk = labelNames.map(
    name => [...rgb(name).map(c => Math.round(255 * c)), name === 'blank' ? 150 : 255]);

// ---- path of the hand, force arrows
let arrow = null, hand = null, strongest = 1e-12;

function makeRun() {
  const run = scene.run, n = run.t.length;
  for (let i = 0; i < n; ++i) strongest = Math.max(strongest, norm(triple(run.sent, i)));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(run.at, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * n), 3));
  const whole = new THREE.Line(geometry.clone(), new THREE.LineBasicMaterial({color: colours.path_light}));
  const walked = new THREE.Line(geometry, new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors}));
  walked.renderOrder = 2;
  const path = new THREE.Group();
  path.add(whole, walked);
  Object.assign(path, {whole, walked});
  layer('path', path);
  colourPath('plain');

  const tails = [], step = Math.max(1, Math.floor(n / 120));
  for (let i = 0; i < n; i += step) {
    const at = triple(run.at, i), f = triple(run.sent, i);
    tails.push(...at, ...at.map((v, k) => v + 0.18 * size * f[k] / strongest));
  }
  const lines = new THREE.BufferGeometry();
  lines.setAttribute('position', new THREE.BufferAttribute(new Float32Array(tails), 3));
  const ink = new THREE.LineBasicMaterial({color: colours.force, transparent: true, opacity: 0.45});
  layer('forces', new THREE.LineSegments(lines, ink));
  hand = new THREE.Mesh(new THREE.SphereBufferGeometry(0.011 * size, 20, 14),
                        new THREE.MeshLambertMaterial({color: colours.path}));
  arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, colours.force);
  const both = new THREE.Group();
  both.add(hand, arrow);
  layer('hand', both);
}

function colourPath(by) {
  const run = scene.run, colour = layers.path.walked.geometry.attributes.color;
  let last = NaN;  // errors are known at samples; the last one holds until the next
  for (let i = 0; i < run.t.length; ++i) {
    if (Number.isFinite(run.error[i])) last = run.error[i];
    const ink = by === 'label' ? rgb(run.label[i] === 3 ? 'blank_dot' : labelNames[run.label[i]])
              : by === 'trusted' ? rgb(run.trusted[i] ? 'safe' : 'gap')
              : by === 'error' ? ramp((Number.isFinite(last) ? last : 0) / 0.14) : rgb('path');
    colour.array.set(ink, 3 * i);
  }
  colour.needsUpdate = true;
}
