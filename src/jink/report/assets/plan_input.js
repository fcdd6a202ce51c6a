// Pointer and keyboard of the plan view.

// Drag pans, two fingers or the wheel zoom, a click chooses, hovering tells.
function listenToPlan(plan) {
  const canvas = plan.surface.overCanvas;
  const held = new Map();
  let moved = 0, measuring = false;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, plan.surface.at(event));
    if (held.size === 1) moved = 0;
    measuring = held.size === 1 && (plan.measure.on || event.shiftKey);
    if (measuring) plan.measure.begin(...plan.surface.at(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = plan.surface.at(event);
    if (!held.has(event.pointerId)) return plan.hover(x, y);
    const [ox, oy] = held.get(event.pointerId);
    moved += Math.abs(x - ox) + Math.abs(y - oy);
    const others = [...held].filter(([id]) => id !== event.pointerId);
    held.set(event.pointerId, [x, y]);
    if (moved < 4) return;
    plan.tip.hidden = true;
    if (measuring) return plan.measure.move(x, y);
    if (others.length === 0) return plan.pan(x - ox, y - oy);
    const [, [px, py]] = others[0];
    plan.zoom(Math.hypot(x - px, y - py) / Math.max(1, Math.hypot(ox - px, oy - py)), (x + px) / 2, (y + py) / 2);
  });
  const release = (event) => {
    if (event.type === "pointerup" && held.size === 1 && moved < 4) {
      const hit = plan.pick(...plan.surface.at(event), event.pointerType === "touch" ? 24 : 14);
      if (hit) plan.onChoose(hit[0]);
    }
    held.delete(event.pointerId);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("blur", () => { plan.tip.hidden = true; });
  canvas.addEventListener("pointerleave", () => { plan.tip.hidden = true; });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    plan.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0018)), ...plan.surface.at(event));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => planKey(plan, event));
}

function planKey(plan, event) {
  const { width, height } = plan.surface;
  const actions = {
    ArrowLeft: () => plan.pan(60, 0), ArrowRight: () => plan.pan(-60, 0), ArrowUp: () => plan.pan(0, 60), ArrowDown: () => plan.pan(0, -60),
    "+": () => plan.zoom(1.4, width / 2, height / 2), "=": () => plan.zoom(1.4, width / 2, height / 2),
    "-": () => plan.zoom(1 / 1.4, width / 2, height / 2), 0: () => plan.fitAll(), Enter: () => plan.fitChosen(),
    Escape: () => plan.measure.switch(plan.measure.on),
  };
  if (event.ctrlKey || event.metaKey || !actions[event.key]) return;
  event.preventDefault();
  actions[event.key]();
}
