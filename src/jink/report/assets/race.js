// The race page: which filters are shown, which one is chosen, and the table.

const byId = (id) => document.getElementById(id);
const SERIES = 10;

function makeState(meta) {
  const filters = meta.series.map((s, k) => [s, k]).filter(([s]) => !s.yardstick).map(([, k]) => k);
  const place = (k) => filters.indexOf(k);
  const wanted = meta.series.findIndex((s) => s.name === "imm");
  const references = { raw: () => theme.dot, clairvoyant: () => theme.ink, "near-optimal": () => theme.muted };
  return {
    chosen: wanted >= 0 ? wanted : filters[0] ?? 0,
    visible: meta.series.map((s, k) => s.yardstick || place(k) < meta.shown),
    colour: (k) => references[meta.series[k].name]?.() ?? theme.series[place(k) % SERIES],
    dash: (k) => (meta.series[k].yardstick ? [5, 3] : place(k) < SERIES ? [] : [9, 3]),
    variable: (k) => ({ raw: "--dot", clairvoyant: "--ink", "near-optimal": "--muted" })[meta.series[k].name] ?? `--series-${place(k) % SERIES}`,
  };
}

function readSeries() {
  const style = getComputedStyle(document.documentElement);
  theme.series = Array.from({ length: SERIES }, (_, i) => style.getPropertyValue(`--series-${i}`).trim());
}

class RacePage {
  constructor(meta, arrays) {
    this.meta = meta;
    this.state = makeState(meta);
    if (meta.run?.plane) this.makePlan(meta, arrays);
    else byId("plan-pane").hidden = true;
    if (meta.run) this.makeCharts(meta, arrays);
    this.table = new SortableTable(byId("list"), this.columns(), { onChoose: (k) => this.choose(k) });
    this.table.sortBy(1);
    this.table.sortBy(1);
    this.chips();
    this.wire();
    this.choose(this.state.chosen);
    this.plan?.fitAll({ smooth: false });
    window.jinkPage = this.handle();
  }

  // What tests (and the console) may ask of the page.
  handle() {
    const { plan, charts, state } = this;
    return {
      state,
      timeWindow: () => [...charts.window, ...charts.whole],
      whereIs(name) {
        const { names, first, X, Y } = plan.tracks, line = names.indexOf(name);
        const row = (first[line] + first[line + 1]) >> 1;
        return [plan.px(X[row]), plan.py(Y[row])];
      },
    };
  }

  makePlan(meta, arrays) {
    const tracks = planTracks(meta, arrays, this.state);
    const onChoose = (line) => tracks.seriesOf(line) >= 0 && this.choose(tracks.seriesOf(line));
    const onCursor = (row) => this.charts.setCursor(row < 0 ? -1 : row % arrays.time.length);
    this.plan = new RacePlan(byId("plan"), tracks, { onChoose, onCursor });
    this.plan.refresh();
  }

  makeCharts(meta, arrays) {
    const onCursor = (row) => {
      const line = this.plan ? this.plan.tracks.lineOf(this.state.chosen) : -1;
      this.plan?.setCursor(row < 0 ? -1 : Math.max(line, 0) * arrays.time.length + row);
    };
    const onWindow = (rows) => { byId("time-all").disabled = rows === null; };
    this.charts = new TimeCharts(byId("charts"), byId("ribbon"), racePanels(meta, arrays, this.state), { onCursor, onWindow });
    this.charts.choose(0);
  }

  columns() {
    const { series, columns } = this.meta;
    const labels = [...series.map((s) => s.label), ...(this.meta.bound ? ["PCRB (a bound)"] : [])];
    const name = { title: "Filter", values: labels, text: (k) => labels[k] };
    return [name, ...columns.map((c) => ({
      title: c.title, unit: () => c.unit, values: c.value, numeric: true, hint: c.key, text: (k) => c.text[k],
      flag: (k) => c.key === "position_rmse" && series[k]?.worse,
    }))];
  }

  chips() {
    const { series } = this.meta;
    byId("chips").append(...series.map((s, k) => {
      const chip = Object.assign(document.createElement("button"), { type: "button", textContent: s.name, title: s.words });
      chip.style.setProperty("--swatch", `var(${this.state.variable(k)})`);
      chip.setAttribute("aria-pressed", String(this.state.visible[k]));
      chip.addEventListener("click", () => this.show(k, !this.state.visible[k]));
      return chip;
    }));
    byId("chosen-filter").append(...series.map((s, k) => new Option(s.name, String(k))));
    byId("chosen-filter").addEventListener("change", (event) => this.choose(Number(event.target.value)));
  }

  show(k, visible) {
    this.state.visible[k] = visible;
    byId("chips").children[k].setAttribute("aria-pressed", String(visible));
    this.plan?.refresh();
    this.charts?.surface.schedule();
  }

  choose(k) {
    if (!this.meta.series[k]) return;
    this.state.chosen = k;
    if (!this.state.visible[k]) this.show(k, true);
    byId("chosen-filter").value = String(k);
    byId("facts").textContent = `readings: ${this.meta.series[k].name}`;
    document.documentElement.dataset.chosen = this.meta.series[k].name;
    this.table.choose(k, { scroll: false });
    this.plan?.choose(this.plan.tracks.lineOf(k));
    if (!this.charts) return;
    this.charts.heads.replaceChildren();
    this.charts.makeHeads();
    this.charts.surface.schedule();
  }

  wire() {
    const { plan, charts } = this;
    const centre = (factor) => plan.zoom(factor, plan.surface.width / 2, plan.surface.height / 2);
    const clicks = {
      "plan-all": () => plan.fitAll(), "plan-in": () => centre(1.5), "plan-out": () => centre(1 / 1.5),
      "time-in": () => charts.zoomBy(0.5), "time-out": () => charts.zoomBy(2), "time-all": () => charts.showAll(),
    };
    for (const [id, action] of Object.entries(clicks)) byId(id).addEventListener("click", action);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      readTheme();
      readSeries();
      for (const surface of [plan?.surface, charts?.surface, charts?.ribbon]) surface?.schedule();
    });
  }
}

loadData().then(({ meta, arrays }) => {
  readTheme();
  readSeries();
  new RacePage(meta, arrays);
  document.documentElement.dataset.ready = "yes";
}).catch((error) => {
  byId("notice").textContent = `The page could not be drawn: ${error.message}`;
  byId("notice").hidden = false;
  console.error(error);
});
