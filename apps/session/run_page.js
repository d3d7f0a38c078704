  // What the page does: zoom and read-off, one switch, maps. Goes on where run_chart.js ends.

  // ---- the whole run

  const view = {from: 0, to: end, cursor: null};
  const main = new Chart(
      byId('run-time'), [['force', 220], ['labels', 16], ['switches', 26], ['error', 150], ['known', 62]],
      view);
  const around = {from: 0, to: 0.2, cursor: null, fit: true};
  const close = new Chart(byId('run-switch'), [['force', 190], ['labels', 14], ['switches', 26]], around);

  function readOff(s) {
    const i = Math.min(n - 1, Math.max(0, at(s))), k = nearest(run.samples, s),
          r = k < 0 ? null : run.samples[k];
    const cut = run.limit !== null && rendered[i] > run.limit * (1 + 1e-6);
    const items = [
      ['time', digits(t[i], 5) + ' s'], ['rendered', digits(rendered[i]) + ' N'],
      ['sent', digits(sent[i]) + ' N' + (cut ? ' (clamped)' : '')],
      ['newest model', digits(newest[i]) + ' N'],
      ['error bar (95 %)', bar[i] >= 0 ? '± ' + digits(bar[i]) + ' N' : '–'], ['label', run.names[held(run.labels, t[i])] || '–'],
      ['states known', held(run.known, t[i])], ['model', held(run.models, t[i])],
      ['tip', [x, y, z].map(c => digits(1e3 * c[i])).join(', ') + ' mm']
    ];
    const step = run.felt[nearest(run.felt, s)];
    if (step && Math.abs(step[0] - s) < Math.max(0.01, 0.01 * (view.to - view.from)))
      items.push([
        'felt step', digits(step[2]) + ' N (' + percent(step[3]) + ') by ' + step[4] + ' at ' + digits(step[0], 5) + ' s'
      ]);
    if (r)
      items.push([
        'nearest sample',
        'at ' + digits(r[0], 5) + ' s: reference ' + digits(r[1]) + ' N, error ' + percent(r[2]) + ' = ' +
            digits(r[3], 2) + ' × JND'
      ]);
    byId('run-read').innerHTML = items.map(([k, v]) => '<span><em>' + k + '</em> ' + v + '</span>').join('');
  }
  function look(from, to, cursor) {
    const least = 0.004, width = Math.min(end, Math.max(least, to - from));
    view.from = Math.min(Math.max(0, from), end - width);
    view.to = view.from + width;
    if (cursor !== undefined) view.cursor = cursor;
    main.draw();
    maps.forEach(m => m.draw());
    if (view.cursor !== null) readOff(view.cursor);
  }
  const zoom = (factor, about) =>
      look(about - (about - view.from) * factor, about + (view.to - about) * factor);
  const canvas = main.canvas;
  let held_at = null;
  canvas.addEventListener('pointermove', e => {
    const s = Math.min(end, Math.max(0, main.time(e.offsetX)));
    if (held_at) {
      const by = held_at.s - main.time(e.offsetX);
      if (Math.abs(e.offsetX - held_at.x) > 3) look(view.from + by, view.to + by);
      return;
    }
    view.cursor = s;
    readOff(s);
    main.draw();
    maps.forEach(m => m.draw());
  });
  canvas.addEventListener('pointerdown', e => {
    held_at = {x: e.offsetX, s: main.time(e.offsetX)};
    canvas.setPointerCapture(e.pointerId);
  });
  for (const name of ['pointerup', 'pointercancel'])
    canvas.addEventListener(name, () => {
      held_at = null;
    });
  canvas.addEventListener('wheel', e => {
    e.preventDefault();
    zoom(Math.pow(1.0015, e.deltaY), main.time(e.offsetX));
  }, {passive: false});
  canvas.addEventListener('dblclick', () => look(0, end));
  canvas.addEventListener('keydown', e => {
    const step = 0.1 * (view.to - view.from),
          middle = view.cursor === null ? (view.from + view.to) / 2 : view.cursor;
    const act = {
      ArrowLeft: () => look(view.from - step, view.to - step),
      ArrowRight: () => look(view.from + step, view.to + step),
      '+': () => zoom(0.7, middle),
      '-': () => zoom(1 / 0.7, middle),
      '0': () => look(0, end)
    }[e.key];
    if (act) {
      e.preventDefault();
      act();
    }
  });
  byId('run-all').onclick = () => look(0, end);
  byId('run-in').onclick = () => zoom(0.5, view.cursor === null ? (view.from + view.to) / 2 : view.cursor);
  byId('run-out').onclick = () => zoom(2, view.cursor === null ? (view.from + view.to) / 2 : view.cursor);
  for (const button of document.querySelectorAll('[data-moment]'))
    button.onclick = () => {
      const s = Number(button.dataset.moment);
      look(s - 0.4, s + 0.4, s);
      canvas.scrollIntoView({behavior: 'smooth', block: 'center'});
    };

  // ---- around one switch

  const slider = byId('run-which');
  function show(k) {
    const s = run.switches[k];
    if (!s) {
      byId('run-what').textContent = 'No model was switched.';
      return;
    }
    around.from = Math.max(0, s[0] - 0.06);
    around.to = around.from + 0.2;
    around.cursor = s[0];
    const causes = {
      guess: 'no state is known: a guessed stiffness',
      first: 'the first state came',
      states: 'more states came',
      travel: 'the tip had moved away from the last model'
    };
    byId('run-what').textContent = 'Switch ' + (k + 1) + ' of ' + run.switches.length + ', at ' +
        digits(s[0], 5) + ' s: ' + causes[s[2]] + '. ' + s[4] + ' states, ' + s[5] +
        ' of them new, chosen by label ' + s[3] + '. The models differ by ' + digits(s[6]) + ' N at the tip.';
    slider.value = k;
    close.draw();
  }
  slider.max = Math.max(0, run.switches.length - 1);
  slider.oninput = () => show(Number(slider.value));
  byId('run-before').onclick = () => show(Math.max(0, Number(slider.value) - 1));
  byId('run-next').onclick = () => show(Math.min(run.switches.length - 1, Number(slider.value) + 1));
  byId('run-largest').onclick = () =>
      show(run.switches.reduce((best, s, i) => (s[6] || 0) > (run.switches[best][6] || 0) ? i : best, 0));
  byId('run-here').onclick = () => {
    if (view.cursor !== null) show(nearest(run.switches, view.cursor));
  };

  // ---- where errors were

  const coordinates = [x, y, z], axes = ['x', 'y', 'z'];
  const tint = ratio => ratio === null ? '#c9c5bc' : ratio <= 1 ? ink.within : ratio <= 3 ? ink.above : ink.far_above;
  class Plan {
    constructor(canvas, a, b) {
      this.canvas = canvas;
      this.a = a;
      this.b = b;
      this.pending = false;
      new ResizeObserver(() => this.draw()).observe(canvas);
      canvas.addEventListener('pointermove', e => {
        let best = null, least = 400;
        for (const r of run.samples) {
          const d = (this.px(r[8 + a]) - e.offsetX) ** 2 + (this.py(r[8 + b]) - e.offsetY) ** 2;
          if (d < least) {
            least = d;
            best = r;
          }
        }
        if (best) {
          view.cursor = best[0];
          readOff(best[0]);
          main.draw();
          maps.forEach(m => m.draw());
        }
      });
    }
    draw() {
      if (this.pending) return;
      this.pending = true;
      requestAnimationFrame(() => {
        this.pending = false;
        this.paint();
      });
    }
    paint() {
      const [pen, w, h] = canvasOf(this.canvas), {a, b} = this, box = run.box;
      const low = i => Math.min(box[0][i], run.reach[0][i]), high = i => Math.max(box[1][i], run.reach[1][i]);
      const scale = Math.min((w - 62) / (high(a) - low(a) || 1e-6), (h - 46) / (high(b) - low(b) || 1e-6));
      const middle = [52 + (w - 60) / 2, 6 + (h - 42) / 2];
      this.px = v => middle[0] + (v - (low(a) + high(a)) / 2) * scale;
      this.py = v => middle[1] - (v - (low(b) + high(b)) / 2) * scale;
      pen.strokeStyle = '#8a8a8a';
      pen.setLineDash([3, 3]);
      pen.strokeRect(
          this.px(box[0][a]), this.py(box[1][b]), (box[1][a] - box[0][a]) * scale,
          (box[1][b] - box[0][b]) * scale);
      pen.setLineDash([]);
      const path = (from, to, colour, width) => {
        pen.strokeStyle = colour;
        pen.lineWidth = width;
        pen.beginPath();
        for (let i = from, every = Math.max(1, Math.floor((to - from) / 3000)); i < to; i += every)
          pen.lineTo(this.px(coordinates[a][i]), this.py(coordinates[b][i]));
        pen.stroke();
      };
      path(0, n, '#d6d2c8', 1);
      if (view.to - view.from < 0.999 * end) path(at(view.from), at(view.to), '#8a8a8a', 2.5);
      for (const r of [...run.samples].sort((p, q) => (p[3] || 0) - (q[3] || 0))) {
        pen.fillStyle = tint(r[3]);
        pen.beginPath();
        pen.arc(this.px(r[8 + a]), this.py(r[8 + b]), r[3] > 3 ? 3.2 : r[3] > 1 ? 2.6 : 1.7, 0, 7);
        pen.fill();
      }
      if (view.cursor !== null) {
        const i = Math.min(n - 1, at(view.cursor));
        pen.strokeStyle = '#1b1b1b';
        pen.lineWidth = 1.6;
        pen.beginPath();
        pen.arc(this.px(coordinates[a][i]), this.py(coordinates[b][i]), 6, 0, 7);
        pen.stroke();
      }
      pen.fillStyle = '#3a3a3a';
      pen.textAlign = 'center';
      pen.textBaseline = 'top';
      for (const v of ticks(1e3 * low(a), 1e3 * high(a), 5))
        pen.fillText(digits(v), this.px(v / 1e3), h - 34);
      pen.fillText(axes[a] + ' [mm]', middle[0], h - 17);
      pen.textAlign = 'right';
      pen.textBaseline = 'middle';
      for (const v of ticks(1e3 * low(b), 1e3 * high(b), 5)) pen.fillText(digits(v), 46, this.py(v / 1e3));
      pen.save();
      pen.translate(10, middle[1]);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = 'center';
      pen.fillText(axes[b] + ' [mm]', 0, 0);
      pen.restore();
    }
  }
  const maps =
      [new Plan(byId('run-xy'), 0, 1), new Plan(byId('run-xz'), 0, 2), new Plan(byId('run-yz'), 1, 2)];
  if (run.switches.length)
    byId('run-largest').onclick();
  else
    show(0);
  if (n) readOff(0);
})();
