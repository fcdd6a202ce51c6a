// Boxes [x0, y0, x1, y1] around rows, and distances to drawn lines.

const NO_BOX = [Infinity, Infinity, -Infinity, -Infinity];

function boxOf(X, Y, from, to) {
  const box = [...NO_BOX];
  for (let i = from; i < to; i++) {
    if (X[i] !== X[i] || Y[i] !== Y[i]) continue;
    box[0] = Math.min(box[0], X[i]);
    box[1] = Math.min(box[1], Y[i]);
    box[2] = Math.max(box[2], X[i]);
    box[3] = Math.max(box[3], Y[i]);
  }
  return box;
}

function joinBoxes(a, b) {
  return [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[2], b[2]), Math.max(a[3], b[3])];
}

function nearestOnSegment(x, y, ax, ay, bx, by) {
  const dx = bx - ax, dy = by - ay, l2 = dx * dx + dy * dy;
  const f = l2 > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / l2)) : 1;
  return [(ax + f * dx - x) ** 2 + (ay + f * dy - y) ** 2, f];
}
