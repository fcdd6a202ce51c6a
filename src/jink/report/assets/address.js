// The part of the address behind "#": target=NAME&from=SECONDS&to=SECONDS&units=nautical.

function readAddress(hash) {
  const found = {};
  for (const pair of hash.replace(/^#/, "").split("&")) {
    const at = pair.indexOf("=");
    if (at < 0) continue;
    try {
      found[pair.slice(0, at)] = decodeURIComponent(pair.slice(at + 1));
    } catch { /* not an address of ours */ }
  }
  return { ...found, from: Number(found.from ?? NaN), to: Number(found.to ?? NaN) };
}

function writeAddress(parts) {
  const known = Object.entries(parts).filter(([, value]) => value !== undefined);
  const text = known.map(([name, value]) => `${name}=${encodeURIComponent(typeof value === "number" ? value.toFixed(3) : value)}`);
  try {
    history.replaceState(null, "", `#${text.join("&")}`);
  } catch { /* some browsers refuse this for files */ }
}
