// What each panel of the charts is: its legend, vertical scale, drawing and reading at the cursor.

// Smallest span shown, so that noise on a constant does not fill a panel (SI units, degrees).
const FLOORS = { speed: 4, course: 10, height: 40, climb: 2, acceleration: 0.5, turn_rate: 0.4 };

function makePanels(meta, arrays, tracks) {
  const panels = meta.panels.map((entry) => curvePanel(entry, arrays, tracks));
  if (meta.modes.length) panels.push(modePanel(meta.modes, arrays, tracks));
  if (arrays.nis && meta.nis_band) panels.push(nisPanel(meta, arrays));
  return panels;
}

function curvePanel(entry, arrays, tracks) {
  const curves = entry.curves.map(({ label, value, sd }) => ({ label, value: arrays[value], sd: arrays[sd] }));
  const colours = () => [theme.accent, theme.second];
  const names = ["var(--accent)", "var(--second)"];
  let shifts = [0];
  return {
    ...entry,
    keys: () => (curves.length > 1 ? curves.map((curve, c) => [curve.label, names[c]]) : []),
    scale(p, a, b) {
      if (entry.quantity === "probability") return void ([p.low, p.high] = [0, 1.02]);
      [p.low, p.high] = valueRange(curves, tracks, a, b, FLOORS[entry.quantity] || 1e-9);
      if (entry.quantity === "course") ({ low: p.low, high: p.high, shifts } = courseRange([p.low, p.high]));
    },
    draw(ctx, p, X, a, b) {
      curves.forEach((curve, c) => {
        for (const shift of shifts) drawCurve(ctx, p, curve, tracks.fresh, X, a, b, colours()[c], shift);
      });
    },
    read(i, system) {
      const [unit, factor] = unitOf(entry.quantity, system);
      return curves.map(({ value, sd }) => {
        if (value[i] !== value[i]) return "–";
        const shown = entry.quantity === "course" ? ((value[i] % 360) + 360) % 360 : value[i] * factor;
        const spread = sd[i] === sd[i] ? ` ± ${formatNumber(2 * sd[i] * factor, 2)}` : "";
        return `${formatAs(shown, 2 * sd[i] * factor)}${spread}`;
      }).join("   ") + (unit === "°" || !unit ? unit : ` ${unit}`);
    },
  };
}

// A value with as many decimals as its uncertainty makes worth telling.
function formatAs(value, uncertainty) {
  if (!(uncertainty > 0)) return formatNumber(value, 4);
  return formatFixed(value, Math.min(5, Math.max(0, 1 - Math.floor(Math.log10(uncertainty)))));
}

function modePanel(names, arrays, tracks) {
  const known = new Float32Array(tracks.time.length);
  const modes = names.map((name, m) => {
    const codes = arrays[`mode${m}`];
    for (let i = 0; i < codes.length; i++) if (codes[i] === 255) known[i] = NaN;
    return { name: name.replaceAll("_", " "), known, share: (i) => codes[i] / 254 };
  });
  return {
    key: "modes",
    title: "Modes",
    quantity: "probability",
    keys: () => modes.map(({ name }, m) => [name, `var(--mode-${m % 8})`]),
    scale(p) { [p.low, p.high] = [0, 1]; },
    draw(ctx, p, X, a, b) { drawStack(ctx, p, modes, tracks.fresh, X, a, b); },
    read(i) { return known[i] === 0 ? `${modes.map(({ share }) => (100 * share(i)).toFixed(0)).join(" · ")} %` : "–"; },
  };
}

function nisPanel(meta, arrays) {
  const { nis } = arrays;
  const band = meta.nis_band;
  return {
    key: "nis",
    title: "NIS and its 95 % band",
    quantity: "nis",
    keys: () => [],
    scale(p) { [p.low, p.high] = [0, band[1] * 1.7]; },
    draw(ctx, p, X, a, b) { drawNis(ctx, p, nis, band, X, a, b); },
    read(i) { return formatNumber(nis[i], 3); },
  };
}
