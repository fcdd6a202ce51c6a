// The charts of the chosen target against time, above each other on one canvas with one time axis; drag to zoom.

const GUTTER = 58, MARGIN = 10, HEAD = 17, AXIS = 22, GAP = 6;

class TimeCharts {
  constructor(host, ribbonHost, tracks, { onWindow, onCursor }) {
    Object.assign(this, { tracks, onWindow, onCursor, system: "si", target: -1, cursor: -1, drag: null });
    this.panels = tracks.panels;
    this.heads = document.getElementById("heads");
    this.surface = new Surface(
      host,
      "Charts of the chosen target against time. Left and right move the cursor, plus and minus zoom, 0 shows the whole track.",
      () => this.draw(),
    );
    this.ribbon = new Surface(ribbonHost, "Manoeuvre probability over the whole track; drag to move the time window.", () => this.drawRibbon());
    this.ribbon.overCanvas.tabIndex = -1;
    this.makeHeads();
    listenToCharts(this);
    listenToRibbon(this);
  }

  makeHeads() {
    this.readouts = this.panels.map((panel) => {
      const head = Object.assign(document.createElement("div"), { className: "head" });
      const what = Object.assign(document.createElement("span"), { className: "what" });
      const unit = document.createElement("span");
      what.append(Object.assign(document.createElement("b"), { textContent: panel.title }), " ", unit);
      const keys = Object.assign(document.createElement("span"), { className: "keys" });
      panel.keys().forEach(([label, colour]) => {
        const key = Object.assign(document.createElement("span"), { className: "key", title: label });
        const initials = label.includes(" ") && panel.key === "modes" ? initialsOf(label) : label;
        key.append(
          Object.assign(document.createElement("span"), { className: "long", textContent: label }),
          Object.assign(document.createElement("span"), { className: "short", textContent: initials }),
        );
        key.style.setProperty("--swatch", colour);
        keys.append(key);
      });
      const value = Object.assign(document.createElement("span"), { className: "value" });
      value.dataset.panel = panel.key;
      head.append(what, keys, value);
      this.heads.append(head);
      return { head, unit, value };
    });
  }

  choose(target) {
    this.target = target;
    const { first, time } = this.tracks;
    [this.from, this.to] = [first[target], first[target + 1]];
    const low = time[this.from], high = time[this.to - 1];
    this.whole = high > low ? [low, high] : [low - 1, high + 1];
    this.window = [...this.whole];
    this.cursor = -1;
    this.surface.schedule();
    this.ribbon.schedule();
  }

  get zoomed() {
    return this.window[0] > this.whole[0] || this.window[1] < this.whole[1];
  }

  // Rows in the window and one beyond each end, so that lines leave the panel.
  rows() {
    const { time } = this.tracks;
    const a = lastAtMost(time, this.window[0], this.from, this.to);
    const b = lastAtMost(time, this.window[1], this.from, this.to);
    return [a, Math.min(this.to, b + 2)];
  }

  setWindow(low, high) {
    const [start, end] = this.whole;
    const span = Math.min(Math.max(high - low, Math.min(1, (end - start) / 20), (end - start) * 1e-5), end - start);
    const from = Math.min(Math.max((low + high - span) / 2, start), end - span);
    this.window = [from, from + span];
    this.surface.schedule();
    this.ribbon.schedule();
    this.onWindow(this.zoomed ? this.rows() : null);
  }

  zoomBy(factor, around = (this.window[0] + this.window[1]) / 2) {
    const [low, high] = this.window;
    this.setWindow(around - (around - low) * factor, around + (high - around) * factor);
  }

  showAll() {
    this.setWindow(...this.whole);
  }

  setCursor(row) {
    if (row === this.cursor) return;
    this.cursor = row;
    this.drawOver();
  }

  x(t) {
    const [low, high] = this.window;
    return GUTTER + ((t - low) / (high - low)) * (this.surface.width - GUTTER - MARGIN);
  }

  timeAt(x) {
    const [low, high] = this.window;
    return low + ((x - GUTTER) / (this.surface.width - GUTTER - MARGIN)) * (high - low);
  }

  draw() {
    const { surface, tracks } = this;
    const ctx = surface.base;
    surface.clear(ctx);
    if (this.target < 0) return;
    const start = tracks.start[this.target];
    const axis = timeTicks(start + this.window[0], start + this.window[1], surface.width / 110, tracks.meta.clock);
    const tx = axis.ticks.map((t) => this.x(t - start));
    const [a, b] = this.rows();
    const X = (i) => this.x(tracks.time[i]);
    const each = (surface.height - AXIS) / this.panels.length;
    this.panels.forEach((panel, k) => {
      const p = { left: GUTTER, right: surface.width - MARGIN, top: k * each + HEAD, bottom: (k + 1) * each - GAP };
      panel.scale(p, a, b);
      p.y = (v) => p.bottom - ((v - p.low) / (p.high - p.low)) * (p.bottom - p.top);
      const [unit, factor] = unitOf(panel.quantity, this.system);
      drawPanelFrame(ctx, p, panel.quantity, factor, tx);
      ctx.save();
      ctx.beginPath();
      ctx.rect(p.left, p.top, p.right - p.left, p.bottom - p.top);
      ctx.clip();
      panel.draw(ctx, p, X, a, b);
      ctx.restore();
      this.readouts[k].head.style.top = `${k * each + 1}px`;
      this.readouts[k].unit.textContent = unit;
    });
    this.drawAxis(ctx, axis, tx, start);
    this.drawOver();
  }

  drawAxis(ctx, axis, tx, start) {
    const { surface, tracks } = this;
    ctx.fillStyle = theme.muted;
    ctx.font = theme.font;
    ctx.textBaseline = "top";
    axis.ticks.forEach((t, k) => {
      if (tx[k] > surface.width - 26 || (tracks.meta.clock && tx[k] < 66)) return;
      ctx.textAlign = "center";
      const date = tracks.meta.clock && axis.step >= 86400;
      const text = formatTime(t, tracks.meta.clock, { step: axis.step, date });
      ctx.fillText(date ? text.slice(0, 10) : text, tx[k], surface.height - AXIS + 4);
    });
    if (tracks.meta.clock) {
      ctx.textAlign = "left";
      ctx.fillText("UTC", 12, surface.height - AXIS + 4);
    }
  }

  drawOver() {
    const { surface, tracks, cursor, drag } = this;
    const ctx = surface.over;
    surface.clear(ctx);
    if (this.target < 0) return;
    const bottom = surface.height - AXIS;
    if (drag) {
      ctx.fillStyle = theme.accent;
      ctx.globalAlpha = 0.15;
      ctx.fillRect(Math.min(drag[0], drag[1]), 0, Math.abs(drag[1] - drag[0]), bottom);
      ctx.globalAlpha = 1;
    }
    const shown = cursor >= this.from && cursor < this.to;
    if (shown) {
      const x = Math.round(this.x(tracks.time[cursor])) + 0.5;
      ctx.strokeStyle = theme.muted;
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.moveTo(x, 0);
      ctx.lineTo(x, bottom + 3);
      ctx.stroke();
      this.drawMoment(ctx, x, bottom);
    }
    this.panels.forEach((panel, k) => {
      this.readouts[k].value.textContent = shown ? panel.read(cursor, this.system) : "";
    });
  }

  drawMoment(ctx, x, bottom) {
    const { tracks, surface, cursor } = this;
    const text = formatTime(tracks.start[this.target] + tracks.time[cursor], tracks.meta.clock, { step: tracks.meta.clock ? 1 : 0.1 });
    ctx.font = theme.font;
    const w = ctx.measureText(text).width + 10;
    const left = Math.min(Math.max(x - w / 2, 0), surface.width - w);
    ctx.fillStyle = theme.ink;
    ctx.fillRect(left, bottom + 2, w, 17);
    ctx.fillStyle = theme.panel;
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.fillText(text, left + 5, bottom + 11);
  }

  // The whole track as a strip of manoeuvre colours, the window marked on it.
  drawRibbon() {
    const { ribbon, tracks } = this;
    const ctx = ribbon.base, width = ribbon.width - GUTTER - MARGIN;
    ribbon.clear(ctx);
    if (this.target < 0) return;
    const [start, end] = this.whole;
    const X = (t) => GUTTER + ((t - start) / (end - start)) * width;
    ctx.fillStyle = theme.grid;
    ctx.fillRect(GUTTER, 4, width, 12);
    for (let i = this.from; i < this.to; i++) {
      const from = X(tracks.time[i]);
      const next = i + 1 < this.to && !tracks.fresh[i + 1] ? X(tracks.time[i + 1]) : from + 1;
      ctx.fillStyle = theme.ramp[Math.round(tracks.manoeuvring(i) * (theme.bins - 1)) || 0];
      ctx.fillRect(from, 4, Math.max(next - from, 0.6) + 0.4, 12);
    }
    const [a, b] = this.window.map(X);
    ctx.fillStyle = theme.panel;
    ctx.globalAlpha = 0.72;
    ctx.fillRect(GUTTER, 3, a - GUTTER, 14);
    ctx.fillRect(b, 3, GUTTER + width - b, 14);
    ctx.globalAlpha = 1;
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.roundRect(a - 0.5, 2.5, Math.max(b - a, 3) + 1, 15, 2);
    ctx.stroke();
  }

  nearestRow(x) {
    const { time } = this.tracks;
    const t = this.timeAt(x);
    const row = lastAtMost(time, t, this.from, this.to);
    return row + 1 < this.to && time[row + 1] - t < t - time[row] ? row + 1 : row;
  }
}
