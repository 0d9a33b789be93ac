// Runs from the bytes of the page. What the bytes are: src/study/view/scene.rs and packed.rs.

async function inflated(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) { packed[i] = letters.charCodeAt(i); }
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

async function opened(view) {
  const [nodes, triangles, edges, dots] = view.counts, cells = triangles + edges + dots;
  const bytes = await inflated(view.topology), corners = 3 * triangles + 2 * edges + dots;
  const run = {
    name: view.name, method: view.method, nodes, triangles, edges, dots, cells, groups: view.groups, fields: view.fields,
    corners: new Uint32Array(bytes, 0, corners),
    cellClasses: new Uint16Array(bytes, 4 * corners, cells),
    nodeClasses: new Uint16Array(bytes, 4 * corners + 2 * cells, nodes),
    sides: new Uint8Array(bytes, 4 * corners + 2 * cells + 2 * nodes, cells),
    frames: [], curves: [], notes: [],
  };
  await extend(run, view.part);
  return run;
}

// Adds frames, and replaces curves and notes.
async function extend(run, part) {
  const count = { cells: run.cells, triangles: run.triangles, nodes: run.nodes };
  const bytes = await inflated(part.data);
  let at = 0;
  for (const head of part.frames) {
    const frame = { ...head, positions: new Uint16Array(bytes, at, 3 * run.nodes), values: [] };
    at += 6 * run.nodes;
    for (const field of run.fields) {
      frame.values.push(new Uint8Array(bytes, at, count[field.on]));
      at += count[field.on];
    }
    at += at % 2;
    run.frames.push(frame);
  }
  Object.assign(run, { status: part.status, notes: part.notes, next: part.next, listed: part.listed });
  const numbers = new Float32Array(await inflated(part.curves.data));
  let from = 0;
  run.curves = part.curves.heads.map((head) => {
    const points = numbers.subarray(from, from + 2 * head.points);
    from += 2 * head.points;
    return { ...head, key: (head.name + " " + head.quantity).trim(), values: points };
  });
}

// The last frame that is not after a time.
function frameAt(run, t) {
  let low = 0, high = run.frames.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (run.frames[middle].t <= t + 1e-9) { low = middle; } else { high = middle; }
  }
  return low;
}

// The value of a curve at a time, straight between two points.
function valueAt(curve, t) {
  const v = curve.values;
  let low = 0, high = curve.points;
  if (!high || t < v[0] || t > v[2 * high - 2] + 1e-6) { return NaN; }
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (v[2 * middle] <= t) { low = middle; } else { high = middle; }
  }
  if (low + 1 >= curve.points) { return v[2 * low + 1]; }
  const share = (t - v[2 * low]) / (v[2 * low + 2] - v[2 * low]);
  return v[2 * low + 1] + share * (v[2 * low + 3] - v[2 * low + 1]);
}

// The least and the largest value of a field in some frames; null if there is none.
function rangeOf(run, name, frames) {
  const at = run.fields.findIndex((field) => field.name === name);
  return frames.reduce((seen, frame) => joined(seen, at < 0 ? null : frame.ranges[at]), null);
}

// The cube root of a value is x + y code.
function rootsOf(range) {
  const [first, last] = range.map(Math.cbrt);
  return [first, (last - first) / 254];
}

function joined(a, b) {
  if (!a || !b) { return a || b; }
  return [Math.min(a[0], b[0]), Math.max(a[1], b[1])];
}

// A number of a few digits for people.
function figures(x, digits = 4) {
  if (!Number.isFinite(x)) { return "-"; }
  if (x === 0) { return "0"; }
  const size = Math.abs(x);
  if (size < 1e-3 || size >= 1e6) { return x.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e"); }
  return String(Number(x.toPrecision(digits)));
}

// About so many round numbers from low to high.
function ticks(low, high, about) {
  const rough = (high - low) / about, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough * 0.999);
  const found = [];
  if (!(step > 0) || !Number.isFinite(step)) { return found; }
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; i++) { found.push(i * step); }
  return found;
}
