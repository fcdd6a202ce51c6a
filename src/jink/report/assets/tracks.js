// The tracks page: joins data, plan view, charts and table.

const byId = (id) => document.getElementById(id);

// Rows that are drawn dotted: nothing is measured for long, or the track is not confirmed.
function loose({ coasting, tentative }) {
  return tentative ? coasting.map((c, i) => c | tentative[i]) : coasting;
}

function makeTracks(meta, arrays) {
  const n = arrays.time.length, T = meta.targets.name.length;
  const first = Int32Array.from(arrays.first);
  const X = new Float64Array(n), Y = new Float64Array(n), MX = new Float64Array(n), MY = new Float64Array(n);
  for (let t = 0; t < T; t++) {
    for (let i = first[t]; i < first[t + 1]; i++) {
      X[i] = arrays.centre_x[t] + arrays.east[i];
      Y[i] = arrays.centre_y[t] + arrays.north[i];
      MX[i] = arrays.centre_x[t] + arrays.measured_east[i];
      MY[i] = arrays.centre_y[t] + arrays.measured_north[i];
    }
  }
  const manoeuvring = (i) => (arrays.manoeuvring[i] === 255 ? NaN : arrays.manoeuvring[i] / 254);
  const tracks = {
    meta, arrays, first, X, Y, MX, MY, manoeuvring, world: makeWorld(arrays), names: meta.targets.name, time: arrays.time, start: arrays.start,
    status: arrays.status, fresh: arrays.fresh, coasting: loose(arrays),
    updated: arrays.status.map((code) => Number(code === meta.statuses.indexOf("updated"))),
  };
  tracks.panels = makePanels(meta, arrays, tracks);
  tracks.describe = (target, row, system) => {
    const lines = [formatTime(tracks.start[target] + tracks.time[row], meta.clock, { date: true, step: meta.clock ? 1 : 0.1 })];
    for (const panel of tracks.panels.filter((p) => ["existence", "speed", "course", "height", "turn_rate"].includes(p.key))) {
      lines.push(`${panel.title.split(",")[0]}  ${panel.read(row, system)}`);
    }
    lines.push(`Manoeuvring  ${formatShare(manoeuvring(row))}`, `Status  ${meta.statuses[tracks.status[row]]}`);
    return lines.join("\n");
  };
  return tracks;
}

// Ways to colour the plan view: [name, share of the ramp at row i, low and high label].
function colourings(meta, arrays, tracks) {
  const ways = [{ name: "manoeuvre probability", share: tracks.manoeuvring, low: () => "0", high: () => "1" }];
  for (const panel of meta.panels.filter((p) => ["speed", "height", "climb_rate"].includes(p.key))) {
    const values = arrays[panel.curves[0].value];
    const sorted = values.filter((v) => v === v).sort();
    const low = sorted[Math.floor(0.01 * sorted.length)], high = sorted[Math.ceil(0.99 * sorted.length) - 1];
    // one row in a hundred lies beyond each end; what is nothing beside the range is rounding
    const label = (sign, v) => (system) => {
      const [unit, factor] = unitOf(panel.quantity, system);
      return `${sign} ${formatNumber(Math.abs(v) < 1e-3 * (high - low) ? 0 : v * factor, 3)} ${unit}`;
    };
    const share = (i) => (high > low ? (values[i] - low) / (high - low) : 0);
    ways.push({ name: panel.title.toLowerCase(), share, low: label("≤", low), high: label("≥", high) });
  }
  const existence = meta.panels.find((p) => p.key === "existence");
  if (existence) {
    const values = arrays[existence.curves[0].value];
    ways.push({ name: "existence", share: (i) => values[i], low: () => "0", high: () => "1" });
  }
  return ways;
}

function tableColumns(meta, system) {
  const t = meta.targets;
  const measured = (title, values, quantity, hint) => ({
    title, values, hint, numeric: true, unit: () => unitOf(quantity, system())[0],
    text: (i) => formatNumber(values[i] === null ? NaN : values[i] * unitOf(quantity, system())[1], 3),
  });
  const share = (title, values, hint, more) => ({
    title, values, hint, numeric: true, text: (i) => formatShare(values[i] ?? NaN, values[i] > 0 && values[i] < 0.0995 ? 1 : 0), ...more,
  });
  const off = (i) => {
    const s = t.nis_inside[i], n = t.compared[i];
    return s !== null && Math.abs(s - 0.95) > Math.max(0.03, 3 * Math.sqrt((0.95 * 0.05) / n));
  };
  return [
    { title: "Target", values: t.name, text: (i) => t.name[i] },
    { title: "Duration", values: t.duration, numeric: true, text: (i) => formatDuration(t.duration[i]) },
    { title: "Rows", values: t.rows, numeric: true, text: (i) => groupThousands(String(t.rows[i])) },
    ...(meta.sky ? [share("Existence", t.existence, "Mean probability over its rows that there is a target", { meter: true })] : []),
    share("Manoeuvring", t.manoeuvring, "Share of rows with a manoeuvre probability above one half", { meter: true }),
    measured("Max speed", t.max_speed, "speed", "Among rows whose sd has settled"),
    measured("Max turn", t.max_turn_rate, "turn_rate", "Among rows whose sd has settled"),
    measured("Max accel.", t.max_acceleration, "acceleration", "Horizontal, among rows whose sd has settled"),
    share("Gated", t.gated, "Share of rows rejected by the filter"),
    share("NIS inside", t.nis_inside, "Share of NIS inside its 95 % band; marked where far from 95 %", { flag: off, unit: () => "95 % band" }),
  ];
}

// What tests (and the console) may ask of the page.
function pageHandle(tracks, plan, charts, replay) {
  return {
    whereIs(name) {
      const t = tracks.names.indexOf(name);
      const row = (tracks.first[t] + tracks.first[t + 1]) >> 1;
      return [plan.px(tracks.X[row]), plan.py(tracks.Y[row])];
    },
    csv: (name) => rowsAsCsv(tracks, tracks.names.indexOf(name), tracks.first[tracks.names.indexOf(name)], tracks.first[tracks.names.indexOf(name) + 1]),
    measured: () => plan.measure.ends && plan.measure.result(),
    world: () => tracks.world?.kind.length ?? 0,
    moment: () => replay.moment,
    timeWindow: () => [...charts.window, ...charts.whole],
    view: () => ({ ...plan.view }),
    redraw: () => plan.drawAll(),
  };
}

function startPage({ meta, arrays }) {
  readTheme();
  const tracks = makeTracks(meta, arrays);
  if (tracks.names.length) new TracksPage(meta, arrays, tracks);
  else byId("facts").textContent = "The table of tracks has no rows.";
  document.documentElement.dataset.ready = "yes";
}

class TracksPage {
  constructor(meta, arrays, tracks) {
    Object.assign(this, { meta, tracks, system: "si", ways: colourings(meta, arrays, tracks) });
    this.way = this.ways[0];
    const onChoose = (target) => this.choose(target);
    const onCursor = (row) => {
      this.plan.setCursor(row);
      this.charts.setCursor(row);
    };
    this.plan = new PlanView(byId("plan"), tracks, { onChoose, onCursor });
    this.charts = new TimeCharts(byId("charts"), byId("ribbon"), tracks, { onCursor, onWindow: (rows) => this.follow(rows) });
    const control = (name) => byId(`replay-${name}`);
    this.replay = new Replay(this.plan, tracks, {
      play: control("play"), slider: control("slider"), text: control("text"), speed: control("speed"), off: control("off"),
    });
    this.plan.overlays.push(this.replay, new Names(this.plan, this.replay, byId("names")));
    const height = meta.panels.find((p) => p.key === "height");
    if (height) {
      const flat = ["measure", "names", "replay-play", "replay-slider"].map(byId);
      this.space = new SpaceView(this.plan, arrays[height.curves[0].value], byId("space"), flat);
    }
    this.table = new SortableTable(byId("list"), tableColumns(meta, () => this.system), { onChoose });
    byId("target-count").textContent = groupThousands(String(tracks.names.length));
    this.wire();
    this.colour();
    this.open();
    if (meta.sky) this.showSky();
    window.jinkPage = pageHandle(tracks, this.plan, this.charts, this.replay);
  }

  showSky() {
    const { meta, tracks, plan, replay } = this;
    plan.overlays.unshift(new SkyLayers(plan, tracks, tracks.arrays, byId("layers")).over(replay));
    if (meta.sky.series) chooseSeries(this, tracks.arrays, meta);
  }

  // What the address names, else the target that manoeuvred longest, with all targets in view.
  open() {
    const asked = readAddress(location.hash);
    const wanted = asked.target === undefined ? -1 : this.tracks.names.indexOf(asked.target);
    const named = wanted >= 0;
    if (UNITS[asked.units]) {
      byId("units").value = asked.units;
      this.useUnits(asked.units);
    }
    this.choose(named ? wanted : this.meta.liveliest, { zoom: named, smooth: false, remember: false });
    if (!named) this.plan.fitAll({ smooth: false });
    const start = this.tracks.start[this.plan.chosen];
    if (named && asked.to > asked.from) this.charts.setWindow(asked.from - start, asked.to - start);
  }

  // The address leads here again: target, time window, units.
  remember() {
    const { charts, tracks, plan, system } = this;
    const start = tracks.start[plan.chosen];
    const [from, to] = charts.zoomed ? charts.window.map((t) => start + t) : [undefined, undefined];
    writeAddress({ target: tracks.names[plan.chosen], from, to, units: system === "si" ? undefined : system });
  }

  choose(target, { zoom = true, smooth = true, remember = true } = {}) {
    const { tracks, meta } = this;
    this.plan.choose(target);
    this.charts.choose(target);
    this.table.choose(target);
    byId("chosen").textContent = tracks.names[target];
    byId("time-all").disabled = true;
    const start = formatTime(tracks.start[target], meta.clock, { date: !meta.same_day });
    byId("facts").textContent = `${start} · ${formatDuration(meta.targets.duration[target])}`;
    document.documentElement.dataset.chosen = tracks.names[target];
    if (zoom) this.plan.fitChosen({ smooth });
    if (remember) this.remember();
  }

  follow(rows) {
    this.plan.setWindow(rows);
    byId("time-all").disabled = rows === null;
    if (byId("follow").checked) this.plan.fitChosen({ smooth: false });
    this.remember();
  }

  colour() {
    this.plan.colourBy(this.way.share);
    byId("legend-title").textContent = this.way.name;
    byId("legend-low").textContent = this.way.low(this.system);
    byId("legend-high").textContent = this.way.high(this.system);
  }

  useUnits(system) {
    this.system = this.plan.system = this.charts.system = system;
    this.table.drawHead();
    this.table.order();
    this.table.choose(this.table.chosen, { scroll: false });
    this.colour();
    this.charts.surface.schedule();
    this.plan.surface.schedule();
  }

  saveRows() {
    const { tracks, plan } = this;
    const { chosen, window: rows } = plan;
    const text = rowsAsCsv(tracks, chosen, ...(rows || [tracks.first[chosen], tracks.first[chosen + 1]]));
    saveAs(`${fileName(tracks.names[chosen])}.csv`, new Blob([text], { type: "text/csv" }));
  }

  toggleMeasure() {
    const { measure } = this.plan;
    measure.switch(!measure.on);
    byId("measure").setAttribute("aria-pressed", String(measure.on));
  }

  wire() {
    const { plan, charts, table } = this;
    byId("colour").append(...this.ways.map(({ name }) => new Option(name)));
    byId("colour").addEventListener("change", (event) => {
      this.way = this.ways[event.target.selectedIndex];
      this.colour();
    });
    byId("units").addEventListener("change", (event) => {
      this.useUnits(event.target.value);
      this.remember();
    });
    byId("find").addEventListener("input", (event) => {
      table.find(event.target.value.trim());
      table.choose(table.chosen);
    });
    const centre = (factor) => plan.zoom(factor, plan.surface.width / 2, plan.surface.height / 2);
    const clicks = {
      "plan-all": () => plan.fitAll(), "plan-chosen": () => plan.fitChosen(), "plan-in": () => centre(1.5), "plan-out": () => centre(1 / 1.5),
      "time-in": () => charts.zoomBy(0.5), "time-out": () => charts.zoomBy(2), "time-all": () => charts.showAll(),
      "plan-png": () => planAsPng(plan), "rows-csv": () => this.saveRows(), measure: () => this.toggleMeasure(),
    };
    for (const [id, action] of Object.entries(clicks)) byId(id).addEventListener("click", action);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      readTheme();
      for (const surface of [plan.surface, ...(this.space?.surface ? [this.space.surface] : []), charts.surface, charts.ribbon]) surface.schedule();
    });
  }
}

loadData().then(startPage).catch((error) => {
  byId("notice").textContent = `The page could not be drawn: ${error.message}`;
  byId("notice").hidden = false;
  console.error(error);
});
