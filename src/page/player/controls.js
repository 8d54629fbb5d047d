// Mouse, touch and keys, which move the camera.

// Angles are in radians for a drag over the height of the picture, and for a key.
const TURN = 3;
const KEY_TURN = 0.1;
const KEY_SHIFT = 0.05;
const KEY_SHARE = 0.9;

// Moves the camera as the canvas is dragged or keys are pressed. `moved` is called after each step.
export function control(canvas, camera, moved) {
  const pointers = new Map();
  const middle = () => [...pointers.values()].reduce(([x, y], [a, b]) => [x + a / pointers.size, y + b / pointers.size], [0, 0]);
  const spread = ([[x, y], [a, b]] = [...pointers.values()]) => Math.max(Math.hypot(x - a, y - b), 1);
  const step = act => moved(act());
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", event => {
    if (!pointers.has(event.pointerId)) return;
    const [before, apart] = [middle(), pointers.size === 2 ? spread() : 1];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const [x, y] = middle().map((now, axis) => (now - before[axis]) / canvas.clientHeight);
    const shifts = pointers.size === 2 || event.buttons === 2 || event.buttons === 4 || event.shiftKey;
    step(() => {
      if (shifts) camera.pan(-x, y);
      else camera.orbit(-TURN * x, -TURN * y);
      if (pointers.size === 2) camera.dolly(apart / spread());
    });
  });
  ["pointerup", "pointercancel"].forEach(name => canvas.addEventListener(name, event => pointers.delete(event.pointerId)));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    step(() => camera.dolly(Math.exp(0.001 * lines * event.deltaY)));
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const nearer = () => camera.dolly(KEY_SHARE);
    const acts = { "+": nearer, "=": nearer, "-": () => camera.dolly(1 / KEY_SHARE), 0: () => camera.reset() };
    const ofArrow = arrow && (() => (event.shiftKey ? camera.pan(...arrow.map(v => KEY_SHIFT * v)) : camera.orbit(KEY_TURN * arrow[0], -KEY_TURN * arrow[1])));
    const act = ofArrow ?? acts[event.key];
    if (!act || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    step(act);
  });
}
