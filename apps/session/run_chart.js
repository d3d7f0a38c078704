// The report of a session: panels over one time axis. run_page.js goes on in the same function.
(() => {
  'use strict';
  const run = JSON.parse(document.getElementById('run-data').textContent);
  const bytes = Uint8Array.from(atob(run.columns), c => c.charCodeAt(0));
  const numbers = new Float32Array(bytes.buffer), n = run.frames;
  const [t, rendered, sent, newest, x, y, z, bar] =
      [0, 1, 2, 3, 4, 5, 6, 7].map(i => numbers.subarray(i * n, (i + 1) * n));
  const ink = run.ink, end = run.end, byId = id => document.getElementById(id);
  const at = s => {
    let a = 0, b = n;
    while (a < b) {
      const m = (a + b) >> 1;
      t[m] < s ? a = m + 1 : b = m;
    }
    return a;
  };
  // The value of a list of [time, value] that holds at s.
  const held = (list, s) => {
    let a = 0, b = list.length;
    while (a < b) {
      const m = (a + b) >> 1;
      list[m][0] <= s ? a = m + 1 : b = m;
    }
    return a > 0 ? list[a - 1][1] : undefined;
  };
  const nearest = (list, s) => {
    let best = -1;
    for (let i = 0; i < list.length; ++i)
      if (best < 0 || Math.abs(list[i][0] - s) < Math.abs(list[best][0] - s)) best = i;
    return best;
  };
  const digits = (v, d = 3) =>
      v === null || v === undefined || !isFinite(v) ? '–' : String(Number(v.toPrecision(d)));
  const faint = (colour, share) => colour + Math.round(255 * share).toString(16).padStart(2, '0');
  const percent = v => v === null ? '–' : digits(100 * v) + ' %';

  function canvasOf(element) {
    const scale = window.devicePixelRatio || 1, w = element.clientWidth, h = element.clientHeight;
    element.width = Math.round(w * scale);
    element.height = Math.round(h * scale);
    const pen = element.getContext('2d');
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.font = '12px system-ui, sans-serif';
    return [pen, w, h];
  }
  function ticks(low, high, count) {
    const raw = (high - low) / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= raw * 0.999), list = [];
    for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-6; v += step)
      list.push(Math.abs(v) < step * 1e-6 ? 0 : v);
    return list;
  }

  // Panels over one time axis. view: {from, to, cursor}; parts: which panels, with their heights.
  class Chart {
    constructor(canvas, parts, view) {
      this.canvas = canvas;
      this.parts = parts;
      this.view = view;
      this.left = 74;
      this.pending = false;
      new ResizeObserver(() => this.draw()).observe(canvas);
    }
    draw() {
      if (this.pending) return;
      this.pending = true;
      requestAnimationFrame(() => {
        this.pending = false;
        this.paint();
      });
    }
    sx(s) {
      return this.left + (s - this.view.from) / (this.view.to - this.view.from) * (this.w - this.left - 8);
    }
    time(px) {
      return this.view.from + (px - this.left) / (this.w - this.left - 8) * (this.view.to - this.view.from);
    }
    paint() {
      const [pen, w, h] = canvasOf(this.canvas);
      this.pen = pen;
      this.w = w;
      let top = 8;
      for (const [name, height] of this.parts) {
        this[name](top, height);
        top += height + 10;
      }
      pen.fillStyle = '#3a3a3a';
      pen.textAlign = 'center';
      pen.textBaseline = 'top';
      for (const s of ticks(this.view.from, this.view.to, Math.max(2, w / 110)))
        pen.fillText(digits(s, 6), this.sx(s), top - 6);
      pen.fillText('time [s]', (this.left + w) / 2, top + 9);
      if (this.view.cursor === null) return;
      pen.strokeStyle = '#1b1b1b';
      pen.lineWidth = 1;
      pen.setLineDash([2, 3]);
      this.line([[this.sx(this.view.cursor), 6], [this.sx(this.view.cursor), top - 8]]);
      pen.setLineDash([]);
    }
    line(points) {
      this.pen.beginPath();
      points.forEach(([a, b], i) => i ? this.pen.lineTo(a, b) : this.pen.moveTo(a, b));
      this.pen.stroke();
    }
    frame(top, height, title, marks, sy) {
      const pen = this.pen;
      pen.textAlign = 'right';
      pen.textBaseline = 'middle';
      pen.lineWidth = 1;
      for (const [v, text] of marks) {
        pen.strokeStyle = '#e4e1da';
        this.line([[this.left, sy(v)], [this.w - 8, sy(v)]]);
        pen.fillStyle = '#3a3a3a';
        pen.fillText(text, this.left - 6, sy(v));
      }
      pen.strokeStyle = '#8a8a8a';
      this.line([[this.left, top], [this.left, top + height], [this.w - 8, top + height]]);
      pen.save();
      pen.translate(12, top + height / 2);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = 'center';
      pen.fillText(title, 0, 0);
      pen.restore();
    }
    clipped(top, height, draw) {
      const pen = this.pen;
      pen.save();
      pen.beginPath();
      pen.rect(this.left, top, this.w - this.left - 8, height);
      pen.clip();
      draw();
      pen.restore();
    }
    // Least and largest value of each pixel where there are more frames than pixels.
    curve(values, sy, colour, width, dash = []) {
      const pen = this.pen, first = Math.max(0, at(this.view.from) - 1),
            last = Math.min(n, at(this.view.to) + 1);
      const points = [], every = (last - first) / (this.w - this.left);
      if (every < 3)
        for (let i = first; i < last; ++i) points.push([this.sx(t[i]), sy(values[i])]);
      else
        for (let p = 0; p < this.w - this.left; ++p) {
          let low = Infinity, high = -Infinity;
          const a = Math.floor(first + p * every), b = Math.floor(first + (p + 1) * every);
          for (let i = a; i < b; ++i) {
            if (values[i] < low) low = values[i];
            if (values[i] > high) high = values[i];
          }
          if (low <= high) points.push([this.sx(t[a]), sy(low)], [this.sx(t[a]), sy(high)]);
        }
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.setLineDash(dash);
      this.line(points);
      pen.setLineDash([]);
    }
    dots(list, value, sy, colour, size) {
      this.pen.fillStyle = colour;
      for (const r of list) {
        if (r[0] < this.view.from || r[0] > this.view.to || value(r) === null) continue;
        this.pen.beginPath();
        this.pen.arc(this.sx(r[0]), sy(value(r)), size, 0, 7);
        this.pen.fill();
      }
    }
    // The error bar: from |rendered| less the bar to |rendered| plus it, in stretches where there is one.
    band(sy, colour) {
      const first = Math.max(0, at(this.view.from) - 1), last = Math.min(n, at(this.view.to) + 1);
      const step = Math.max(1, Math.floor((last - first) / (2 * this.w)));
      this.pen.fillStyle = colour;
      for (let i = first; i < last;) {
        const stretch = [];
        for (; i < last && bar[i] >= 0; i += step) stretch.push(i);
        if (stretch.length > 1) {
          this.pen.beginPath();
          for (const k of stretch) this.pen.lineTo(this.sx(t[k]), sy(rendered[k] + bar[k]));
          for (const k of stretch.reverse()) this.pen.lineTo(this.sx(t[k]), sy(Math.max(0, rendered[k] - bar[k])));
          this.pen.fill();
        }
        i += step;
      }
    }
    // The range of the forces in view; from zero, unless the chart is to fit them closely.
    range() {
      let low = Infinity, high = 1e-3;
      const first = Math.max(0, at(this.view.from) - 1), last = Math.min(n, at(this.view.to) + 1);
      const take = v => {
        low = Math.min(low, v);
        high = Math.max(high, v);
      };
      for (let i = first; i < last; ++i) {
        take(rendered[i]);
        take(this.view.fit ? newest[i] : sent[i]);
      }
      for (const r of run.samples)
        if (r[0] >= this.view.from && r[0] <= this.view.to) take(r[1] || 0);
      if (!this.view.fit)
        return [0, 1.08 * (run.limit !== null && run.limit < 1.6 * high ? Math.max(high, run.limit) : high)];
      const margin = Math.max(0.15 * (high - low), 0.01 * high, 1e-3);
      return [Math.max(0, low - margin), high + margin];
    }
    force(top, height) {
      const [least, most] = this.range(),
                    limit = run.limit !== null && run.limit >= least && run.limit <= most ? run.limit : null;
      const pen = this.pen, sy = v => top + height * (1 - (v - least) / (most - least));
      this.frame(top, height, '|force| [N]', ticks(least, most, 5).map(v => [v, digits(v, 4)]), sy);
      this.clipped(top, height, () => {
        pen.fillStyle = faint(ink.limit, 0.13);
        for (const [a, b] of run.clamped)
          if (b >= this.view.from && a <= this.view.to)
            pen.fillRect(this.sx(a), top, Math.max(1, this.sx(b) - this.sx(a)), height);
        this.band(sy, faint(ink.bar, 0.18));
        this.dots(run.samples, r => r[1], sy, ink.reference, 2.6);
        this.curve(newest, sy, ink.newest, 1);
        this.curve(rendered, sy, ink.rendered, 1.4);
        this.curve(sent, sy, ink.sent, 1.6, [5, 3]);
        pen.lineWidth = 2.4;
        for (const [s, force, , , cause] of run.felt) {
          if (s < this.view.from || s > this.view.to) continue;
          pen.strokeStyle = ink.felt[cause];
          this.line([[this.sx(s), sy(force) - 9], [this.sx(s), sy(force) + 9]]);
        }
        pen.strokeStyle = ink.limit;
        pen.lineWidth = 1.2;
        pen.setLineDash([7, 4]);
        if (limit !== null) this.line([[this.left, sy(limit)], [this.w, sy(limit)]]);
        pen.setLineDash([]);
      });
      if (run.limit === null) return;
      pen.fillStyle = ink.limit;
      pen.textAlign = 'left';
      pen.textBaseline = 'bottom';
      pen.fillText(
          'force limit ' + digits(run.limit) + ' N' + (limit === null ? ', outside this axis' : ''),
          this.left + 6, limit === null ? top + 14 : sy(limit) - 2);
    }
    labels(top, height) {
      const pen = this.pen;
      this.clipped(top, height, () => run.labels.forEach(([s, label], i) => {
        const until = i + 1 < run.labels.length ? run.labels[i + 1][0] : end;
        pen.fillStyle = run.colours[label];
        pen.fillRect(this.sx(s), top, Math.max(0.6, this.sx(until) - this.sx(s)), height);
      }));
      pen.strokeStyle = '#8a8a8a';
      pen.lineWidth = 1;
      pen.strokeRect(this.left, top, this.w - this.left - 8, height);
      pen.fillStyle = '#3a3a3a';
      pen.textAlign = 'right';
      pen.textBaseline = 'middle';
      pen.fillText('label', this.left - 6, top + height / 2);
    }
    switches(top, height) {
      const pen = this.pen, all = run.switches,
            seen = all.filter(s => s[0] >= this.view.from && s[0] <= this.view.to);
      const most = Math.max(1e-9, ...all.map(s => s[6] || 0));
      pen.strokeStyle = ink.newest;
      pen.lineWidth = seen.length > 300 ? 0.5 : 1.2;
      for (const s of seen)
        this.line([
          [this.sx(s[0]), top + height],
          [this.sx(s[0]), top + height * (1 - 0.25 - 0.75 * (s[6] || 0) / most)]
        ]);
      pen.fillStyle = '#3a3a3a';
      pen.textAlign = 'right';
      pen.textBaseline = 'middle';
      pen.fillText('switches', this.left - 6, top + height / 2);
    }
    error(top, height) {
      const low = -4,
            high = Math.max(0, Math.ceil(Math.log10(Math.max(1e-3, ...run.samples.map(r => r[2] || 0)))));
      const sy = v =>
                top + height * (1 - (Math.max(Math.log10(Math.max(v, 1e-12)), low) - low) / (high - low)),
            marks = [];
      for (let p = low; p <= high; ++p) marks.push([Math.pow(10, p), digits(Math.pow(10, p + 2)) + ' %']);
      this.frame(top, height, 'relative error', marks, sy);
      this.clipped(top, height, () => {
        const parts = [[4, ink.approximation], [5, ink.switching], [6, ink.staleness]];
        for (const [i, colour] of parts)
          this.dots(run.samples, r => r[i] > 1e-6 ? r[i] : null, sy, colour, 1.7);
        const pen = this.pen;
        pen.lineWidth = 1.1;
        pen.strokeStyle = ink.rendered;
        this.line(run.samples.filter(r => r[2] !== null).map(r => [this.sx(r[0]), sy(r[2])]));
        pen.strokeStyle = '#6a6a6a';
        pen.setLineDash([3, 3]);
        this.line(run.samples.filter(r => r[3] > 0).map(r => [this.sx(r[0]), sy(r[2] / r[3])]));
        pen.setLineDash([]);
      });
    }
    known(top, height) {
      const most = 1.1 * Math.max(1, ...run.known.map(k => k[1])), sy = v => top + height * (1 - v / most);
      this.frame(top, height, 'states', ticks(0, most, 3).map(v => [v, digits(v, 5)]), sy);
      const points = [];
      run.known.forEach(([s, k], i) => {
        if (i) points.push([this.sx(s), sy(run.known[i - 1][1])]);
        points.push([this.sx(s), sy(k)]);
      });
      if (run.known.length) points.push([this.sx(end), sy(run.known[run.known.length - 1][1])]);
      this.clipped(top, height, () => {
        this.pen.strokeStyle = ink.rendered;
        this.pen.lineWidth = 1.5;
        this.line(points);
      });
    }
  }
