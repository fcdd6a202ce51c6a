// The plan view: all tracks, pan and zoom, choosing by click, and the cursor shared with the charts.

class PlanView {
  constructor(host, tracks, { onChoose, onCursor }) {
    Object.assign(this, { tracks, onChoose, onCursor, frame: tracks.meta.frame, system: "si" });
    this.gatedCode = tracks.meta.statuses.indexOf("gated");
    this.view = { x: 0, y: 0, k: 1, aspect: 1 };
    this.chosen = -1;
    this.window = null;
    this.cursor = -1;
    this.dimmed = false;
    this.boxes = this.bounds();
    this.surface = new Surface(
      host,
      "Plan view of the tracks. Arrow keys pan, plus and minus zoom, 0 shows all targets, Enter the chosen one.",
      () => this.draw(),
    );
    this.tip = document.getElementById("tip");
    this.measure = new Measure(this);
    this.overlays = [];
    this.under = []; // what is drawn below the tracks
    this.tiles = tracks.meta.tiles && this.frame ? new Tiles(this, tracks.meta.tiles) : null;
    listenToPlan(this);
  }

  // Only targets of which `wanted(t)` is true are drawn and chosen; the others have no place.
  show(wanted) {
    this.boxes = this.bounds().map((box, t) => (wanted(t) ? box : NO_BOX));
    this.surface.schedule();
  }

  px(x) { return this.surface.width / 2 + (x - this.view.x) * this.view.k * this.view.aspect; }
  py(y) { return this.surface.height / 2 - (y - this.view.y) * this.view.k; }
  metres(px, py) {
    const { x, y, k, aspect } = this.view;
    return [x + (px - this.surface.width / 2) / (k * aspect), y - (py - this.surface.height / 2) / k];
  }

  bounds() {
    const { X, Y, first, names } = this.tracks;
    return names.map((_, t) => boxOf(X, Y, first[t], first[t + 1]));
  }

  fit(box, { smooth = true } = {}) {
    if (!Number.isFinite(box[0])) return;
    this.animation && (this.animation.cancelled = true);
    this.fitted = box;
    const target = this.fittingView(box);
    const from = { ...this.view };
    const steps = (f) => {
      this.view = {
        x: from.x + f * (target.x - from.x), y: from.y + f * (target.y - from.y),
        k: from.k * (target.k / from.k) ** f, aspect: from.aspect + f * (target.aspect - from.aspect),
      };
      this.moving = f < 1;
      this.surface.schedule();
    };
    if (smooth) this.animation = animate(260, steps);
    else steps(1);
  }

  fittingView([x0, y0, x1, y1]) {
    const { width, height } = this.surface;
    const x = (x0 + x1) / 2, y = (y0 + y1) / 2;
    let aspect = 1;
    if (this.frame) {
      const here = this.frame.latitude * (Math.PI / 180) + y / this.frame.radius;
      aspect = Math.max(0.05, Math.cos(here)) / Math.cos(this.frame.latitude * (Math.PI / 180));
    }
    const least = Math.max(x1 - x0, y1 - y0) > 0 ? 1 : 1000; // metres; a lone point is shown with its surroundings
    const k = Math.min((width - 70) / Math.max((x1 - x0) * aspect, least), (height - 90) / Math.max(y1 - y0, least));
    return { x, y, k, aspect };
  }

  fitAll(options) {
    this.dimmed = false;
    this.fit(this.boxes.reduce(joinBoxes, NO_BOX), options);
  }

  fitChosen(options) {
    if (this.chosen < 0) return;
    this.dimmed = true;
    const { X, Y } = this.tracks;
    this.fit(this.window ? boxOf(X, Y, ...this.window) : this.boxes[this.chosen], options);
  }

  choose(target) {
    this.chosen = target;
    this.window = null;
    this.cursor = -1;
    this.surface.schedule();
  }

  // Rows [from, to) in the charts' time window, null for the whole track.
  setWindow(rows) {
    this.window = rows;
    this.surface.schedule();
  }

  setCursor(row) {
    if (row === this.cursor) return;
    this.cursor = row;
    this.drawOver();
  }

  // `share(i)` in 0..1, or NaN, gives each row its colour.
  colourBy(share) {
    const n = this.tracks.X.length;
    this.bins = new Uint8Array(n);
    for (let i = 0; i < n; i++) {
      const u = share(i);
      this.bins[i] = u === u ? Math.round(Math.min(1, Math.max(0, u)) * (theme.bins - 1)) : 0;
    }
    this.surface.schedule();
  }

  // Redraws; where that is slow, moves the last picture about first and redraws when the hand rests.
  draw() {
    if (this.instead) this.instead.surface.schedule();
    const size = `${this.surface.width}x${this.surface.height}`;
    if (this.sizedFor !== size) {
      this.sizedFor = size;
      this.picture = null;
      if (this.fitted) this.view = this.fittingView(this.fitted);
    }
    clearTimeout(this.later);
    if (this.instead) return;
    if (this.moving && this.picture && this.cost > 20) {
      this.drawPicture();
      this.later = setTimeout(() => this.drawAll(), 120);
    } else {
      this.drawAll();
    }
    this.drawOver();
  }

  drawPicture() {
    const { view, picture, surface } = this;
    const ctx = surface.base, { width, height } = surface;
    const sy = view.k / picture.view.k, sx = (view.k * view.aspect) / (picture.view.k * picture.view.aspect);
    surface.clear(ctx);
    this.drawGround(ctx);
    ctx.globalAlpha = this.faded ? 0.3 : 1;
    ctx.drawImage(picture.canvas, this.px(picture.view.x) - (width / 2) * sx, this.py(picture.view.y) - (height / 2) * sy, width * sx, height * sy);
    ctx.globalAlpha = 1;
    drawScaleBar(ctx, this);
  }

  drawGround(ctx) {
    if (this.tiles) this.tiles.draw(ctx);
    else drawWorld(ctx, this);
    drawGraticule(ctx, this);
    drawSites(ctx, this);
  }

  drawAll() {
    const begin = performance.now();
    const { surface } = this;
    const { baseCanvas, base, ratio } = surface;
    const canvas = this.picture?.canvas || document.createElement("canvas");
    [canvas.width, canvas.height] = [baseCanvas.width, baseCanvas.height];
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawTracks(ctx);
    this.picture = { canvas, view: { ...this.view } };
    this.moving = false;
    surface.clear(base);
    this.drawGround(base);
    base.globalAlpha = this.faded ? 0.3 : 1;
    base.drawImage(canvas, 0, 0, surface.width, surface.height);
    base.globalAlpha = 1;
    drawScaleBar(base, this);
    this.cost = performance.now() - begin;
  }

  drawTracks(ctx) {
    const { tracks, boxes } = this;
    const { first, names } = tracks;
    for (const layer of this.under) layer.draw(ctx);
    const seen = names.map((_, t) => t).filter((t) => t !== this.chosen && this.visible(boxes[t]));
    const rows = seen.reduce((sum, t) => sum + first[t + 1] - first[t], 0);
    ctx.fillStyle = theme.dot;
    ctx.globalAlpha = this.dimmed ? 0.25 : 0.55;
    for (const t of seen) drawDots(ctx, this, first[t], first[t + 1], rows > 2e4 ? 1 : 1.6, null);
    const paths = [];
    for (const t of seen) addTrack(paths, this, first[t], first[t + 1]);
    ctx.globalAlpha = this.dimmed ? 0.28 : 1;
    strokePaths(ctx, paths, 1.4);
    ctx.globalAlpha = 1;
    if (this.chosen >= 0) this.drawChosen(ctx);
  }

  drawChosen(ctx) {
    const { first, X, Y } = this.tracks;
    const from = first[this.chosen], to = first[this.chosen + 1];
    const [a, b] = this.window || [from, to];
    if (!this.dimmed) drawGlow(ctx, this, from, to);
    ctx.fillStyle = theme.dot;
    const gated = [];
    const size = this.dotSize(from, to);
    ctx.globalAlpha = this.window ? 0.3 : 1;
    drawDots(ctx, this, from, to, size, gated);
    ctx.globalAlpha = 1;
    if (this.window) drawDots(ctx, this, a, b, size, null);
    const rest = [], inside = [];
    if (this.window) {
      addTrack(rest, this, from, to);
      ctx.globalAlpha = 0.25;
      strokePaths(ctx, rest, 1.8);
      ctx.globalAlpha = 1;
    }
    addTrack(inside, this, a, b);
    strokePaths(ctx, inside, this.dimmed ? 2.2 : 1.9);
    if (this.dimmed) drawGated(ctx, gated);
    const known = (i) => X[i] === X[i];
    let begin = from, end = to - 1;
    while (begin < end && !known(begin)) begin++;
    while (end > begin && !known(end)) end--;
    if (known(begin)) drawEnd(ctx, this.px(X[begin]), this.py(Y[begin]), false);
    if (end > begin) drawEnd(ctx, this.px(X[end]), this.py(Y[end]), true);
  }

  // Larger dots where they stand apart, small ones where they run together.
  dotSize(from, to) {
    if (!this.dimmed) return 1.5;
    const [x0, y0, x1, y1] = this.boxes[this.chosen];
    const apart = (Math.hypot(x1 - x0, y1 - y0) * this.view.k) / (to - from);
    return Math.min(5, Math.max(2.6, apart * 0.7));
  }

  visible([x0, y0, x1, y1]) {
    const { width, height } = this.surface;
    return this.px(x1) > -10 && this.px(x0) < width + 10 && this.py(y0) > -10 && this.py(y1) < height + 10;
  }

  drawOver() {
    const { surface, tracks, cursor } = this;
    if (this.instead) this.instead.surface.schedule();
    surface.clear(surface.over);
    for (const overlay of [...this.overlays, this.measure]) overlay.draw(surface.over);
    if (cursor < 0 || tracks.X[cursor] !== tracks.X[cursor]) return;
    const ctx = surface.over, x = this.px(tracks.X[cursor]), y = this.py(tracks.Y[cursor]);
    ctx.beginPath();
    ctx.arc(x, y, 6, 0, 2 * Math.PI);
    ctx.strokeStyle = theme.halo;
    ctx.lineWidth = 4.5;
    ctx.stroke();
    ctx.strokeStyle = theme.accent;
    ctx.lineWidth = 2.25;
    ctx.stroke();
  }

  // Nearest drawn row within `reach` pixels: [target, row] or null. The chosen track wins a near tie.
  pick(x, y, reach = 14) {
    const { first, X, Y, fresh, names } = this.tracks;
    let best = reach * reach, found = null;
    for (let t = 0; t < names.length; t++) {
      const [x0, y0, x1, y1] = this.boxes[t];
      if (this.px(x0) > x + reach || this.px(x1) < x - reach || this.py(y0) < y - reach || this.py(y1) > y + reach) continue;
      const bias = t === this.chosen ? 0.6 : 1;
      for (let i = first[t]; i < first[t + 1]; i++) {
        const alone = fresh[i] || X[i - 1] !== X[i - 1];
        const bx = this.px(X[i]), by = this.py(Y[i]);
        const [d, f] = alone ? [(bx - x) ** 2 + (by - y) ** 2, 1] : nearestOnSegment(x, y, this.px(X[i - 1]), this.py(Y[i - 1]), bx, by);
        if (d * bias < best) {
          best = d * bias;
          found = [t, f < 0.5 ? i - 1 : i];
        }
      }
    }
    return found;
  }

  pan(dx, dy) {
    this.stopFollowing();
    this.view.x -= dx / (this.view.k * this.view.aspect);
    this.view.y += dy / this.view.k;
    this.surface.schedule();
  }

  zoom(factor, x, y) {
    this.stopFollowing();
    const [mx, my] = this.metres(x, y);
    this.view.k = Math.min(Math.max(this.view.k * factor, 1e-6), 1000);
    const [nx, ny] = this.metres(x, y);
    this.view.x += mx - nx;
    this.view.y += my - ny;
    this.surface.schedule();
  }

  stopFollowing() {
    this.animation && (this.animation.cancelled = true);
    this.fitted = null;
    this.moving = true;
  }

  hover(x, y) {
    const hit = this.pick(x, y);
    this.tip.hidden = !hit;
    this.onCursor(hit && hit[0] === this.chosen ? hit[1] : -1);
    if (!hit) return;
    this.tip.replaceChildren(...this.describe(...hit));
    const { width, height } = this.surface;
    this.tip.style.left = `${Math.min(x + 14, Math.max(0, width - this.tip.offsetWidth - 4))}px`;
    this.tip.style.top = `${y + 18 + this.tip.offsetHeight > height ? y - 12 - this.tip.offsetHeight : y + 16}px`;
  }

  describe(target, row) {
    const name = Object.assign(document.createElement("b"), { textContent: this.tracks.names[target] });
    return [name, `\n${this.tracks.describe(target, row, this.system)}`];
  }
}
