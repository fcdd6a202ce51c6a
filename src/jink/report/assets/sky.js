// Layers of the plan view where plots had no identity: clutter map, truth, tentative tracks, plots; and whose tracks are shown.

const LAYERS = [["plots", "plots"], ["tentative", "tentative tracks"], ["clutter", "clutter map"], ["truth", "truth"]];

class SkyLayers {
  constructor(plan, tracks, arrays, host) {
    Object.assign(this, { plan, arrays, told: tracks.meta.sky, replay: null, on: {} });
    for (const [key, name] of LAYERS.filter(([key]) => this.has(key))) host.append(this.choice(key, name));
    host.hidden = false;
    plan.under.push(this);
  }

  has(key) {
    return { plots: true, tentative: this.told.tentative, clutter: this.told.map, truth: this.told.truth }[key];
  }

  choice(key, name) {
    const label = Object.assign(document.createElement("label"), { className: key });
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true, id: `layer-${key}` });
    this.on[key] = true;
    box.addEventListener("change", () => {
      this.on[key] = box.checked;
      this.plan.surface.schedule();
    });
    label.append(box, document.createElement("i"), this.text(key, name));
    return label;
  }

  text(key, name) {
    if (key === "clutter") return `${name}, 0 to ${formatNumber(this.told.map.most, 2)} per km² and scan`;
    const count = { plots: this.told.plots, tentative: this.told.tentative, truth: this.told.truth }[key];
    if (key === "truth") return `truth (${groupThousands(String(count))} targets)`;
    return `${groupThousands(String(count))} ${count === 1 ? name.slice(0, -1) : name}`;
  }

  px(x) { return this.plan.px(this.told.middle[0] + x); }
  py(y) { return this.plan.py(this.told.middle[1] + y); }

  // Below the tracks.
  draw(ctx) {
    if (this.on.clutter) this.drawMap(ctx);
    if (this.on.truth) this.drawLines(ctx, "truth", theme.good, 5, [], 0.4);
    if (this.on.plots) this.drawPlots(ctx, 0, this.arrays.plot_x.length, 1.8, this.plan.dimmed ? 0.45 : 0.75);
    if (this.on.tentative) this.drawLines(ctx, "tentative", theme.second, 1.5, [4, 3], 0.9);
  }

  drawMap(ctx) {
    const { columns, sides: [w, h], corner, most } = this.told.map;
    const { plan, arrays } = this;
    const { width, height } = plan.surface;
    ctx.fillStyle = theme.clutter;
    for (let k = 0; k < arrays.clutter.length; k++) {
      const x = corner[0] + w * (k % columns), y = corner[1] + h * Math.floor(k / columns);
      // whole pixels, so that cells neither overlap nor leave seams
      const [x0, x1, y0, y1] = [plan.px(x), plan.px(x + w), plan.py(y + h), plan.py(y)].map(Math.round);
      if (!(arrays.clutter[k] > 0) || x1 < 0 || x0 > width || y1 < 0 || y0 > height) continue;
      ctx.globalAlpha = (0.5 * arrays.clutter[k]) / most;
      ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
    }
    ctx.globalAlpha = 1;
  }

  drawPlots(ctx, from, to, size, alpha) {
    const { plot_x: X, plot_y: Y } = this.arrays;
    const { width, height } = this.plan.surface;
    ctx.fillStyle = theme.dot;
    ctx.globalAlpha = alpha;
    for (let i = from; i < to; i++) {
      const x = this.px(X[i]), y = this.py(Y[i]);
      if (x > -3 && x < width + 3 && y > -3 && y < height + 3) ctx.fillRect(x - size / 2, y - size / 2, size, size);
    }
    ctx.globalAlpha = 1;
  }

  // Lines of the tracks or targets `name`, each from its entry in `first` to the next; a lone point is a ring.
  drawLines(ctx, name, colour, width, dash, alpha) {
    const X = this.arrays[`${name}_x`], Y = this.arrays[`${name}_y`], first = this.arrays[`${name}_first`];
    ctx.beginPath();
    first.forEach((from, k) => {
      const to = k + 1 < first.length ? first[k + 1] : X.length;
      if (to - from === 1) {
        ctx.moveTo(this.px(X[from]) + 3, this.py(Y[from]));
        ctx.arc(this.px(X[from]), this.py(Y[from]), 3, 0, 2 * Math.PI);
        return;
      }
      for (let i = from; i < to; i++) ctx[i > from ? "lineTo" : "moveTo"](this.px(X[i]), this.py(Y[i]));
    });
    Object.assign(ctx, { strokeStyle: colour, lineWidth: width, globalAlpha: alpha, lineJoin: "round", lineCap: dash.length ? "butt" : "round" });
    ctx.setLineDash(dash);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }

  // Above the tracks: the plots of the scan at the replay's moment.
  over(replay) {
    const draw = (ctx) => {
      if (replay.moment === null || !this.on.plots) return;
      const time = this.arrays.plot_time, now = replay.moment - this.told.begin;
      let to = time.length ? lastAtMost(time, now + 1e-3, 0, time.length) : 0;
      if (time[to] > now + 1e-3) return;
      let from = to;
      while (from > 0 && time[from - 1] > time[to] - 0.5 * this.told.period) from--;
      this.drawPlots(ctx, from, to + 1, 4, 1);
    };
    return { draw };
  }
}

// Several trackers on one sky: the tracks of one are shown at a time.
function chooseSeries(page, { series }, { sky, targets }) {
  const choice = byId("series");
  choice.append(...sky.series.map((name, k) => new Option(name, String(k))));
  byId("series-choice").hidden = false;
  const show = () => {
    const of = Number(choice.value);
    page.plan.show((t) => series[t] === of);
    page.table.only = (t) => series[t] === of;
    page.table.order();
    const mine = [...series.keys()].filter((t) => series[t] === of);
    byId("target-count").textContent = groupThousands(String(mine.length));
    const busy = (t) => (targets.manoeuvring[t] ?? 0) * targets.rows[t];
    if (mine.length && series[page.plan.chosen] !== of) {
      page.choose(mine.reduce((a, b) => (busy(b) > busy(a) ? b : a)), { zoom: false, remember: false });
    }
  };
  // the address may name a target of another tracker
  choice.value = String(readAddress(location.hash).target === undefined ? 0 : series[page.plan.chosen]);
  choice.addEventListener("change", show);
  show();
}
