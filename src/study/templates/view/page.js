// The state of the page, and what its buttons, keys and frames do.

const RATES = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const LONGEST = 12; // [s] that all frames take at first
const POLL = 1000; // [ms] between two questions to the server of a run that goes on
const at = (id) => document.getElementById(id);
const runs = await Promise.all(JSON.parse(at("runs").textContent).map(opened));
const state = { t: 0, playing: false, rate: 1, field: "", span: "most", range: {}, follow: true, off: new Set(), curves: [], loaded: [] };
const camera = newCamera();
let span, pictures, bounds, cursors = [], dirty = true;

function measure() {
  const first = runs.map((run) => run.frames[0].t), last = runs.map((run) => run.frames[run.frames.length - 1].t);
  // Gauges of a run that goes on, or was killed, are ahead of its frames.
  const ends = runs.flatMap((run) => run.curves.filter((curve) => curve.points).map((curve) => curve.values[2 * curve.points - 2]));
  span = [Math.min(...first), Math.max(...last, ...ends)];
  bounds = runs.map((run) => {
    const [low, high] = [[0, 1, 2].map(() => Infinity), [0, 1, 2].map(() => -Infinity)];
    let reach = 0;
    for (const frame of run.frames) {
      const end = frame.low.map((x, i) => x + 65535 * frame.step[i]);
      reach = Math.max(reach, Math.hypot(...frame.step) * 65535 / 2);
      for (let i = 0; i < 3; i++) { low[i] = Math.min(low[i], frame.low[i]); high[i] = Math.max(high[i], end[i]); }
    }
    const middle = low.map((x, i) => (x + high[i]) / 2);
    return { reach: reach || 1, middle, whole: Math.hypot(...high.map((x, i) => x - middle[i])) || 1 };
  });
}

// Cells and nodes by what the switches show. A surface or line is hidden by any of its groups; a side or node is shown
// by any.
function listsOf(run) {
  const shown = (name) => !state.off.has(name);
  const cellsOf = run.groups.filter((group) => !group.nodes), nodesOf = run.groups.filter((group) => group.nodes);
  const hidden = new Set(cellsOf.filter((g) => !shown(g.name)).flatMap((g) => g.classes));
  const drawn = new Set(cellsOf.filter((g) => g.sides && shown(g.name)).flatMap((g) => g.classes));
  const marked = new Set(nodesOf.filter((g) => shown(g.switch)).flatMap((g) => g.classes));
  const lists = { triangles: [], mesh: [], lines: [], dots: [] }, { corners, triangles, edges } = run;
  for (let cell = 0; cell < run.cells; cell++) {
    const kind = run.cellClasses[cell], off = hidden.has(kind);
    if (cell < triangles) {
      if (off || !shown("triangles")) { continue; }
      for (let i = 0; i < 3; i++) { lists.triangles.push(corners[3 * cell + i], cell); }
    } else if (cell < triangles + edges) {
      const place = 3 * triangles + 2 * (cell - triangles), ends = [corners[place], corners[place + 1], cell];
      if (!run.sides[cell]) { if (!off && shown("lines")) { lists.lines.push(...ends); } }
      else if (drawn.has(kind)) { lists.lines.push(...ends); }
      else if (shown("mesh")) { lists.mesh.push(...ends); }
    } else { lists.dots.push(corners[cell - triangles - edges + 3 * triangles + 2 * edges], cell); }
  }
  for (let node = 0; node < run.nodes; node++) { if (marked.has(run.nodeClasses[node])) { lists.dots.push(node, 0); } }
  return Object.fromEntries(Object.entries(lists).map(([name, list]) => [name, new Uint32Array(list)]));
}

// Tells groups of surfaces, of lines, of sides and of nodes apart; sides, and nodes beside others, are off at first.
function classify(run) {
  const surface = new Set(), line = new Set(), count = new Map();
  for (let cell = 0; cell < run.cells; cell++) {
    if (cell < run.triangles) { surface.add(run.cellClasses[cell]); }
    else if (cell < run.triangles + run.edges && !run.sides[cell]) { line.add(run.cellClasses[cell]); }
  }
  for (const kind of run.nodeClasses) { count.set(kind, (count.get(kind) || 0) + 1); }
  for (const group of run.groups) {
    group.switch = group.nodes ? `${group.name} (nodes)` : group.name;
    group.sides = !group.nodes && !group.classes.some((kind) => surface.has(kind) || line.has(kind));
    const nodes = group.classes.reduce((sum, kind) => sum + (count.get(kind) || 0), 0);
    if (group.sides || group.nodes && nodes > 1) { state.off.add(group.switch); }
  }
  run.ungrouped = surface.has(0) ? ["triangles"] : [];
  if (line.has(0)) { run.ungrouped.push("lines"); }
  if (run.sides.includes(1)) { run.ungrouped.push("mesh"); }
}

function fillGroups() {
  const names = [...new Set(runs.flatMap((run) => [...run.groups.map((group) => group.switch), ...run.ungrouped]))];
  at("groups").replaceChildren();
  for (const name of names) {
    const button = element("button", at("groups"), name, { "aria-pressed": !state.off.has(name), type: "button" });
    button.addEventListener("click", () => {
      if (!state.off.delete(name)) { state.off.add(name); }
      button.setAttribute("aria-pressed", !state.off.has(name));
      show();
    });
  }
}

function show() {
  runs.forEach((run, i) => {
    run.lists = listsOf(run);
    if (pictures[i]) { pictures[i].show(run.lists); }
  });
  dirty = true;
  soon();
}

// Fields that differ somewhere; a field that is the same everywhere has nothing to tell.
function fillFields() {
  const named = new Map(runs.flatMap((run) => run.fields.map((field) => [field.name, field])));
  const range = (name) => runs.reduce((seen, run) => joined(seen, rangeOf(run, name, run.frames)), null);
  const fields = [...named.values()].filter((field) => { const r = range(field.name); return r && r[1] > r[0]; });
  // A menu that is open stays open while frames come in.
  if (unchanged("field", fields.map((field) => field.name))) { return; }
  const before = state.field;
  at("field").replaceChildren();
  for (const field of fields) { element("option", at("field"), field.unit === "-" ? field.name : `${field.name} [${field.unit}]`, { value: field.name }); }
  element("option", at("field"), "nothing", { value: "" });
  state.field = fields.some((field) => field.name === before) ? before : fields.length ? fields[0].name : "";
  at("field").value = state.field;
}

// What the colours span: the values that are shown, of all frames or of the present one.
function colourRange() {
  if (state.span === "frame") {
    return runs.reduce((seen, run) => joined(seen, shownRange([run], [run.frames[frameAt(run, state.t)]], 0)), null);
  }
  const key = [state.field, state.span, [...state.off], runs.map((run) => run.frames.length)].join();
  if (state.range.key !== key) {
    state.range = { key, value: shownRange(runs, null, state.span === "most" ? 0.002 : 0) };
  }
  return state.range.value;
}

// The least and the largest value that is shown in some frames, or in all. A share of the values may lie beyond each.
function shownRange(of, frames, beyond) {
  const list = [];
  let range = null;
  for (const run of of) {
    const at = run.fields.findIndex((field) => field.name === state.field);
    if (at < 0) { continue; }
    const all = frames || run.frames, every = Math.ceil(all.length / 100);
    const on = run.fields[at].on, shown = run.lists;
    const numbers = on === "nodes" ? null : [...strided(shown.triangles, 6, 1), ...(on === "cells" ? strided(shown.lines, 3, 2) : [])];
    for (let i = 0; i < all.length; i += every) {
      const own = all[i].ranges[at], codes = all[i].values[at], seen = new Uint32Array(255);
      if (!own) { continue; }
      const [first, by] = rootsOf(own);
      if (numbers) { for (const cell of numbers) { if (codes[cell] < 255) { seen[codes[cell]]++; } } }
      else { for (const code of codes) { if (code < 255) { seen[code]++; } } }
      seen.forEach((count, code) => { if (count) { list.push([(first + by * code) ** 3, count]); } });
    }
  }
  for (const [value] of list) { range = joined(range, [value, value]); }
  if (!range || !beyond) { return range; }
  const most = beyond * list.reduce((sum, [, count]) => sum + count, 0);
  const end = () => { let left = most; return list.find(([, count]) => (left -= count) < 0)[0]; };
  list.sort((a, b) => a[0] - b[0]);
  const low = end();
  list.reverse();
  const high = end();
  return high > low ? [low, high] : range;
}

function strided(list, by, from) {
  const found = [];
  for (let i = from; i < list.length; i += by) { found.push(list[i]); }
  return found;
}

function drawBar(range) {
  const option = at("field").selectedOptions[0], text = range && state.field ? `${option.textContent}|${range}` : "";
  if (at("bar").dataset.told === text) { return; }
  at("bar").dataset.told = text;
  at("bar").replaceChildren();
  if (!text) { return; }
  element("span", at("bar"), option.textContent);
  const colours = MAP.map((c) => `rgb(${c.join(",")})`).join(",");
  element("div", at("bar"), undefined, { class: "map", style: `background: linear-gradient(to right, ${colours}); print-color-adjust: exact; -webkit-print-color-adjust: exact` });
  const places = element("div", at("bar"), undefined, { class: "ticks" }), spread = range[1] - range[0];
  // No number runs into those at the ends.
  const room = Math.max(0.1, 75 / Math.max(places.clientWidth, 1));
  const inner = ticks(range[0], range[1], 4).filter((v) => spread > 0 && Math.min(v - range[0], range[1] - v) > room * spread);
  for (const v of [range[0], ...inner, range[1]]) {
    const beyond = state.span === "most" ? { [range[0]]: "≤ ", [range[1]]: "≥ " }[v] || "" : "";
    element("span", places, beyond + figures(v, 3), { style: `left: ${spread > 0 ? 100 * (v - range[0]) / spread : 0}%` });
  }
}

// Draws the frames at the time of the page: all of them, or those that are not shown yet.
function draw() {
  const range = colourRange();
  let told = [];
  runs.forEach((run, i) => {
    const number = frameAt(run, state.t), frame = run.frames[number], picture = pictures[i];
    const field = run.fields.findIndex((f) => f.name === state.field), key = `${number} ${field}`;
    told.push(number);
    if (!picture || !dirty && state.loaded[i] === key) { return; }
    if (state.loaded[i] !== key) { picture.load(frame, field); state.loaded[i] = key; }
    const target = state.follow ? frame.low.map((x, k) => x + 32767.5 * frame.step[k]) : bounds[i].middle;
    const radius = Math.max(...bounds.map((b) => (state.follow ? b.reach : b.whole)));
    picture.draw(frame, field, range, target, radius, camera);
  });
  drawBar(range);
  const frames = told.map((number, i) => `${number + 1}/${runs[i].frames.length}`).join(" and ");
  at("clock").textContent = `t = ${figures(runs.length > 1 ? state.t : runs[0].frames[told[0]].t, 4)} s · frame ${frames}`;
  at("time").value = state.t;
  cursors.forEach((move) => move(state.t));
  dirty = false;
}

let waiting = 0;
function soon() { if (!waiting) { waiting = requestAnimationFrame((now) => { waiting = 0; tick(now); }); } }

let before = 0;
function tick(now) {
  if (state.playing) {
    state.t += Math.min((now - before) / 1000, 0.25) * state.rate;
    if (state.t > span[1]) { state.t = live && !runs[0].status ? span[1] : span[0]; }
    soon();
  }
  before = now;
  draw();
}

function seek(t) { state.t = Math.min(Math.max(t, span[0]), span[1]); dirty = true; soon(); }

// The frame so many after the present one, of the run with the most frames.
function step(by) {
  play(false);
  const run = runs.reduce((a, b) => (b.frames.length > a.frames.length ? b : a));
  const number = Math.min(Math.max(frameAt(run, state.t) + by, 0), run.frames.length - 1);
  seek(run.frames[number].t);
}

function play(on) {
  state.playing = on;
  if (on && state.t >= span[1] && !(live && !runs[0].status)) { state.t = span[0]; }
  at("play").setAttribute("aria-pressed", on);
  before = performance.now();
  soon();
}

function drawCharts() {
  at("charts").replaceChildren();
  const keys = state.curves.filter((key) => runs.some((run) => run.curves.some((curve) => curve.key === key)));
  cursors = keys.map((key) => chartOf(at("charts"), runs, key, span, (t) => { play(false); seek(t); }));
  dirty = true;
  soon();
}

// Whether the children of an element were made from the same names before.
function unchanged(id, names) {
  const before = at(id).dataset.names;
  at(id).dataset.names = names.join("\n");
  return before === at(id).dataset.names;
}

function fillCurves() {
  if (unchanged("list", keysOf(runs).map((curve) => curve.key))) { return; }
  at("list").replaceChildren();
  at("list").classList.toggle("none", keysOf(runs).length === 0);
  for (const { key, label: words } of keysOf(runs)) {
    const label = element("label", at("list")), box = element("input", label, undefined, { type: "checkbox" });
    label.append(" " + words);
    box.checked = state.curves.includes(key);
    box.addEventListener("change", () => {
      state.curves = box.checked ? [...state.curves, key] : state.curves.filter((other) => other !== key);
      drawCharts();
    });
  }
}

function tell() {
  const words = runs.map((run) => {
    const parts = [[run.nodes, "node"], [run.triangles, "triangle"], [run.edges, "edge"]].filter(([n]) => n);
    const method = [run.method, run.status.replace("-", " ") || "no summary yet"].filter((word) => word).join(", ");
    return `${runs.length > 1 ? run.name + ": " : ""}${method}; ${parts.map(([n, what]) => `${n.toLocaleString("en")} ${what}${n > 1 ? "s" : ""}`).join(", ")}`;
  });
  at("state").textContent = words.join(" · ");
  at("notes").replaceChildren();
  runs.forEach((run) => run.notes.forEach((note) => element("li", at("notes"), runs.length > 1 ? `${run.name}: ${note}` : note)));
  const off = Math.max(...runs.flatMap((run) => run.frames.flatMap((frame) => frame.step))) / 2;
  at("about").textContent = `Positions are rounded by at most ${figures(off * 1000, 2)} mm along an axis (16 bits over the box of each frame), colours to a ` +
    "254th of their range in each frame. Frames are those of the run; nothing between them is made up. Curves have at most about 2000 points, " +
    "with every peak. canopy-fem made this page; it holds all that it needs and asks no network.";
}

function start() {
  measure();
  state.t = span[0];
  const scenes = at("scenes");
  scenes.classList.toggle("two", runs.length > 1);
  pictures = runs.map((run, i) => {
    classify(run);
    const figure = element("figure", scenes);
    const canvas = element("canvas", figure, undefined, { role: "img", tabindex: 0, "aria-label": `${run.name} in 3D` });
    if (runs.length > 1) { element("figcaption", figure, run.name, { class: `key-${i}` }); }
    const picture = pictureOf(canvas, run);
    if (!picture) {
      figure.replaceChildren();
      element("p", figure, "This browser has no WebGL 2, so the scene cannot be drawn. The curves are below.", { class: "none" });
      return null;
    }
    steer(canvas, camera, () => { dirty = true; soon(); });
    canvas.addEventListener("dblclick", reset);
    new ResizeObserver(() => { dirty = true; soon(); }).observe(canvas);
    return picture;
  });
  const small = runs.every((run) => run.triangles < 4000);
  if (!small) { state.off.add("mesh"); }
  // A scene that stays where it is needs no following.
  const travels = bounds.some((b) => b.whole > 1.3 * b.reach);
  state.follow = at("follow").checked = travels;
  at("followed").hidden = !travels;
  const still = runs.every((run) => run.frames.length < 2) && !live;
  document.querySelector(".player").hidden = still;
  for (const rate of RATES) { element("option", at("rate"), `${rate} ×`, { value: rate }); }
  state.rate = RATES.reduce((best, rate) => (Math.abs(Math.log((span[1] - span[0]) / rate / LONGEST)) < Math.abs(Math.log((span[1] - span[0]) / best / LONGEST)) ? rate : best));
  if ((span[1] - span[0]) <= LONGEST && (span[1] - span[0]) >= 4) { state.rate = 1; }
  at("rate").value = state.rate;
  state.curves = firstKeys(runs);
  at("switches").open = innerWidth > 820;
  at("switches").hidden = runs.every((run) => run.groups.length + run.ungrouped.length === 0);
  fillGroups();
  show();
  refresh();
  listen();
}

// All that depends on the number of frames.
function refresh() {
  measure();
  [at("time").min, at("time").max] = span;
  fillFields();
  fillCurves();
  drawCharts();
  tell();
}

function reset() { Object.assign(camera, newCamera()); dirty = true; soon(); }

function listen() {
  at("play").addEventListener("click", () => play(!state.playing));
  at("back").addEventListener("click", () => step(-1));
  at("on").addEventListener("click", () => step(1));
  at("time").addEventListener("input", (event) => { play(false); seek(Number(event.target.value)); });
  at("field").addEventListener("change", (event) => { state.field = event.target.value; dirty = true; soon(); });
  at("span").addEventListener("change", (event) => { state.span = event.target.value; dirty = true; soon(); });
  at("rate").addEventListener("change", (event) => { state.rate = Number(event.target.value); });
  at("follow").addEventListener("change", (event) => { state.follow = event.target.checked; dirty = true; soon(); });
  at("reset").addEventListener("click", reset);
  const keys = {
    " ": () => play(!state.playing),
    ArrowLeft: (event) => step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => step(event.shiftKey ? 10 : 1),
    Home: () => step(-Infinity),
    End: () => step(Infinity),
    "+": () => { zoomed(camera, 1.2); dirty = true; soon(); },
    "-": () => { zoomed(camera, 1 / 1.2); dirty = true; soon(); },
    0: reset,
  };
  document.addEventListener("keydown", (event) => {
    const { tagName, type } = event.target;
    const own = tagName === "SELECT" || tagName === "SUMMARY" || tagName === "INPUT" && type !== "range" || tagName === "BUTTON" && event.key === " ";
    if (own || event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) { return; }
    event.preventDefault();
    keys[event.key](event);
  });
  let width = innerWidth;
  addEventListener("resize", () => { dirty = true; if (innerWidth !== width) { width = innerWidth; drawCharts(); } soon(); });
  addEventListener("beforeprint", () => { drawCharts(); dirty = true; draw(); });
  if (live && !runs[0].status) { setTimeout(ask, POLL); }
}

// Asks the server of a run that goes on for new frames.
async function ask() {
  const run = runs[0], last = state.t >= span[1];
  try {
    const answer = await fetch(`part?from=${run.next}`);
    if (!answer.ok) { throw new Error(await answer.text()); }
    const part = await answer.json(), more = part.frames.length > 0;
    await extend(run, part);
    refresh();
    if (more && last) { state.t = span[1]; }
    dirty = true;
    soon();
    if (!run.status || run.next < run.listed) { setTimeout(ask, run.next < run.listed ? 0 : POLL); }
  } catch (error) {
    run.notes = [`The server does not answer any more (${error.message}). What it sent so far is shown.`];
    tell();
  }
}

start();
// For tests: what is shown, and a frame drawn at once.
window.canopyView = { runs, state, camera, pictures, span: () => span, seek: (t) => { seek(t); draw(); } };
