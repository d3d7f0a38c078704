// The data of the page: typed arrays in base64, lengths in m. Here they become mm.
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const labelNames = ['safe', 'sparse', 'gap', 'blank'];
const arrayTypes = {f32: Float32Array, u32: Uint32Array, i16: Int16Array, u8: Uint8Array};

// {"f32": "base64"} -> Float32Array, and so on.
function decoded(packed) {
  const type = Object.keys(packed)[0];
  const text = atob(packed[type]);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new arrayTypes[type](bytes.buffer);
}

function millimetres(packed) {
  return decoded(packed).map(value => 1e3 * value);
}

// Labels of a grid from runs of equal ones: label, length (two bytes, low first).
function unrolled(packed, size) {
  const runs = decoded(packed), labels = new Uint8Array(size);
  let at = 0;
  for (let i = 0; i + 2 < runs.length; i += 3) {
    const end = at + runs[i + 1] + 256 * runs[i + 2];
    labels.fill(runs[i], at, end);
    at = end;
  }
  return labels;
}

function unpack(raw) {
  const box = b => b && {low: b.low.map(v => 1e3 * v), high: b.high.map(v => 1e3 * v)};
  const scene = {kind: raw.kind, title: raw.title, spacing: raw.spacing && 1e3 * raw.spacing};
  scene.box = box(raw.box);
  scene.extent = box(raw.extent);
  scene.view = raw.view;  // azimuth and elevation of the first view [degrees]
  if (raw.body) {
    const b = raw.body;
    scene.body = {nodes: millimetres(b.nodes), triangles: decoded(b.triangles), role: decoded(b.role),
                  node: decoded(b.node), rest: b.rest.map(v => 1e3 * v), elements: b.elements,
                  groups: b.groups.map(g => ({name: g.name, nodes: decoded(g.nodes)})),
                  regions: b.regions, region: decoded(b.region), restWords: b.rest_words,
                  inside: {nodes: millimetres(b.inside.nodes), triangles: decoded(b.inside.triangles),
                           region: decoded(b.inside.region)}};
    if (b.pad)
      scene.body.pad = {shade: b.pad.shade, depth: b.pad.depth, least: b.pad.least, peak: b.pad.peak, facet: decoded(b.pad.facet), at: decoded(b.pad.at),
                        weight: decoded(b.pad.weight), triangles: decoded(b.pad.triangles)};
    b.regions.forEach((region, k) => raw.colours['region_' + (k + 1)] = region.colour);
  }
  if (raw.states) {
    const s = raw.states;
    scene.states = {at: millimetres(s.at), force: decoded(s.force), label: decoded(s.label),
                    outcome: decoded(s.outcome), known: decoded(s.known), outcomes: s.outcomes,
                    volume: s.volume, components: s.components};
    scene.labels = s.labels.map(g => ({time: g.time, count: g.count,
                                       label: unrolled(g.runs, g.count[0] * g.count[1] * g.count[2])}));
  }
  if (raw.run) {
    const r = raw.run;
    scene.run = {t: decoded(r.t), at: millimetres(r.at), sent: decoded(r.sent), label: decoded(r.label),
                 error: decoded(r.error), trusted: r.trusted && decoded(r.trusted), known: decoded(r.known), frames: r.frames};
    if (r.shapes)
      scene.run.shapes = {t: decoded(r.shapes.t), scale: 1e3 * r.shapes.scale,
                          moved: decoded(r.shapes.moved)};
  }
  return scene;
}

const scene = unpack(data);
const colours = data.colours;  // name -> "#rrggbb"

function rgb(name) {
  const value = parseInt(colours[name].slice(1), 16);
  return [(value >> 16) / 255, (value >> 8 & 255) / 255, (value & 255) / 255];
}

function triple(array, i) {
  return [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
}

function norm(v) {
  return Math.hypot(v[0], v[1], v[2]);
}

function digits(value, n) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(n || 4))) : 'unknown';
}

function inMillimetres(v) {
  return v.map(x => digits(x, 4)).join(', ') + ' mm';
}

function inNewton(v) {
  return Number.isFinite(v[0]) ? v.map(x => digits(x, 3)).join(', ') + ' N, |F| ' + digits(norm(v), 3) + ' N'
                               : 'force unknown';
}

// The last index with array[index] <= value, at least 0; the array rises.
function lastUntil(array, value) {
  let low = 0, high = array.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (array[middle] <= value) low = middle; else high = middle - 1;
  }
  return low;
}
