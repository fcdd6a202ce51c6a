// Pointer and keyboard of the charts.

// A drag zooms to its span of time, hovering moves the cursor.
function listenToCharts(charts) {
  const canvas = charts.surface.overCanvas;
  canvas.addEventListener("pointerdown", (event) => {
    if (charts.target < 0 || event.button !== 0 || event.pointerType === "touch") return;
    canvas.setPointerCapture(event.pointerId);
    const [x] = charts.surface.at(event);
    charts.drag = [x, x];
  });
  canvas.addEventListener("pointermove", (event) => {
    if (charts.target < 0) return;
    const [x] = charts.surface.at(event);
    if (charts.drag) charts.drag[1] = x;
    charts.cursor = charts.nearestRow(x);
    charts.onCursor(charts.cursor);
    charts.drawOver();
  });
  const release = (event) => {
    const drag = charts.drag;
    charts.drag = null;
    if (drag && event.type === "pointerup" && Math.abs(drag[1] - drag[0]) > 5) {
      charts.setWindow(...drag.map((x) => charts.timeAt(x)).sort((p, q) => p - q));
    } else {
      charts.drawOver();
    }
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("dblclick", () => charts.showAll());
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    charts.zoomBy(Math.exp(event.deltaY * 0.002), charts.timeAt(charts.surface.at(event)[0]));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => chartsKey(charts, event));
}

function chartsKey(charts, event) {
  const move = (step) => {
    const start = charts.cursor >= charts.from ? charts.cursor : charts.rows()[0];
    charts.setCursor(Math.min(Math.max(start + step, charts.from), charts.to - 1));
    charts.onCursor(charts.cursor);
  };
  const around = charts.cursor >= charts.from ? charts.tracks.time[charts.cursor] : undefined;
  const stride = event.shiftKey ? 20 : 1;
  const actions = {
    ArrowLeft: () => move(-stride), ArrowRight: () => move(stride), "+": () => charts.zoomBy(0.6, around), "=": () => charts.zoomBy(0.6, around),
    "-": () => charts.zoomBy(1 / 0.6, around), 0: () => charts.showAll(), Escape: () => charts.showAll(),
  };
  if (charts.target < 0 || event.ctrlKey || event.metaKey || !actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
}

// A press on the ribbon moves the window there.
function listenToRibbon(charts) {
  const canvas = charts.ribbon.overCanvas;
  const move = (event) => {
    if (!(event.buttons & 1) || charts.target < 0) return;
    const [start, end] = charts.whole;
    const t = start + ((charts.ribbon.at(event)[0] - GUTTER) / (charts.ribbon.width - GUTTER - MARGIN)) * (end - start);
    const half = charts.zoomed ? (charts.window[1] - charts.window[0]) / 2 : (end - start) / 10;
    charts.setWindow(t - half, t + half);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    move(event);
  });
  canvas.addEventListener("pointermove", move);
}
