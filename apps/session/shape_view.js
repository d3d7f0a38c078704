// The surface of the body over the time of a session: triangles from behind to the front, each in one colour, from that
// of rest to that of the largest displacement.
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('shape-data').textContent);
  const unpacked = (text, Type) => new Type(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
  const rest = unpacked(data.rest, Int16Array), moved = unpacked(data.moved, Int16Array);
  const corners = unpacked(data.triangles, Uint32Array), n = rest.length / 3, faces = corners.length / 3;
  const canvas = document.getElementById('shape-view'), clock = document.getElementById('shape-clock');
  const now = document.getElementById('shape-now');
  const [still, gone] = data.colours.map(text => [1, 3, 5].map(at => parseInt(text.slice(at, at + 2), 16)));
  let azimuth = data.azimuth, elevation = data.elevation;
  const at = new Float32Array(3 * n), seen = new Float32Array(3 * n), depth = new Float32Array(faces);
  const order = Array.from({length: faces}, (_, i) => i);

  function place(k) {
    for (let i = 0; i < 3 * n; ++i) at[i] = data.rest_scale * rest[i] + data.moved_scale * moved[3 * n * k + i];
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
    for (let i = 0; i < n; ++i) {
      const x = at[3 * i], y = at[3 * i + 1], z = at[3 * i + 2], out = ca * x + sa * y;
      seen[3 * i] = ca * y - sa * x;
      seen[3 * i + 1] = ce * z - se * out;
      seen[3 * i + 2] = ce * out + se * z;
    }
  }
  function colour(face, k) {
    let share = 0;
    for (let c = 0; c < 3; ++c) {
      const i = 3 * n * k + 3 * corners[3 * face + c];
      share += Math.hypot(moved[i], moved[i + 1], moved[i + 2]) * data.moved_scale / data.largest / 3;
    }
    const [a, b, c] = [0, 1, 2].map(j => 3 * corners[3 * face + j]);
    const u = [0, 1, 2].map(j => seen[b + j] - seen[a + j]), v = [0, 1, 2].map(j => seen[c + j] - seen[a + j]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const light = 0.6 + 0.4 * Math.abs(normal[2]) / (Math.hypot(...normal) || 1);
    return 'rgb(' + still.map((from, c) => Math.round(light * (from + (gone[c] - from) * Math.min(1, share)))).join() + ')';
  }
  function draw() {
    const k = Number(clock.value), scale = window.devicePixelRatio || 1;
    const w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = Math.round(w * scale);
    canvas.height = Math.round(h * scale);
    const pen = canvas.getContext('2d'), zoom = scale * Math.min(w, h) / data.size;
    place(k);
    for (let f = 0; f < faces; ++f)
      depth[f] = seen[3 * corners[3 * f] + 2] + seen[3 * corners[3 * f + 1] + 2] + seen[3 * corners[3 * f + 2] + 2];
    order.sort((a, b) => depth[a] - depth[b]);
    for (const f of order) {
      pen.beginPath();
      for (let c = 0; c < 3; ++c) {
        const i = 3 * corners[3 * f + c];
        pen.lineTo(canvas.width / 2 + zoom * seen[i], canvas.height / 2 - zoom * seen[i + 1]);
      }
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = colour(f, k);
      pen.fill();
      pen.stroke();
    }
    now.textContent = data.t[k].toFixed(3) + ' s, moved by up to ' + (1e3 * data.most[k]).toPrecision(3) + ' mm';
  }
  canvas.addEventListener('pointerdown', e => canvas.setPointerCapture(e.pointerId));
  canvas.addEventListener('pointermove', e => {
    if (!e.buttons) return;
    azimuth -= 0.01 * e.movementX;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + 0.01 * e.movementY));
    draw();
  });
  clock.addEventListener('input', draw);
  window.addEventListener('resize', draw);
  draw();
})();
