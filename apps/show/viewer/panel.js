// The camera, and the panel at the left.
'use strict';

const byId = id => document.getElementById(id);
const stage = byId('stage'), tip = byId('tip');
let renderer = null;
try {
  renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
} catch (error) {
  byId('failure').style.display = 'block';
  throw error;
}
renderer.localClippingEnabled = true;
stage.appendChild(renderer.domElement);

const camera = new THREE.PerspectiveCamera(32, 1, size / 100, size * 40);
camera.up.set(0, 0, 1);
const controls = new THREE.OrbitControls(camera, renderer.domElement);
world.add(new THREE.HemisphereLight('#ffffff', '#b9b3a6', 0.72));
const lamp = new THREE.DirectionalLight('#ffffff', 0.42);
camera.add(lamp);
lamp.position.set(0.4, 0.6, 1);
world.add(camera);

let pending = false;
function draw() {
  if (pending) return;
  pending = true;
  requestAnimationFrame(() => {
    pending = false;
    renderer.render(world, camera);
  });
}

// ---- camera
const middle = scene.extent.low.map((v, i) => 0.5 * (v + scene.extent.high[i]));

// Azimuth and elevation [degrees] of the camera; distance 1 shows everything.
function look(azimuth, elevation, distance) {
  const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
  const radius = 0.5 * size * Math.max(1, 1 / camera.aspect);
  const away = 0.86 * distance * radius / Math.sin(0.5 * camera.fov * Math.PI / 180);
  controls.target.set(...middle);
  const direction = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  camera.position.set(...middle.map((v, i) => v + away * direction[i]));
  controls.update();
  draw();
}

function resize() {
  renderer.setPixelRatio(window.devicePixelRatio);
  renderer.setSize(window.innerWidth, window.innerHeight);
  camera.aspect = window.innerWidth / window.innerHeight;
  // The panel and the time take room at the left and below.
  const left = window.innerWidth > 700 ? 120 : 0, below = scene.run ? 55 : 0;
  const {innerWidth: wide, innerHeight: high} = window;
  camera.setViewOffset(wide, high, -left, below, wide, high);
  if (scene.run) drawStrip();
  draw();
}

// ---- panel
function row(parent, html) {
  const element = document.createElement('label');
  element.innerHTML = html;
  parent.appendChild(element);
  return element;
}

function swatch(colour) {
  return '<span class="swatch" style="background:' + colours[colour] + '"></span> ';
}

function heading(text) {
  const element = document.createElement('h2');
  element.textContent = text;
  byId('panel').appendChild(element);
}

function toggle(name, text, colour, on) {
  if (!layers[name]) return;
  const element = row(byId('panel'), '<input type="checkbox">' + (colour ? swatch(colour) : ''));
  element.append(text);
  const box = element.querySelector('input');
  box.id = 'layer-' + name;
  box.checked = layers[name].visible = on;
  box.onchange = () => {
    layers[name].visible = box.checked;
    draw();
  };
}

function choice(text, options, chosen) {
  const element = row(byId('panel'), text + ' <select class="value"></select>');
  const list = element.querySelector('select');
  for (const option of options) list.add(new Option(option, option));
  list.onchange = () => {
    chosen(list.value);
    draw();
  };
  return list;
}

function slider(parent, id, from, to, value, changed) {
  const input = document.createElement('input');
  Object.assign(input, {type: 'range', id, min: from, max: to, step: (to - from) / 1000 || 1});
  input.value = value;
  input.oninput = () => {
    changed(Number(input.value));
    draw();
  };
  parent.appendChild(input);
  return input;
}

function planeRow(axis) {
  const name = 'plane_' + 'xyz'[axis];
  const {low, high} = scene.box;
  const element = row(byId('panel'), '<input type="checkbox" id="layer-' + name + '"> ' + 'xyz'[axis] +
                      ' = <span class="value"></span>');
  const check = element.querySelector('input'), text = element.querySelector('.value');
  const start = low[axis] <= 0 && high[axis] >= 0 ? 0 : 0.5 * (low[axis] + high[axis]);
  const move = value => {
    movePlane(axis, value);
    text.textContent = digits(planes[axis].at, 4) + ' mm';
    cutBody();
  };
  const input = slider(byId('panel'), 'cut-' + 'xyz'[axis], low[axis], high[axis], start, move);
  check.checked = planes[axis].mesh.visible = axis === 1;
  check.onchange = () => {
    planes[axis].mesh.visible = check.checked;
    cutBody();
    draw();
  };
  planes[axis].move = value => {
    input.value = value;
    move(value);
  };
  move(start);
}

function regionLayers() {
  return scene.body.regions.map((_, k) => 'region_' + (k + 1));
}

let cutting = false;
// Leaves out the part of the body in front of each plane that is shown.
function cutBody() {
  if (!scene.body) return;
  const cuts = [];
  planes.forEach((plane, axis) => {
    if (!cutting || !plane.mesh.visible) return;
    const towards = camera.position.getComponent(axis) > plane.at ? -1 : 1;
    const normal = new THREE.Vector3().setComponent(axis, towards);
    cuts.push(new THREE.Plane(normal, -normal.getComponent(axis) * plane.at));
  });
  const others = ['edges', 'clamp', 'contact', ...regionLayers()].filter(name => layers[name]);
  const materials = [...bodyMaterials, ...others.map(name => layers[name].material)];
  for (const material of materials) material.clippingPlanes = cuts;
}

// The regions with their colours; the check shows their surface inside the body.
function regionRows() {
  const {regions, restWords} = scene.body;
  if (!regions.length) return;
  heading(regions.some(r => r.words) ? 'Materials' : 'Groups of elements');
  regions.forEach((region, k) => {
    const name = 'region_' + (k + 1);
    const text = region.name + (region.words ? ': ' + region.words : '') + ', ' +
                 digits(1e6 * region.volume, 3) + ' cm³';
    if (layers[name]) return toggle(name, text, name, true);
    row(byId('panel'), swatch(name)).append(text);
  });
  if (restWords) row(byId('panel'), swatch('body')).append('the rest: ' + restWords);
  if (scene.run && scene.run.shapes) row(byId('panel'), '').append('surfaces inside are shown at rest');
}

// Lets states, or regions inside the body, be seen through it.
function firstOpacity() {
  return scene.states || scene.run ? 0.3 : scene.body.inside.region.length ? 0.4 : 1;
}

function makePanel() {
  byId('title').textContent = scene.title;
  heading('Layers');
  toggle('body', 'body', 'body', true);
  toggle('edges', 'edges of its surface', null, !scene.states && !scene.run);
  toggle('clamp', 'clamp (held)', 'clamp', true);
  const pad = scene.body && scene.body.pad;
  toggle('contact', !pad ? 'contact (moves with the hand)'
         : pad.shade === 'stiffness' ? 'stiffness of the body at rest, ' + digits(pad.least, 3) + ' to ' + digits(pad.peak, 3) + ' N/m'
         : pad.shade === 'error' ? 'estimated error ' + digits(1e3 * pad.depth, 3) + ' mm deep, to ' + digits(100 * pad.peak, 2) + ' % and more'
         : 'pad (springs to the hand), up to ' + digits(1e-6 * pad.peak, 3) + ' kPa/mm', 'contact', true);
  const sides = scene.box ? scene.box.low.map((v, i) => digits(scene.box.high[i] - v, 3)) : [];
  toggle('box', 'box ' + sides.join(' × ') + ' mm', null, true);
  toggle('states', scene.states ? scene.states.label.length + ' states' : '', null, true);
  toggle('path', 'path of the hand', 'path', true);
  toggle('forces', 'forces along the path', 'force', false);
  toggle('hand', 'hand and its force', 'force', true);
  toggle('axes', 'axes', null, true);
  if (scene.body) {
    const shade = row(byId('panel'), 'opacity of the body');
    slider(shade, 'opacity', 0, 1, firstOpacity(), setOpacity);
    setOpacity(firstOpacity());
    if (scene.body.groups.length)
      choice('show group', ['', ...scene.body.groups.map(g => g.name)], colourBody);
    regionRows();
  }
  if (scene.states) choice('colour of states', ['label', 'outcome', 'force'], colourStates).id = 'states-by';
  if (scene.run) choice('colour of the path', ['plain', 'label', 'error', ...(scene.run.trusted ? ['trusted'] : [])],
                        colourPath).id = 'path-by';
  if (scene.labels) {
    heading('Cut planes through the labels');
    for (let axis = 0; axis < 3; ++axis) planeRow(axis);
    const cut = row(byId('panel'), '<input type="checkbox" id="cut-body"> cut the body open there');
    cut.querySelector('input').onchange = event => {
      cutting = event.target.checked;
      cutBody();
      draw();
    };
    legend();
  }
}

function setOpacity(value) {
  for (const material of bodyMaterials)
    Object.assign(material, {opacity: value, transparent: value < 1, depthWrite: value >= 1,
                             needsUpdate: true});
}

function legend() {
  const all = scene.states.volume.reduce((a, b) => a + b, 0);
  labelNames.forEach((name, i) => {
    const part = document.createElement('p');
    const percent = all > 0 ? 100 * scene.states.volume[i] / all : 0;
    part.innerHTML = swatch(name) + name + ' ' + digits(1e6 * scene.states.volume[i], 3) + ' cm³, ' +
                     percent.toFixed(1) + ' %, ' +
                     scene.states.components[i] + (scene.states.components[i] === 1 ? ' component' : ' components');
    byId('panel').appendChild(part);
  });
}
