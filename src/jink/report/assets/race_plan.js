// The plan view of one run: truth below, measurements, and a line per filter in its colour.

class RacePlan extends PlanView {
  // tracks: one "target" per line, the truth first where it is known; visible(t) and colour(t, theme) say how to draw it.
  drawTracks(ctx) {
    const { tracks } = this;
    const { first, names } = tracks;
    if (tracks.truth) this.drawTruth(ctx, first[0], first[1]);
    ctx.fillStyle = theme.dot;
    ctx.globalAlpha = 0.7;
    drawDots(ctx, this, 0, first[1], 2.4, null);
    ctx.globalAlpha = 1;
    names.forEach((_, t) => {
      if (t === this.chosen || (tracks.truth && t === 0) || !tracks.visible(t)) return;
      this.line(ctx, first[t], first[t + 1], tracks.colour(t), 1.4);
    });
    if (this.chosen >= 0 && tracks.visible(this.chosen)) {
      this.line(ctx, first[this.chosen], first[this.chosen + 1], tracks.colour(this.chosen), 2.4);
    }
  }

  drawTruth(ctx, from, to) {
    const { tracks } = this;
    this.line(ctx, from, to, theme.muted, 7, 0.35);
    for (let i = from; i < to; i++) {
      if (!tracks.busy[i - from] || i === from) continue;
      this.line(ctx, i - 1, i + 1, theme.ramp[Math.floor(theme.bins / 2)], 7, 0.5);
    }
    const known = [from, to - 1].filter((i) => tracks.X[i] === tracks.X[i]);
    known.forEach((i) => drawEnd(ctx, this.px(tracks.X[i]), this.py(tracks.Y[i]), i !== from));
  }

  line(ctx, from, to, colour, width, alpha = 1) {
    const { X, Y } = this.tracks;
    ctx.globalAlpha = alpha;
    ctx.strokeStyle = colour;
    ctx.lineWidth = width;
    ctx.lineJoin = "round";
    ctx.lineCap = alpha < 1 ? "butt" : "round";
    ctx.beginPath();
    let pen = false;
    for (let i = from; i < to; i++) {
      if (X[i] !== X[i]) pen = false;
      else if (pen) ctx.lineTo(this.px(X[i]), this.py(Y[i]));
      else {
        ctx.moveTo(this.px(X[i]), this.py(Y[i]));
        pen = true;
      }
    }
    ctx.stroke();
    ctx.globalAlpha = 1;
  }

  // Lines that are not shown cannot be picked.
  refresh() {
    const all = this.bounds();
    this.boxes = all.map((box, t) => (this.tracks.visible(t) ? box : NO_BOX));
    this.surface.schedule();
  }
}

// Lines of one run as the plan view wants them: rows of all laid end to end.
function planTracks(meta, arrays, state) {
  const { run } = meta, n = arrays.time.length;
  const lines = [...(run.truth ? ["truth"] : []), ...run.tracks.map((k) => `track_${k}`)];
  const X = new Float64Array(n * lines.length), Y = new Float64Array(n * lines.length);
  const MX = new Float64Array(n * lines.length).fill(NaN), MY = new Float64Array(n * lines.length).fill(NaN);
  lines.forEach((name, t) => {
    X.set(arrays[`${name}_x`], t * n);
    Y.set(arrays[`${name}_y`], t * n);
  });
  MX.set(arrays.measured_x);
  MY.set(arrays.measured_y);
  const shift = run.truth ? 1 : 0;
  const seriesOf = (t) => (t < shift ? -1 : run.tracks[t - shift]);
  return {
    meta: { frame: null, statuses: [] }, X, Y, MX, MY, busy: arrays.busy, truth: run.truth,
    first: lines.map((_, t) => t * n).concat(n * lines.length), fresh: new Uint8Array(n * lines.length), status: new Uint8Array(n * lines.length),
    names: lines.map((_, t) => (t < shift ? "truth" : meta.series[seriesOf(t)].name)),
    seriesOf, lineOf: (k) => (run.tracks.indexOf(k) < 0 ? -1 : run.tracks.indexOf(k) + shift),
    visible: (t) => t < shift || state.visible[seriesOf(t)],
    colour: (t) => state.colour(seriesOf(t)),
    describe(t, row) {
      const i = row - t * n, lines = [formatTime(arrays.time[i], false, { step: 0.1 })];
      if (t >= shift && run.truth) lines.push(`${formatNumber(Math.hypot(X[row] - X[i], Y[row] - Y[i]), 3)} m from the truth`);
      if (arrays.busy[i]) lines.push("the target is manoeuvring");
      return lines.join("\n");
    },
  };
}
