// Panels of the race page: a line per filter with its band, and the mode probabilities of the chosen filter.

function racePanels(meta, arrays, state) {
  const n = arrays.time.length;
  const tracks = { time: Float64Array.from(arrays.time, (t) => t - arrays.time[0]), fresh: new Uint8Array(n) };
  const panels = meta.panels.map((entry) => errorPanel(meta, entry, arrays, state, tracks));
  if (Object.keys(meta.run.modes).length) panels.push(chosenModes(meta, arrays, state, tracks));
  return {
    ...tracks, meta: { clock: false }, first: [0, n], start: [arrays.time[0]], names: [meta.run.name], panels,
    manoeuvring: (i) => arrays.busy[i],
  };
}

const CUT = 2.5; // times the chosen filter

function errorPanel(meta, entry, arrays, state, tracks) {
  const curves = entry.curves.map(({ series, array }) => ({ series, value: arrays[array], sd: arrays[`${array}_se`] }));
  const [unit, factor] = unitOf(entry.quantity, "si");
  return {
    ...entry,
    keys: () => [],
    // Raw measurements do not set the scale where filters are shown, and filters far above the chosen one are cut off:
    // they would flatten the rest.
    scale(p, a, b) {
      const shown = curves.filter((c) => state.visible[c.series]);
      const leading = shown.filter((c) => meta.series[c.series].name !== "raw");
      const signed = entry.quantity === "";
      [p.low, p.high] = spanOf(leading.length ? leading : shown, a, b, signed);
      const chosen = leading.filter((c) => c.series === state.chosen);
      if (chosen.length && !signed) p.high = Math.min(p.high, CUT * spanOf(chosen, a, b, signed)[1]);
    },
    draw(ctx, p, X, a, b) {
      for (const curve of curves.filter((c) => state.visible[c.series]).sort((c) => (c.series === state.chosen ? 1 : -1))) {
        ctx.setLineDash(state.dash(curve.series));
        drawCurve(ctx, p, curve, tracks.fresh, X, a, b, state.colour(curve.series));
      }
      ctx.setLineDash([]);
    },
    read(i) {
      const curve = curves.find((c) => c.series === state.chosen);
      if (!curve || curve.value[i] !== curve.value[i]) return "–";
      const se = curve.sd[i] === curve.sd[i] ? ` ± ${formatNumber(2 * curve.sd[i] * factor, 2)}` : "";
      return `${formatAs(curve.value[i] * factor, 2 * curve.sd[i] * factor)}${se} ${unit}`;
    },
  };
}

// Lowest (or zero) to the 99 % quantile of what is shown.
function spanOf(curves, a, b, signed) {
  const all = [];
  for (const { value, sd } of curves) {
    for (let i = a; i < b; i++) if (value[i] === value[i]) all.push(value[i] + (2 * sd[i] || 0));
  }
  if (!all.length) return [0, 1];
  all.sort((x, y) => x - y);
  const high = all[Math.ceil(0.99 * all.length) - 1], low = signed ? all[Math.floor(0.01 * all.length)] : 0;
  const pad = 0.08 * Math.max(high - low, 1e-9);
  return [signed ? low - pad : 0, high + pad];
}

function chosenModes(meta, arrays, state, tracks) {
  const made = {};
  for (const [k, names] of Object.entries(meta.run.modes)) {
    const own = Object.fromEntries(names.map((_, m) => [`mode${m}`, arrays[`modes_${k}_${m}`]]));
    made[k] = modePanel(names, own, tracks);
  }
  const now = () => made[state.chosen];
  return {
    key: "modes", quantity: "probability",
    get title() { return `Modes, ${meta.run.name}`; },
    keys: () => (now() ? now().keys() : [["this filter has one mode", "transparent"]]),
    scale(p) { [p.low, p.high] = [0, 1]; },
    draw(ctx, p, X, a, b) { now()?.draw(ctx, p, X, a, b); },
    read: (i) => (now() ? now().read(i) : "–"),
  };
}
