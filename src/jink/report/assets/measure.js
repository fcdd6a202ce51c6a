// Measuring on the plan view: hold Shift, or choose "Measure", and drag from one point to another.

class Measure {
  constructor(plan) {
    this.plan = plan;
    this.on = false;
    this.ends = null;
  }

  switch(on) {
    this.on = on;
    this.ends = null;
    this.plan.drawOver();
  }

  begin(x, y) {
    const at = this.plan.metres(x, y);
    this.ends = [at, at];
  }

  move(x, y) {
    this.ends[1] = this.plan.metres(x, y);
    this.plan.drawOver();
  }

  // [metres, degrees from north]: along the great circle where the plan has latitudes.
  result() {
    const [[x0, y0], [x1, y1]] = this.ends;
    const { frame } = this.plan;
    const compass = (east, north) => ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
    if (!frame) return [Math.hypot(x1 - x0, y1 - y0), compass(x1 - x0, y1 - y0)];
    const lat = (y) => (frame.latitude * Math.PI) / 180 + y / frame.radius;
    const a = lat(y0), b = lat(y1);
    const turn = (x1 - x0) / (frame.radius * Math.cos((frame.latitude * Math.PI) / 180));
    const h = Math.sin((b - a) / 2) ** 2 + Math.cos(a) * Math.cos(b) * Math.sin(turn / 2) ** 2;
    const east = Math.sin(turn) * Math.cos(b), north = Math.cos(a) * Math.sin(b) - Math.sin(a) * Math.cos(b) * Math.cos(turn);
    return [2 * frame.radius * Math.asin(Math.min(1, Math.sqrt(h))), compass(east, north)];
  }

  draw(ctx) {
    if (!this.ends) return;
    const { plan } = this;
    const [[x0, y0], [x1, y1]] = this.ends.map(([x, y]) => [plan.px(x), plan.py(y)]);
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 1.5;
    ctx.setLineDash([6, 3]);
    ctx.beginPath();
    ctx.moveTo(x0, y0);
    ctx.lineTo(x1, y1);
    ctx.stroke();
    ctx.setLineDash([]);
    drawLabel(ctx, this.text(), x1 + 10, y1 - 10);
  }

  text() {
    const [metres, degrees] = this.result();
    return `${formatLength(metres, metres / 200, this.plan.system)}  ${degrees.toFixed(1)}°`;
  }
}

// Text on a small plate, so that it can be read above tracks.
function drawLabel(ctx, text, x, y) {
  ctx.font = theme.font;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  const width = ctx.measureText(text).width;
  ctx.globalAlpha = 0.85;
  ctx.fillStyle = theme.panel;
  ctx.fillRect(x - 3, y - 8, width + 6, 16);
  ctx.globalAlpha = 1;
  ctx.fillStyle = theme.ink;
  ctx.fillText(text, x, y);
}
