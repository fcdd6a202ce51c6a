// Two stacked canvases in a host element (drawing below, pointer layer above), kept sharp and sized with it.

class Surface {
  constructor(host, label, redraw) {
    this.host = host;
    this.redraw = redraw;
    this.baseCanvas = document.createElement("canvas");
    this.overCanvas = document.createElement("canvas");
    this.overCanvas.className = "over";
    this.overCanvas.tabIndex = 0;
    this.overCanvas.setAttribute("role", "application");
    this.overCanvas.setAttribute("aria-label", label);
    host.prepend(this.baseCanvas, this.overCanvas);
    this.base = this.baseCanvas.getContext("2d");
    this.over = this.overCanvas.getContext("2d");
    this.width = this.height = 0;
    this.pending = false;
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  resize() {
    const { width, height } = this.host.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    if (width === this.width && height === this.height && ratio === this.ratio) return;
    Object.assign(this, { width, height, ratio });
    for (const canvas of [this.baseCanvas, this.overCanvas]) {
      canvas.width = Math.max(1, Math.round(width * ratio));
      canvas.height = Math.max(1, Math.round(height * ratio));
    }
    this.base.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.over.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.schedule();
  }

  schedule() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      if (this.width > 0 && this.height > 0) this.redraw();
    });
  }

  clear(context) {
    context.clearRect(0, 0, this.width, this.height);
  }

  at(event) {
    const box = this.overCanvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
}

const theme = { bins: 24 };

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const get = (name) => style.getPropertyValue(`--${name}`).trim();
  for (const name of ["panel", "ink", "muted", "line", "grid", "accent", "second", "dot", "warn", "halo", "coast", "border", "lake", "good", "clutter"]) theme[name] = get(name);
  theme.modes = Array.from({ length: 8 }, (_, i) => get(`mode-${i}`));
  const stops = [0, 1, 2].map((i) => hexToRgb(get(`ramp-${i}`)));
  theme.ramp = Array.from({ length: theme.bins }, (_, i) => {
    const u = (2 * i) / (theme.bins - 1);
    const [a, b] = u <= 1 ? [stops[0], stops[1]] : [stops[1], stops[2]];
    const f = u <= 1 ? u : u - 1;
    return `rgb(${a.map((v, k) => Math.round(v + f * (b[k] - v))).join(",")})`;
  });
  theme.font = `11px ${get("font")}`;
}

function hexToRgb(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [(n >> 16) & 255, (n >> 8) & 255, n & 255];
}

// Runs `step(fraction)` over `duration` ms, at once for those who prefer no motion.
function animate(duration, step) {
  const token = { cancelled: false };
  if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
    step(1);
    return token;
  }
  const start = performance.now();
  const tick = (now) => {
    if (token.cancelled) return;
    const u = Math.min(1, Math.max(0, (now - start) / duration));
    step(u * u * (3 - 2 * u));
    if (u < 1) requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
  return token;
}
