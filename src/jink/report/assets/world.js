// Coasts, borders and lakes behind the tracks (see world.py), and radar sites with range rings.

const WORLD_KINDS = ["coast", "border", "lake"];

// { kind, first, X, Y, boxes } of the lines that the page carries, or null.
function makeWorld(arrays) {
  if (!arrays.world_kind) return null;
  const { world_kind: kind, world_first: first, world_x: X, world_y: Y } = arrays;
  return { kind, first, X, Y, boxes: Array.from(kind, (_, k) => boxOf(X, Y, first[k], first[k + 1])) };
}

function drawWorld(ctx, plan) {
  const { world } = plan.tracks;
  if (!world) return;
  const paths = WORLD_KINDS.map(() => new Path2D());
  for (let k = 0; k < world.kind.length; k++) {
    if (plan.visible(world.boxes[k])) addLine(paths[world.kind[k]], plan, world, world.first[k], world.first[k + 1]);
  }
  ctx.lineJoin = "round";
  paths.forEach((path, kind) => {
    ctx.strokeStyle = theme[WORLD_KINDS[kind]];
    ctx.lineWidth = kind === 0 ? 1.1 : 0.9;
    ctx.setLineDash(kind === 1 ? [5, 3] : []);
    ctx.stroke(path);
  });
  ctx.setLineDash([]);
}

// Vertices closer than a pixel to the last drawn one are skipped.
function addLine(path, plan, { X, Y }, from, to) {
  let lx = plan.px(X[from]), ly = plan.py(Y[from]);
  path.moveTo(lx, ly);
  for (let i = from + 1; i < to; i++) {
    const x = plan.px(X[i]), y = plan.py(Y[i]);
    if (i < to - 1 && Math.abs(x - lx) + Math.abs(y - ly) < 1) continue;
    path.lineTo(x, y);
    lx = x;
    ly = y;
  }
}

// A triangle and its name at each radar, and rings at round ranges about it.
function drawSites(ctx, plan) {
  const { width, height } = plan.surface;
  ctx.font = theme.font;
  ctx.textBaseline = "bottom";
  ctx.textAlign = "left";
  for (const { name, x, y, range } of plan.tracks.meta.sites || []) {
    const cx = plan.px(x), cy = plan.py(y);
    const [, factor] = unitOf("distance", plan.system);
    const { ticks, step } = niceTicks(0, Math.max(range, 1) * factor, 4);
    ctx.strokeStyle = theme.line;
    ctx.fillStyle = theme.muted;
    ctx.lineWidth = 1;
    for (const ring of ticks.slice(1)) {
      const radius = (ring / factor) * plan.view.k;
      ctx.beginPath();
      ctx.ellipse(cx, cy, radius * plan.view.aspect, radius, 0, 0, 2 * Math.PI);
      ctx.stroke();
      if (cx > 0 && cx < width && cy - radius > 28 && cy - radius < height) {  // below the labels of the axis
        ctx.fillText(formatLength(ring / factor, step / factor, plan.system), cx + 4, cy - radius);
      }
    }
    ctx.fillStyle = theme.ink;
    ctx.beginPath();
    ctx.moveTo(cx, cy - 6);
    ctx.lineTo(cx + 5, cy + 4);
    ctx.lineTo(cx - 5, cy + 4);
    ctx.fill();
    if (name) ctx.fillText(name, cx + 8, cy + 5);
  }
}
