// The tracks in three dimensions, where heights are known: orthographic, over the same place and scale as the plan view.

const TILT = [0.05, Math.PI / 2]; // from the side to straight down
const STRETCHES = [1, 2, 5, 10, 20, 50];

class SpaceView {
  // others: controls of the plan view that do nothing here
  constructor(plan, heights, button, others) {
    Object.assign(this, { plan, heights, button, others, turn: -0.5, tilt: 0.45 });
    const known = heights.filter((z) => z === z).sort();
    [this.low, this.high] = [0.002, 0.995].map((share) => known[Math.floor(share * known.length)]); // without gross errors
    button.hidden = !(this.high - this.low > 1);
    button.addEventListener("click", () => this.switch(!plan.instead));
  }

  // The canvas over the plan view, made when it is first wanted.
  make() {
    const { host } = this.plan.surface;
    this.host = Object.assign(document.createElement("div"), { className: "surface space" });
    host.insertBefore(this.host, host.querySelector(".legend"));
    this.surface = new Surface(
      this.host,
      "Tracks in three dimensions. Drag or the arrow keys turn the view, shift and drag move it, plus and minus zoom.",
      () => this.draw(),
    );
    this.listen();
  }

  switch(on) {
    const { plan } = this;
    if (!this.surface) this.make();
    plan.instead = on ? this : null;
    this.host.hidden = !on;
    this.button.setAttribute("aria-pressed", String(on));
    for (const control of this.others) control.disabled = on;
    plan.tip.hidden = true;
    this.surface.resize();
    (on ? this : plan).surface.schedule();
  }

  // Where a point (m) is drawn; the ground is the lowest height.
  place(x, y, z) {
    const { view } = this.plan;
    const dx = (x - view.x) * view.aspect, dy = y - view.y;
    const across = dx * Math.cos(this.turn) + dy * Math.sin(this.turn), away = dy * Math.cos(this.turn) - dx * Math.sin(this.turn);
    const up = away * Math.sin(this.tilt) + (z - this.low) * this.stretch * Math.cos(this.tilt);
    return [this.surface.width / 2 + across * view.k, this.base - up * view.k];
  }

  // Heights are stretched until they take a third of the picture, by a number that the picture names.
  scale() {
    const { height } = this.surface;
    const wanted = (0.33 * height) / ((this.high - this.low) * this.plan.view.k);
    this.stretch = STRETCHES.filter((times) => times <= wanted).pop() || 1;
    this.base = height * (0.5 + 0.16 * Math.cos(this.tilt));
  }

  draw() {
    const { surface, plan } = this;
    const ctx = surface.base, { first, names } = plan.tracks;
    surface.clear(ctx);
    surface.clear(surface.over);
    this.scale();
    this.drawGround(ctx);
    const paths = [];
    names.forEach((_, t) => t !== plan.chosen && Number.isFinite(plan.boxes[t][0]) && this.add(paths, first[t], first[t + 1]));
    ctx.globalAlpha = plan.dimmed ? 0.25 : 0.8;
    strokePaths(ctx, paths, 1.3);
    ctx.globalAlpha = 1;
    if (plan.chosen >= 0) this.drawChosen(ctx);
    drawScaleBar(ctx, plan);
    ctx.textAlign = "left";
    ctx.textBaseline = "top";
    ctx.fillStyle = theme.muted;
    ctx.fillText(this.stretch > 1 ? `heights × ${this.stretch}` : "heights to scale", 10, 8);
    this.drawCursor(surface.over);
  }

  drawGround(ctx) {
    const [x0, y0, x1, y1] = this.plan.boxes.reduce(joinBoxes, NO_BOX);
    const xs = niceTicks(x0, x1, 8), ys = niceTicks(y0, y1, 8);
    const line = (a, b, c, d) => {
      ctx.moveTo(...this.place(a, b, this.low));
      ctx.lineTo(...this.place(c, d, this.low));
    };
    const [left, right] = [Math.min(x0, xs.ticks[0]), Math.max(x1, xs.ticks.at(-1))], [below, above] = [Math.min(y0, ys.ticks[0]), Math.max(y1, ys.ticks.at(-1))];
    ctx.strokeStyle = theme.grid;
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (const x of xs.ticks) line(x, below, x, above);
    for (const y of ys.ticks) line(left, y, right, y);
    ctx.stroke();
    ctx.font = theme.font;
    ctx.fillStyle = theme.muted;
    [ctx.textAlign, ctx.textBaseline] = ["center", "middle"];
    ctx.fillText("N", ...this.place((left + right) / 2, above + 0.03 * (above - below), this.low));
  }

  // Adds rows [from, to) to one path per colour bin; points closer than most of a pixel are skipped.
  add(paths, from, to) {
    const { tracks, bins } = this.plan;
    const { X, Y, fresh, coasting } = tracks;
    let lx = NaN, ly = NaN, at = -1;
    for (let i = from; i < to; i++) {
      const [x, y] = this.place(X[i], Y[i], this.heights[i]);
      const bin = bins[i] + (coasting[i] ? theme.bins : 0);
      if (i > from && bin === at && i < to - 1 && Math.abs(x - lx) + Math.abs(y - ly) < 0.8) continue;
      if (!fresh[i] && lx === lx && x === x) {
        const path = paths[bin] || (paths[bin] = new Path2D());
        if (at !== bin) path.moveTo(lx, ly);
        path.lineTo(x, y);
        at = bin;
      } else {
        at = -1;
      }
      [lx, ly] = [x, y];
    }
  }

  // The chosen track, a curtain down to the ground, and its shadow there.
  drawChosen(ctx) {
    const { tracks, chosen, window: rows } = this.plan;
    const { X, Y, first } = tracks;
    const [from, to] = rows || [first[chosen], first[chosen + 1]];
    const step = Math.max(1, Math.round((to - from) / 120));
    ctx.strokeStyle = theme.accent;
    ctx.lineWidth = 1;
    ctx.globalAlpha = 0.35;
    ctx.beginPath();
    for (let i = from; i < to; i += step) {
      if (this.heights[i] !== this.heights[i]) continue;
      ctx.moveTo(...this.place(X[i], Y[i], this.low));
      ctx.lineTo(...this.place(X[i], Y[i], this.heights[i]));
    }
    ctx.stroke();
    ctx.globalAlpha = 1;
    const paths = [];
    this.add(paths, from, to);
    strokePaths(ctx, paths, 2.4);
  }

  drawCursor(ctx) {
    const { tracks, cursor } = this.plan;
    if (cursor < 0 || this.heights[cursor] !== this.heights[cursor]) return;
    drawEnd(ctx, ...this.place(tracks.X[cursor], tracks.Y[cursor], this.heights[cursor]), true);
  }

  orbit(dx, dy) {
    this.turn += dx * 0.008;
    this.tilt = Math.min(TILT[1], Math.max(TILT[0], this.tilt + dy * 0.006));
    this.surface.schedule();
  }

  // The target whose line is nearest to a place on the picture, if it is near.
  pick(px, py, reach) {
    const { tracks, boxes } = this.plan;
    let best = reach, found = -1;
    for (let t = 0; t < tracks.names.length; t++) {
      if (!Number.isFinite(boxes[t][0])) continue;
      for (let i = tracks.first[t]; i < tracks.first[t + 1]; i++) {
        const [x, y] = this.place(tracks.X[i], tracks.Y[i], this.heights[i]);
        const off = Math.hypot(x - px, y - py);
        if (off < best) [best, found] = [off, t];
      }
    }
    return found;
  }

  listen() {
    const { plan, surface } = this;
    const canvas = surface.overCanvas;
    const middle = () => [surface.width / 2, surface.height / 2];
    let held = null, moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      [held, moved] = [surface.at(event), 0];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      const [x, y] = surface.at(event), [dx, dy] = [x - held[0], y - held[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      held = [x, y];
      if (event.shiftKey) plan.pan(dx, dy);
      else this.orbit(dx, dy);
    });
    canvas.addEventListener("pointerup", (event) => {
      const found = held && moved < 4 ? this.pick(...surface.at(event), event.pointerType === "touch" ? 24 : 14) : -1;
      held = null;
      if (found >= 0) plan.onChoose(found);
    });
    canvas.addEventListener("pointercancel", () => { held = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      plan.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0018)), ...middle());
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const keys = {
        ArrowLeft: () => this.orbit(-20, 0), ArrowRight: () => this.orbit(20, 0), ArrowUp: () => this.orbit(0, 20), ArrowDown: () => this.orbit(0, -20),
        "+": () => plan.zoom(1.4, ...middle()), "=": () => plan.zoom(1.4, ...middle()), "-": () => plan.zoom(1 / 1.4, ...middle()),
        0: () => plan.fitAll(), Enter: () => plan.fitChosen(), Escape: () => this.switch(false),
      };
      if (event.ctrlKey || event.metaKey || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
  }
}
