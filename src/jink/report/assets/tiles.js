// Tiles of a map server below everything else, where the page names one: Web Mercator, laid on the plan's plane.

const TILE = 256; // pixels
const DEEPEST = 19;
const MOST_TILES = 400; // that are kept
const MERCATOR_EDGE = 85.05; // degrees

class Tiles {
  constructor(plan, url) {
    Object.assign(this, { plan, url, images: new Map(), failed: false });
    this.host = new URL(url).host;
  }

  // Columns and rows of tiles that cover the view, at the zoom whose pixels are nearest to those of the screen.
  draw(ctx) {
    const { plan } = this, { frame, surface, view } = plan;
    const rad = Math.PI / 180, perDegree = rad * frame.radius, squeeze = perDegree * Math.cos(frame.latitude * rad);
    const [left, bottom] = plan.metres(0, surface.height), [right, top] = plan.metres(surface.width, 0);
    const latitude = (y) => Math.max(-MERCATOR_EDGE, Math.min(MERCATOR_EDGE, frame.latitude + y / perDegree));
    const here = Math.cos(latitude(view.y) * rad);
    const z = Math.max(0, Math.min(DEEPEST, Math.round(Math.log2((2 * Math.PI * frame.radius * here * view.k) / TILE))));
    const count = 2 ** z;
    const column = (x) => ((frame.longitude + x / squeeze + 180) / 360) * count;
    const row = (y) => ((1 - Math.asinh(Math.tan(latitude(y) * rad)) / Math.PI) / 2) * count;
    const px = (c) => plan.px(((c / count) * 360 - 180 - frame.longitude) * squeeze);
    const py = (r) => plan.py((Math.atan(Math.sinh(Math.PI * (1 - (2 * r) / count))) / rad - frame.latitude) * perDegree);
    ctx.globalAlpha = 0.75;
    for (let r = Math.floor(row(top)); r <= Math.min(count - 1, Math.floor(row(bottom))); r++) {
      for (let c = Math.floor(column(left)); c <= Math.floor(column(right)); c++) {
        const image = this.tile(z, ((c % count) + count) % count, r);
        if (!image) continue;
        const x = Math.floor(px(c)), y = Math.floor(py(r));
        ctx.drawImage(image, x, y, Math.ceil(px(c + 1)) - x, Math.ceil(py(r + 1)) - y);
      }
    }
    ctx.globalAlpha = 1;
    this.say(ctx);
  }

  // The picture of a tile once it is there; it is asked for when it is first wanted.
  tile(z, x, y) {
    const key = `${z}/${x}/${y}`;
    let image = this.images.get(key);
    if (!image) {
      image = new Image();
      image.crossOrigin = "anonymous"; // so that the view can still be saved as a picture
      image.onload = () => { this.failed = false; this.plan.surface.schedule(); };
      image.onerror = () => { this.failed = true; this.plan.surface.schedule(); };
      image.src = this.url.replace("{z}", z).replace("{x}", x).replace("{y}", y);
      this.images.set(key, image);
      if (this.images.size > MOST_TILES) this.images.delete(this.images.keys().next().value);
    }
    return image.complete && image.naturalWidth > 0 ? image : null;
  }

  say(ctx) {
    const { surface } = this.plan;
    ctx.font = theme.font;
    ctx.fillStyle = this.failed ? theme.warn : theme.muted;
    ctx.textAlign = "right";
    ctx.textBaseline = "top";
    ctx.fillText(this.failed ? `no map from ${this.host}` : `map: ${this.host}`, surface.width - 8, 18);
    ctx.textAlign = "left";
  }
}
