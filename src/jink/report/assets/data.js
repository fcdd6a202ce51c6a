// The page's data: JSON next to one block of gzip-compressed typed arrays (see arrays.py).

const BYTES = { f4: 4, f8: 8, i4: 4, u1: 1 };
const VIEWS = { f4: Float32Array, f8: Float64Array, i4: Int32Array, u1: Uint8Array };

async function loadData() {
  const meta = JSON.parse(document.getElementById("meta").textContent);
  const holder = document.getElementById("block");
  const text = atob(holder.textContent.trim());
  holder.remove();
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  if (typeof DecompressionStream === "undefined") {
    throw new Error("this browser cannot unpack the data; use Chrome 80, Firefox 113, Safari 16.4 or a later one");
  }
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const arrays = {};
  for (const [name, entry] of Object.entries(meta.arrays)) arrays[name] = unpack(bytes, entry);
  return { meta, arrays };
}

// Bytes were grouped by significance; put each number's bytes together again (little-endian, as browsers are).
function unpack(bytes, { type, start, length }) {
  const width = BYTES[type];
  const out = new Uint8Array(length * width);
  for (let b = 0; b < width; b++) {
    const from = start + b * length;
    for (let i = 0, o = b; i < length; i++, o += width) out[o] = bytes[from + i];
  }
  return new VIEWS[type](out.buffer);
}

// Index of the last entry <= value in the sorted slice [from, to), or from when all are larger.
function lastAtMost(sorted, value, from, to) {
  let low = from, high = to;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle; else high = middle;
  }
  return low;
}
