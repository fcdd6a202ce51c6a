// Units and text: everything in the data is SI (angles in degrees); units are a matter of display.

const UNITS = {
  si: {
    speed: ["m/s", 1], height: ["m", 1], climb: ["m/s", 1], acceleration: ["m/s²", 1], distance: ["km", 1e-3], length: ["m", 1],
  },
  nautical: {
    speed: ["kt", 3600 / 1852], height: ["ft", 1 / 0.3048], climb: ["ft/min", 60 / 0.3048], acceleration: ["g", 1 / 9.80665],
    distance: ["NM", 1 / 1852], length: ["m", 1],
  },
};
const FIXED_UNITS = { turn_rate: ["°/s", 1], course: ["°", 1], probability: ["", 1], nis: ["", 1] };

function unitOf(quantity, system) {
  return UNITS[system][quantity] || FIXED_UNITS[quantity] || ["", 1];
}

// About `digits` significant digits, without exponents for everyday sizes.
function formatNumber(value, digits = 3) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size >= 7 || size < -5) return value.toExponential(digits - 1).replace("-", "−");
  const decimals = Math.min(Math.max(digits - 1 - size, 0), 6);
  const text = Math.abs(value).toFixed(decimals);
  return (value < 0 && Number(text) !== 0 ? "−" : "") + (size >= 4 ? groupThousands(text) : text);
}

function formatFixed(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = Math.abs(value).toFixed(decimals);
  return (value < 0 && Number(text) !== 0 ? "−" : "") + (Math.abs(value) >= 1e4 ? groupThousands(text) : text);
}

function groupThousands(text) {
  return text.replace(/^\d+/, (whole) => whole.replace(/\B(?=(\d{3})+$)/g, "\u202f"));
}

function formatShare(value, decimals = 0) {
  return Number.isFinite(value) ? `${(100 * value).toFixed(decimals)}\u202f%` : "–";
}

function formatDuration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 60) return `${formatNumber(seconds, 3)} s`;
  const s = Math.round(seconds);
  const two = (n) => String(n).padStart(2, "0");
  if (s < 3600) return `${Math.floor(s / 60)} min ${two(s % 60)} s`;
  const minutes = Math.round(seconds / 60);
  if (minutes < 48 * 60) return `${Math.floor(minutes / 60)} h ${two(minutes % 60)} min`;
  const hours = Math.round(seconds / 3600);
  return `${Math.floor(hours / 24)} d ${two(hours % 24)} h`;
}

// A moment as text: UTC when the data has dates, else seconds.
function formatTime(seconds, clock, { date = false, step = 1 } = {}) {
  if (!Number.isFinite(seconds)) return "–";
  if (!clock) return `${formatFixed(seconds, step < 1 ? Math.min(6, Math.ceil(-Math.log10(step))) : 0)} s`;
  const moment = new Date(Math.round(seconds * 1000));
  if (Number.isNaN(moment.getTime())) return `${formatNumber(seconds, 6)} s`;
  const text = moment.toISOString();
  const time = step >= 60 && seconds % 60 === 0 ? text.slice(11, 16) : text.slice(11, step < 1 ? 23 : 19);
  return date ? `${text.slice(0, 10)} ${time}` : time;
}

function formatAngle(degrees, positive, negative, decimals) {
  return `${Math.abs(degrees).toFixed(decimals)}°${degrees === 0 ? "" : degrees > 0 ? positive : negative}`;
}

// About `count` round values within [low, high].
function niceTicks(low, high, count) {
  if (!(high > low) || count < 1) return { step: 1, ticks: [] };
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 2.5, 5, 10].find((m) => m * power >= raw * 0.999);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) ticks.push(k * step);
  return { step, ticks };
}

// Decimals that tell neighbouring ticks apart.
function decimalsOf(step) {
  for (let d = 0; d < 7; d++) if (Math.abs(step * 10 ** d - Math.round(step * 10 ** d)) < 1e-6) return d;
  return 7;
}

const TIME_STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, 86400];

// Like niceTicks, on whole seconds, minutes, hours and days when the axis is a clock.
function timeTicks(low, high, count, clock) {
  const raw = (high - low) / Math.max(count, 1);
  if (!clock || raw < 1 || raw > 86400) return niceTicks(low, high, count);
  const step = TIME_STEPS.find((s) => s >= raw);
  const ticks = [];
  for (let t = Math.ceil(low / step) * step; t <= high; t += step) ticks.push(t);
  return { step, ticks };
}

// "constant velocity 2" to "CV2", for narrow screens.
function initialsOf(label) {
  return label.split(" ").map((word) => word[0].toUpperCase()).join("");
}
