// A camera that turns about a point, z up, and the pointers that move it.

const ANGLE = 0.5; // [rad] between the upper and the lower edge of a picture
const START = { yaw: 0.6, pitch: 0.18, zoom: 1, pan: [0, 0] };

function newCamera() { return { ...START, pan: [0, 0] }; }

function axesOf(camera) {
  const [cy, sy, cp, sp] = [Math.cos(camera.yaw), Math.sin(camera.yaw), Math.cos(camera.pitch), Math.sin(camera.pitch)];
  return { right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp], back: [cp * cy, cp * sy, sp] };
}

// Matrices, column by column, of a scene of a radius about the point that the camera looks at.
function matricesOf(camera, radius, aspect) {
  const { right, up, back } = axesOf(camera), wide = Math.min(1, aspect);
  const far = radius / Math.sin(ANGLE / 2) / wide / camera.zoom;
  const [near, end] = [Math.max(far - 3 * radius, far / 100), far + 3 * radius];
  const scale = 1 / Math.tan(ANGLE / 2);
  const view = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -camera.pan[0] * radius, -camera.pan[1] * radius, -far, 1];
  const lens = [scale / aspect, 0, 0, 0, 0, scale, 0, 0, 0, 0, (end + near) / (near - end), -1, 0, 0, 2 * end * near / (near - end), 0];
  return { view: new Float32Array(view), lens: new Float32Array(lens) };
}

// [1] A pixel of a picture so high, as a share of the radius.
function pixel(camera, height) { return 2 / Math.cos(ANGLE / 2) / camera.zoom / height; }

function zoomed(camera, factor) { camera.zoom = Math.min(200, Math.max(0.1, camera.zoom * factor)); }

function moved(camera, dx, dy, height) {
  camera.pan[0] -= dx * pixel(camera, height);
  camera.pan[1] += dy * pixel(camera, height);
}

// Turns, moves and zooms a camera by pointers over a picture.
function steer(canvas, camera, changed) {
  const held = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) { return; }
    const now = [event.clientX, event.clientY], [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    held.set(event.pointerId, now);
    if (held.size > 1) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      zoomed(camera, apart(now) / Math.max(apart(before), 1));
      moved(camera, dx / 2, dy / 2, canvas.clientHeight);
    } else if (event.shiftKey || event.buttons & 6) {
      moved(camera, dx, dy, canvas.clientHeight);
    } else {
      camera.yaw -= dx * 0.008;
      camera.pitch = Math.min(1.57, Math.max(-1.57, camera.pitch + dy * 0.008));
    }
    changed();
  });
  for (const end of ["pointerup", "pointercancel"]) { canvas.addEventListener(end, (event) => held.delete(event.pointerId)); }
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomed(camera, Math.exp(-event.deltaY * (event.deltaMode ? 0.03 : 0.0015)));
    changed();
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}
