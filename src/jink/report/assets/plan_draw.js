// Drawing of the plan view: graticule, measured dots, tracks coloured in bins, scale bar. `view` maps metres to pixels.

function drawGraticule(ctx, plan) {
  const { frame } = plan;
  const { width, height } = plan.surface;
  const [left, bottom] = plan.metres(0, height), [right, top] = plan.metres(width, 0);
  const perDegree = frame ? (Math.PI / 180) * frame.radius : 1;
  const squeeze = frame ? perDegree * Math.cos((frame.latitude * Math.PI) / 180) : 1;
  const originX = frame ? frame.longitude : 0, originY = frame ? frame.latitude : 0;
  const xs = niceTicks(originX + left / squeeze, originX + right / squeeze, width / 130);
  const ys = niceTicks(originY + bottom / perDegree, originY + top / perDegree, height / 110);
  ctx.strokeStyle = theme.grid;
  ctx.fillStyle = theme.muted;
  ctx.font = theme.font;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (const v of xs.ticks) {
    const x = Math.round(plan.px((v - originX) * squeeze)) + 0.5;
    ctx.moveTo(x, 0);
    ctx.lineTo(x, height);
  }
  for (const v of ys.ticks) {
    const y = Math.round(plan.py((v - originY) * perDegree)) + 0.5;
    ctx.moveTo(0, y);
    ctx.lineTo(width, y);
  }
  ctx.stroke();
  ctx.textBaseline = "top";
  ctx.textAlign = "left";
  const label = (v, step, east) => {
    if (!frame) return formatLength(v, step, plan.system);
    return east ? formatAngle(((v + 540) % 360 + 360) % 360 - 180, "E", "W", decimalsOf(step)) : formatAngle(v, "N", "S", decimalsOf(step));
  };
  for (const v of xs.ticks) {
    const x = plan.px((v - originX) * squeeze);
    if (x > 44) ctx.fillText(label(v, xs.step, true), x + 3, 3);
  }
  ctx.textBaseline = "bottom";
  for (const v of ys.ticks) {
    const y = plan.py((v - originY) * perDegree);
    if (y > 30 && y < height - 34) ctx.fillText(label(v, ys.step, false), 4, y - 1);
  }
}

// A distance in metres in the large unit, or in metres when the step is small.
function formatLength(metres, step, system) {
  const [unit, factor] = unitOf(step * unitOf("distance", system)[1] < 0.1 ? "length" : "distance", system);
  // three digits of the step at most: one that is not round has no end
  const decimals = Math.min(decimalsOf(step * factor), Math.max(0, 2 - Math.floor(Math.log10(step * factor))));
  return `${formatFixed(metres * factor, decimals)} ${unit}`;
}

function drawScaleBar(ctx, plan) {
  const { view, surface, system } = plan;
  const large = unitOf("distance", system);
  const wanted = 120 / view.k;
  const [, factor] = wanted * large[1] < 0.1 ? unitOf("length", system) : large;
  const power = 10 ** Math.floor(Math.log10(wanted * factor));
  const length = (power * [5, 2, 1].find((m) => m * power <= wanted * factor)) / factor;
  const pixels = length * view.k, x = 12, y = surface.height - 12;
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.moveTo(x, y - 5);
  ctx.lineTo(x, y);
  ctx.lineTo(x + pixels, y);
  ctx.lineTo(x + pixels, y - 5);
  ctx.stroke();
  ctx.font = theme.font;
  ctx.fillStyle = theme.ink;
  ctx.textAlign = "center";
  ctx.textBaseline = "bottom";
  ctx.fillText(formatLength(length, length, system), x + pixels / 2, y - 3);
}

// Measured positions of rows [from, to): squares of `size` pixels, or rings for the gated ones.
function drawDots(ctx, plan, from, to, size, gated) {
  const { tracks, surface } = plan;
  const { MX, MY, status } = tracks;
  const half = size / 2;
  for (let i = from; i < to; i++) {
    const x = plan.px(MX[i]), y = plan.py(MY[i]);
    if (!(x > -9 && x < surface.width + 9 && y > -9 && y < surface.height + 9)) continue;
    if (status[i] === plan.gatedCode) {
      if (gated) gated.push(x, y);
      continue;
    }
    ctx.fillRect(x - half, y - half, size, size);
  }
}

function drawGated(ctx, points) {
  ctx.strokeStyle = theme.warn;
  ctx.lineWidth = 1.25;
  ctx.beginPath();
  for (let k = 0; k < points.length; k += 2) {
    const x = points[k], y = points[k + 1];
    ctx.moveTo(x - 3, y - 3);
    ctx.lineTo(x + 3, y + 3);
    ctx.moveTo(x - 3, y + 3);
    ctx.lineTo(x + 3, y - 3);
  }
  ctx.stroke();
}

// Adds rows [from, to) to one Path2D per colour bin (coasting ones in bins of their own, drawn dashed);
// points closer than most of a pixel in the same colour are skipped.
function addTrack(paths, plan, from, to) {
  const { tracks, surface, bins } = plan;
  const { X, Y, fresh, coasting } = tracks;
  const w = surface.width + 20, h = surface.height + 20;
  let lx = NaN, ly = NaN, lastBin = -1, at = -1;
  for (let i = from; i < to; i++) {
    const x = plan.px(X[i]), y = plan.py(Y[i]);
    if (fresh[i] || x !== x || lx !== lx) {
      lx = x;
      ly = y;
      at = -1;
      lastBin = bins[i];
      continue;
    }
    const bin = Math.max(bins[i], bins[i - 1]) + (coasting[i] ? theme.bins : 0);
    const last = i === to - 1 || fresh[i + 1];
    if (!last && bin === lastBin && Math.abs(x - lx) + Math.abs(y - ly) < 0.8) continue;
    lastBin = bin;
    const outside = (x < -20 && lx < -20) || (x > w && lx > w) || (y < -20 && ly < -20) || (y > h && ly > h);
    if (!outside) {
      const path = paths[bin] || (paths[bin] = new Path2D());
      if (at !== bin) path.moveTo(lx, ly);
      path.lineTo(x, y);
      at = bin;
    } else {
      at = -1;
    }
    lx = x;
    ly = y;
  }
}

function strokePaths(ctx, paths, width) {
  ctx.lineWidth = width;
  ctx.lineJoin = ctx.lineCap = "round";
  paths.forEach((path, bin) => {
    const dashed = bin >= theme.bins;
    ctx.setLineDash(dashed ? [1, 2.5 * width] : []);
    ctx.strokeStyle = theme.ramp[bin % theme.bins];
    ctx.stroke(path);
  });
  ctx.setLineDash([]);
}

// A soft glow that lifts the chosen track off the others.
function drawGlow(ctx, plan, from, to) {
  const paths = [];
  addTrack(paths, plan, from, to);
  const whole = new Path2D();
  paths.forEach((path) => whole.addPath(path));
  ctx.lineJoin = ctx.lineCap = "round";
  ctx.lineWidth = 9;
  ctx.strokeStyle = theme.accent;
  ctx.globalAlpha = 0.24;
  ctx.stroke(whole);
  ctx.globalAlpha = 1;
}

function drawEnd(ctx, x, y, filled) {
  ctx.beginPath();
  ctx.arc(x, y, 4, 0, 2 * Math.PI);
  ctx.fillStyle = filled ? theme.ink : theme.panel;
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 1.5;
  ctx.fill();
  ctx.stroke();
}
