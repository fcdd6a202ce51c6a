// Drawing of one time panel. `p` holds the panel's rectangle and scales: { x(t), y(v), left, right, top, bottom, low, high }.
// Rows [a, b) of the target are drawn; with many rows per pixel a line is reduced to first, lowest, highest, last per column.

// Lowest and highest value to show. A value counts where its sd has settled (at most twice the 90 % quantile at
// updates), so that a wild first estimate does not flatten the rest; bands and coasting get at most half of the panel.
function valueRange(curves, tracks, a, b, floor) {
  let low = Infinity, high = -Infinity, bandLow = Infinity, bandHigh = -Infinity;
  for (const { value, sd } of curves) {
    const limit = 2 * quantileOf(sd, tracks.updated, a, b, 0.9);
    for (const strict of [true, false]) {
      for (let i = a; i < b; i++) {
        const v = value[i], sure = !(sd[i] > limit), band = strict && sure ? 2 * sd[i] || 0 : 0;
        if (v !== v || (strict && !sure && !tracks.coasting[i])) continue;
        if (sure || !strict) {
          low = Math.min(low, v);
          high = Math.max(high, v);
        }
        bandLow = Math.min(bandLow, v - band);
        bandHigh = Math.max(bandHigh, v + band);
      }
      if (high >= low) break;
    }
  }
  if (!(high >= low)) return [0, 1];
  const room = Math.max(high - low, floor) / 2;
  [low, high] = [Math.max(bandLow, low - room), Math.min(bandHigh, high + room)];
  const lack = Math.max(floor - (high - low), 0) / 2, pad = 0.06 * Math.max(high - low, floor);
  return [low - lack - pad, high + lack + pad];
}

function quantileOf(values, used, a, b, q) {
  const step = Math.max(1, Math.floor((b - a) / 2000));
  const some = [];
  for (let i = a; i < b; i += step) if (used[i] && values[i] === values[i]) some.push(values[i]);
  if (!some.length) return Infinity;
  some.sort((x, y) => x - y);
  return some[Math.floor(q * (some.length - 1))];
}

// Calls `run(from, to)` for every stretch of rows that are unbroken and have a number in `value`.
function eachRun(value, fresh, a, b, run) {
  let start = -1;
  for (let i = a; i < b; i++) {
    const gap = value[i] !== value[i];
    if (start >= 0 && (gap || fresh[i])) {
      run(start, i);
      start = -1;
    }
    if (!gap && start < 0) start = i;
  }
  if (start >= 0) run(start, b);
}

// Indices to draw in rows [from, to): all, or four per pixel column.
function thin(value, X, from, to) {
  const out = [];
  if (to - from < 3000) {
    for (let i = from; i < to; i++) out.push(i);
    return out;
  }
  let i = from;
  while (i < to) {
    const column = Math.floor(X(i));
    let low = i, high = i, j = i;
    while (j < to && Math.floor(X(j)) === column) {
      if (value[j] < value[low]) low = j;
      if (value[j] > value[high]) high = j;
      j++;
    }
    out.push(i);
    if (low !== i && low !== j - 1) out.push(low);
    if (high !== i && high !== low && high !== j - 1) out.push(high);
    if (j - 1 > i) out.push(j - 1);
    i = j;
  }
  return out.sort((p, q) => p - q);
}

function drawCurve(ctx, p, { value, sd }, fresh, X, a, b, colour, shift = 0) {
  ctx.fillStyle = ctx.strokeStyle = colour;
  eachRun(value, fresh, a, b, (from, to) => {
    const rows = thin(value, X, from, to);
    const clamp = (y) => Math.min(Math.max(y, p.top - 4000), p.bottom + 4000);
    const wide = rows.filter((i) => sd[i] === sd[i]);
    if (wide.length > 1) {
      ctx.globalAlpha = 0.2;
      ctx.beginPath();
      for (const i of wide) ctx.lineTo(X(i), clamp(p.y(value[i] + shift + 2 * sd[i])));
      for (const i of wide.reverse()) ctx.lineTo(X(i), clamp(p.y(value[i] + shift - 2 * sd[i])));
      ctx.fill();
      ctx.globalAlpha = 1;
    }
    if (rows.length === 1) {
      ctx.beginPath();
      ctx.arc(X(rows[0]), p.y(value[rows[0]] + shift), 2.5, 0, 2 * Math.PI);
      ctx.fill();
      return;
    }
    ctx.lineWidth = 1.4;
    ctx.lineJoin = "round";
    ctx.beginPath();
    for (const i of rows) ctx.lineTo(X(i), clamp(p.y(value[i] + shift)));
    ctx.stroke();
  });
}

// A course is unwrapped in the data; where it spans more than a turn and a half it is drawn as shifted copies in 0..360.
function courseRange([low, high]) {
  return high - low > 540 ? { low: 0, high: 360, shifts: courseShifts(low, high) } : { low, high, shifts: [0] };
}

function courseShifts(low, high) {
  const shifts = [];
  for (let k = Math.floor(low / 360); k * 360 <= high; k++) shifts.push(-360 * k);
  return shifts;
}

// Mode probabilities (Uint8, 254 = one) stacked to one, the first mode at the bottom.
function drawStack(ctx, p, modes, fresh, X, a, b) {
  eachRun(modes[0].known, fresh, a, b, (from, to) => {
    const rows = [];
    let last = -Infinity;
    for (let i = from; i < to; i++) {
      if (i !== to - 1 && to - from > 3000 && X(i) - last < 0.7) continue;
      last = X(i);
      rows.push(i);
    }
    if (rows.length < 2) return;
    let base = rows.map(() => 0);
    modes.forEach((mode, m) => {
      const top = rows.map((i, k) => (m === modes.length - 1 ? 1 : Math.min(1, base[k] + mode.share(i))));
      ctx.fillStyle = theme.modes[m % theme.modes.length];
      ctx.beginPath();
      rows.forEach((i, k) => ctx.lineTo(X(i), p.y(top[k])));
      for (let k = rows.length - 1; k >= 0; k--) ctx.lineTo(X(rows[k]), p.y(base[k]));
      ctx.fill();
      base = top;
    });
  });
}

// NIS as dots against its 95 % band; what lies above the panel is drawn at its upper edge.
function drawNis(ctx, p, nis, band, X, a, b) {
  ctx.fillStyle = theme.accent;
  ctx.globalAlpha = 0.13;
  ctx.fillRect(p.left, p.y(band[1]), p.right - p.left, p.y(band[0]) - p.y(band[1]));
  ctx.globalAlpha = b - a > 4000 ? 0.4 : 0.75;
  for (let i = a; i < b; i++) {
    if (nis[i] !== nis[i]) continue;
    const out = nis[i] < band[0] || nis[i] > band[1];
    ctx.fillStyle = out ? theme.warn : theme.accent;
    ctx.fillRect(X(i) - 1, Math.max(p.y(nis[i]), p.top + 1) - 1, 2.2, 2.2);
  }
  ctx.globalAlpha = 1;
}

function panelTicks(p, quantity, factor) {
  const count = Math.max(1.7, (p.bottom - p.top) / 19);
  if (quantity === "probability") return { step: 0.5, ticks: [0, 0.5, 1] };
  const wide = quantity === "course" && p.high - p.low > 10 * count;
  if (!wide) {
    const found = [count, 2 * count, 3 * count].map((n) => niceTicks(p.low * factor, p.high * factor, n));
    return found.find(({ ticks }) => ticks.length > 1) || found[0];
  }
  const step = [15, 30, 45, 90, 180].find((s) => s * (p.bottom - p.top) / 15 >= p.high - p.low) || 360;
  const ticks = [];
  for (let v = Math.ceil(p.low / step) * step; v <= p.high; v += step) ticks.push(v);
  return { step, ticks };
}

function drawPanelFrame(ctx, p, quantity, factor, tx) {
  ctx.strokeStyle = theme.grid;
  ctx.fillStyle = theme.muted;
  ctx.font = theme.font;
  ctx.lineWidth = 1;
  ctx.textAlign = "right";
  ctx.textBaseline = "middle";
  const { step, ticks } = panelTicks(p, quantity, factor);
  const decimals = decimalsOf(step);
  ctx.beginPath();
  for (const v of ticks) {
    const y = Math.round(p.y(v / factor)) + 0.5;
    if (y < p.top + 1 || y > p.bottom + 1) continue;
    ctx.moveTo(p.left, y);
    ctx.lineTo(p.right, y);
    const shown = quantity === "course" ? ((v % 360) + 360) % 360 : v;
    ctx.fillText(formatFixed(shown, decimals), p.left - 6, y);
  }
  for (const x of tx) {
    ctx.moveTo(Math.round(x) + 0.5, p.top);
    ctx.lineTo(Math.round(x) + 0.5, p.bottom);
  }
  ctx.stroke();
  ctx.strokeStyle = theme.line;
  ctx.beginPath();
  ctx.moveTo(p.left, Math.round(p.bottom) + 0.5);
  ctx.lineTo(p.right, Math.round(p.bottom) + 0.5);
  ctx.stroke();
}
