// All targets at one moment: a slider over the time of the whole table, and play.

const SPEEDS = [1, 5, 20, 60, 300, 1800, 7200];

class Replay {
  constructor(plan, tracks, controls) {
    Object.assign(this, { plan, tracks, controls, moment: null, playing: false });
    const { first, time, start, names } = tracks;
    this.from = Infinity;
    this.to = -Infinity;
    names.forEach((_, t) => {
      if (first[t + 1] <= first[t]) return;
      this.from = Math.min(this.from, start[t] + time[first[t]]);
      this.to = Math.max(this.to, start[t] + time[first[t + 1] - 1]);
    });
    this.tail = Math.max((this.to - this.from) / 40, 1e-9);
    const { speed, slider } = controls;
    speed.append(...SPEEDS.map((s) => new Option(`${s} ×`, String(s))));
    speed.value = String(SPEEDS.find((s) => (this.to - this.from) / s < 60) || SPEEDS.at(-1));
    slider.max = "10000";
    slider.addEventListener("input", () => this.show(this.from + (slider.value / 10000) * (this.to - this.from)));
    controls.play.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    controls.off.addEventListener("click", () => this.leave());
    this.tell();
  }

  show(moment) {
    this.moment = Math.min(Math.max(moment, this.from), this.to);
    this.controls.slider.value = String(Math.round((10000 * (this.moment - this.from)) / Math.max(this.to - this.from, 1e-9)));
    this.tell();
    if (!this.plan.faded) {
      this.plan.faded = true;
      this.plan.surface.schedule();
    }
    this.plan.drawOver();
  }

  leave() {
    this.pause();
    this.moment = null;
    this.plan.faded = false;
    this.tell();
    this.plan.surface.schedule();
  }

  play() {
    if (this.moment === null || this.moment >= this.to) this.show(this.from);
    this.playing = true;
    this.tell();
    let last = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      this.show(this.moment + (Number(this.controls.speed.value) * (now - last)) / 1000);
      last = now;
      if (this.moment >= this.to) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  tell() {
    const { play, off, text } = this.controls;
    play.textContent = this.playing ? "Pause" : "Play";
    off.disabled = this.moment === null;
    const { clock } = this.tracks.meta;
    text.textContent = this.moment === null ? "all times" : formatTime(this.moment, clock, { date: !this.tracks.meta.same_day, step: clock ? 1 : 0.1 });
  }

  // [row, x, y] of a target at the moment, or null where it is not in the air.
  place(t) {
    const { first, time, start, fresh, X, Y } = this.tracks;
    const at = this.moment - start[t], from = first[t], to = first[t + 1];
    if (this.plan.boxes[t] === NO_BOX || to <= from || at < time[from] || at > time[to - 1]) return null;
    const row = lastAtMost(time, at, from, to);
    if (row + 1 >= to) return [row, X[row], Y[row]];
    if (fresh[row + 1]) return null;
    const f = (at - time[row]) / Math.max(time[row + 1] - time[row], 1e-9);
    return [row, X[row] + f * (X[row + 1] - X[row]), Y[row] + f * (Y[row + 1] - Y[row])];
  }

  draw(ctx) {
    if (this.moment === null) return;
    const { plan, tracks } = this;
    const { width, height } = plan.surface;
    const seen = [];
    tracks.names.forEach((_, t) => {
      const place = this.place(t);
      if (!place || place[1] !== place[1]) return;
      const x = plan.px(place[1]), y = plan.py(place[2]);
      if (x < -9 || x > width + 9 || y < -9 || y > height + 9) return;
      seen.push([t, place[0], x, y]);
      this.drawTail(ctx, t, place[0], x, y);
    });
    for (const [t, row, x, y] of seen) {
      ctx.beginPath();
      ctx.arc(x, y, t === plan.chosen ? 5.5 : 4, 0, 2 * Math.PI);
      ctx.fillStyle = theme.ramp[plan.bins[row]];
      ctx.strokeStyle = t === plan.chosen ? theme.accent : theme.halo;
      ctx.lineWidth = 1.5;
      ctx.fill();
      ctx.stroke();
    }
    drawNames(ctx, plan, seen.map(([t, , x, y]) => [t, x, y]));
  }

  drawTail(ctx, t, row, x, y) {
    const { plan, tracks } = this;
    const { first, time, start, fresh, X, Y } = tracks;
    ctx.strokeStyle = theme.accent;
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    ctx.moveTo(x, y);
    for (let i = row; i >= first[t] && start[t] + time[i] > this.moment - this.tail; i--) {
      ctx.lineTo(plan.px(X[i]), plan.py(Y[i]));
      if (fresh[i]) break;
    }
    ctx.stroke();
  }
}

// Names beside the last position of each target, unless the replay shows them elsewhere.
class Names {
  constructor(plan, replay, box) {
    Object.assign(this, { plan, replay, box });
    box.addEventListener("change", () => plan.drawOver());
  }

  draw(ctx) {
    const { plan, replay, box } = this;
    if (!box.checked || replay.moment !== null) return;
    const { first, X, Y, names } = plan.tracks;
    drawNames(ctx, plan, names.map((_, t) => {
      let end = first[t + 1] - 1;
      while (end > first[t] && X[end] !== X[end]) end--;
      return [t, plan.px(X[end]), plan.py(Y[end])];
    }).filter(([t]) => plan.boxes[t] !== NO_BOX));
  }
}

// Names at [target, x, y], the chosen one first; a name that would cover another is left out.
function drawNames(ctx, plan, places) {
  const { width, height } = plan.surface;
  const taken = [];
  const rank = ([t]) => Number(t !== plan.chosen);
  for (const [t, x, y] of [...places].sort((a, b) => rank(a) - rank(b))) {
    if (!(x > 0 && x < width && y > 0 && y < height)) continue;
    if (taken.some(([a, b]) => Math.abs(a - x) < 60 && Math.abs(b - y) < 16)) continue;
    taken.push([x, y]);
    drawLabel(ctx, plan.tracks.names[t], x + 9, y - 9);
  }
}
