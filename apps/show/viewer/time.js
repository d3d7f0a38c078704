// The time of a run: slider, play, the strip of force and labels.
'use strict';

let now = 0, playing = false;

function setTime(t) {
  const run = scene.run;
  now = Math.min(run.t[run.t.length - 1], Math.max(run.t[0], t));
  const i = lastUntil(run.t, now), at = triple(run.at, i), f = triple(run.sent, i);
  byId('clock').value = now;
  hand.position.set(...at);
  arrow.position.set(...at);
  arrow.visible = norm(f) > 1e-3 * strongest;
  if (arrow.visible) {
    arrow.setDirection(new THREE.Vector3(...f).normalize());
    const length = 0.02 * size + 0.25 * size * norm(f) / strongest;
    arrow.setLength(length, Math.min(0.035 * size, 0.4 * length), 0.018 * size);
  }
  layers.path.walked.geometry.setDrawRange(0, i + 1);
  layers.path.whole.geometry.setDrawRange(i, Infinity);
  if (scene.states) showKnown();
  if (run.shapes && scene.body) moveBody(shapeAt(now));
  byId('now').textContent = 't = ' + now.toFixed(2) + ' s, ' + momentText(i);
  drawStrip();
  draw();
}

function momentText(i) {
  const run = scene.run;
  const error = Number.isFinite(run.error[i]) ? ', error ' + digits(100 * run.error[i], 2) + ' %' : '';
  const trust = run.trusted ? (run.trusted[i] ? 'trusted, ' : 'not trusted, ') : '';
  return '|F| ' + digits(norm(triple(run.sent, i)), 3) + ' N, ' + labelNames[run.label[i]] + ', ' + trust +
         run.known[i] + ' states known' + error;
}

// States known by now, and the labels that go with them.
function showKnown() {
  let known = 0;
  while (known < stateOrder.length && !(scene.states.known[stateOrder[known]] > now)) ++known;
  layers.states.geometry.setDrawRange(0, known);
  const newest = scene.labels[lastUntil(scene.labels.map(g => g.time), now)];
  if (newest === grid) return;
  grid = newest;
  planes.forEach((plane, axis) => movePlane(axis, plane.at));
}

function shapeAt(t) {
  const {t: times, moved, scale} = scene.run.shapes, n = scene.body.nodes.length;
  const i = lastUntil(times, t), next = Math.min(i + 1, times.length - 1);
  const share = next > i ? Math.min(1, Math.max(0, (t - times[i]) / (times[next] - times[i]))) : 0;
  const out = new Float32Array(n);
  for (let k = 0; k < n; ++k)
    out[k] = scale * ((1 - share) * moved[i * n + k] + share * moved[next * n + k]);
  return out;
}

// Under the time: the force over the labels, the errors as dots.
function drawStrip() {
  const run = scene.run, canvas = byId('strip'), ratio = window.devicePixelRatio;
  const wide = canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const high = canvas.height = Math.round(54 * ratio);
  const pen = canvas.getContext('2d'), first = run.t[0], last = run.t[run.t.length - 1];
  const x = t => last > first ? (t - first) / (last - first) * (wide - 1) : 0;
  for (let i = 0; i < wide; ++i) {
    pen.fillStyle = colours[labelNames[run.label[lastUntil(run.t, first + (last - first) * i / wide)]]];
    pen.fillRect(i, high - 5 * ratio, 1, 5 * ratio);
  }
  pen.strokeStyle = '#1b1b1b';
  pen.lineWidth = 1.2 * ratio;
  pen.beginPath();
  for (let i = 0; i < run.t.length; ++i)
    pen.lineTo(x(run.t[i]), (high - 7 * ratio) * (1 - 0.92 * norm(triple(run.sent, i)) / strongest));
  pen.stroke();
  pen.fillStyle = colours.force;
  for (let i = 0; i < run.t.length; ++i)
    if (run.error[i] > 0.07) pen.fillRect(x(run.t[i]) - ratio, 1, 2 * ratio, 4 * ratio);
  pen.fillStyle = colours.path;
  pen.fillRect(x(now) - ratio, 0, 2 * ratio, high);
}

function makeTime() {
  const run = scene.run;
  byId('time').style.display = 'block';
  document.body.className = 'run';
  byId('words').textContent = '|F|, up to ' + digits(strongest, 3) +
      ' N; below it the label at the hand, above it red ticks where the error is over 7 %';
  const first = run.t[0], last = run.t[run.t.length - 1];
  Object.assign(byId('clock'), {min: first, max: last, step: 'any'});
  byId('clock').oninput = () => setTime(Number(byId('clock').value));
  const timeAt = event => first + (last - first) * event.offsetX / byId('strip').clientWidth;
  byId('strip').onpointerdown = event => setTime(timeAt(event));
  byId('strip').onpointermove = event => {
    if (event.buttons & 1) return setTime(timeAt(event));
    const i = lastUntil(run.t, timeAt(event));
    showTip(event.clientX, event.clientY - 60, 't = ' + run.t[i].toFixed(3) + ' s\n' + momentText(i));
  };
  byId('strip').onpointerleave = hideTip;
  byId('play').onclick = () => {
    playing = !playing;
    byId('play').textContent = playing ? 'pause' : 'play';
    if (playing && now >= last) setTime(first);
    let before = performance.now();
    const step = time => {
      if (!playing) return;
      setTime(now + (time - before) / 1000);
      before = time;
      if (now < last) return requestAnimationFrame(step);
      playing = false;
      byId('play').textContent = 'play';
    };
    if (playing) requestAnimationFrame(step);
  };
  setTime(last);  // where most is known
}
