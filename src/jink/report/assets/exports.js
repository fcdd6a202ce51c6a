// What leaves the page: the plan view as PNG, the chosen target's drawn rows as CSV.

function saveAs(name, blob) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const fileName = (text) => text.replace(/[^\p{L}\p{N}._-]+/gu, "-").slice(0, 80) || "target";

function planAsPng(plan) {
  const { baseCanvas, overCanvas } = (plan.instead || plan).surface;
  const canvas = Object.assign(document.createElement("canvas"), { width: baseCanvas.width, height: baseCanvas.height });
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = theme.panel;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.drawImage(baseCanvas, 0, 0);
  ctx.drawImage(overCanvas, 0, 0);
  canvas.toBlob((blob) => saveAs("plan.png", blob));
}

// Text of one cell: quoted where CSV asks for it, and where a spreadsheet would run it.
function csvCell(value) {
  const text = String(value ?? "");
  const safe = typeof value === "string" && /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

// Rows [from, to) of a target, in SI units and degrees.
function rowsAsCsv(tracks, target, from, to) {
  const { meta, X, Y, time, start, status } = tracks;
  const { frame } = meta;
  const curves = meta.panels.flatMap(({ key, curves }) => curves.map(({ label, value, sd }) => [curves.length > 1 ? `${key}_${label}` : key, value, sd]));
  const number = (v) => (v === v ? String(Number(v.toPrecision(8))) : "");
  const head = ["target", "time", ...(frame ? ["latitude", "longitude"] : ["x", "y"]), "status", "manoeuvring"];
  for (const [name] of curves) head.push(name.replaceAll(" ", "_"), `${name.replaceAll(" ", "_")}_sd`);
  const lines = [head.map(csvCell).join(",")];
  for (let i = from; i < to; i++) {
    const place = frame ? geographic(frame, X[i], Y[i]).map((v) => (v === v ? v.toFixed(7) : "")) : [number(X[i]), number(Y[i])];
    const seconds = start[target] + time[i];
    const moment = meta.clock ? new Date(seconds * 1000).toISOString() : number(seconds);
    const cells = [csvCell(tracks.names[target]), moment, ...place, meta.statuses[status[i]], number(tracks.manoeuvring(i))];
    for (const [, value, sd] of curves) cells.push(number(tracks.arrays[value][i]), number(tracks.arrays[sd][i]));
    lines.push(cells.join(","));
  }
  return `${lines.join("\n")}\n`;
}

// [latitude, longitude] in degrees of a point of the plan.
function geographic({ latitude, longitude, radius }, x, y) {
  const perDegree = (Math.PI / 180) * radius;
  const east = longitude + x / (perDegree * Math.cos((latitude * Math.PI) / 180));
  return [latitude + y / perDegree, ((((east + 180) % 360) + 360) % 360) - 180];
}
