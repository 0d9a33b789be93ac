// Charts of gauges over time: the curves of all runs, their peaks, and a cursor at the time of the frame.

const MARGIN = { left: 48, right: 10, top: 8, bottom: 18 }, HEIGHT = 128, FIRST = 4;

function svg(name, attributes, within, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) { made.setAttribute(key, value); }
  if (text !== undefined) { made.textContent = text; }
  return within.appendChild(made);
}

function element(name, within, text, attributes = {}) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) { made.setAttribute(key, value); }
  if (text !== undefined) { made.textContent = text; }
  return within.appendChild(made);
}

// All names of curves, those to be shown first before the others.
function keysOf(runs) {
  const heads = new Map();
  for (const curve of runs.flatMap((run) => run.curves)) { if (!heads.has(curve.key)) { heads.set(curve.key, curve); } }
  return [...heads.values()];
}

function firstKeys(runs) {
  // A curve that is 0 throughout has nothing to tell.
  const all = keysOf(runs).filter((curve) => curve.peak && curve.peak[1] !== 0), told = all.filter((curve) => curve.first);
  // The opening load is what people look for.
  const later = (curve) => (curve.quantity === "drag" ? 0 : 1);
  told.sort((a, b) => later(a) - later(b));
  return (told.length ? told : all).slice(0, FIRST).map((curve) => curve.key);
}

// A chart of a curve of all runs; `seek` goes to a time. It returns what moves its cursor.
function chartOf(within, runs, key, span, seek) {
  const figure = element("figure", within), caption = element("figcaption", figure);
  const curves = runs.map((run) => run.curves.find((curve) => curve.key === key));
  const { unit, label } = curves.find((curve) => curve), measure = unit && unit !== "-" ? ` ${unit}` : "";
  element("b", caption, measure ? `${label} [${unit}]` : label);
  const width = Math.max(figure.clientWidth, 200);
  const box = { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: HEIGHT - MARGIN.bottom };
  let [low, high] = [Infinity, -Infinity];
  for (const curve of curves.filter((c) => c)) {
    for (let i = 1; i < 2 * curve.points; i += 2) { low = Math.min(low, curve.values[i]); high = Math.max(high, curve.values[i]); }
  }
  // Zero belongs to a curve that comes near it.
  if (low > 0 && low < 0.3 * high) { low = 0; }
  if (!(high > low)) { const at = Number.isFinite(low) ? low : 0, by = Math.abs(at) || 1; [low, high] = [at - by, at + by]; }
  const x = (t) => box.left + (t - span[0]) / (span[1] - span[0] || 1) * (box.right - box.left);
  const y = (v) => box.bottom - (v - low) / (high - low) * (box.bottom - box.top);
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${HEIGHT}`, role: "img", "aria-label": `${label} over time` }, figure);
  for (const v of ticks(low, high, 3)) {
    svg("line", { class: "grid", x1: box.left, x2: box.right, y1: y(v), y2: y(v) }, drawing);
    svg("text", { x: box.left - 6, y: y(v) + 4, "text-anchor": "end" }, drawing, figures(v));
  }
  for (const t of ticks(span[0], span[1], 5)) {
    svg("line", { class: "grid", x1: x(t), x2: x(t), y1: box.top, y2: box.bottom }, drawing);
    svg("text", { x: x(t), y: HEIGHT - 4, "text-anchor": "middle" }, drawing, `${figures(t)} s`);
  }
  curves.forEach((curve, run) => {
    if (!curve || !curve.points) { return; }
    let path = "";
    for (let i = 0; i < 2 * curve.points; i += 2) { path += `${i ? "L" : "M"}${x(curve.values[i]).toFixed(1)} ${y(curve.values[i + 1]).toFixed(1)}`; }
    svg("path", { class: `line run-${run}`, d: path }, drawing);
    const peak = curve.peak;
    svg("circle", { class: `peak run-${run}`, cx: x(peak[0]), cy: y(peak[1]), r: 3.5 }, drawing);
    const told = element("button", caption, `${runs.length > 1 ? runs[run].name + ": " : ""}peak ${figures(peak[1])}${measure} at ${figures(peak[0])} s`, { class: `key-${run}` });
    told.addEventListener("click", () => seek(peak[0]));
    for (const { name, at } of curve.stages) {
      svg("circle", { class: `peak run-${run}`, cx: x(at[0]), cy: y(at[1]), r: 2.5 }, drawing);
      const stage = element("button", caption, `${name}: ${figures(at[1])} at ${figures(at[0])} s`, { class: `key-${run}` });
      stage.addEventListener("click", () => seek(at[0]));
    }
  });
  const now = element("span", caption, "", { class: "now" });
  const cursor = svg("line", { class: "cursor", y1: box.top, y2: box.bottom }, drawing);
  drawing.addEventListener("pointerdown", (event) => {
    const place = drawing.getBoundingClientRect(), at = (event.clientX - place.left) / place.width * width;
    seek(span[0] + (at - box.left) / (box.right - box.left) * (span[1] - span[0]));
  });
  return (t) => {
    const at = Math.min(Math.max(x(t), box.left), box.right);
    cursor.setAttribute("x1", at);
    cursor.setAttribute("x2", at);
    now.textContent = "now " + curves.map((curve) => (curve ? figures(valueAt(curve, t)) : "-")).join(" and ");
  };
}
