"use strict";
// Draws what the archive contains of the chosen place. All numbers are in nm, nN, GPa; null is a missing number.
const data = JSON.parse(document.getElementById("data").textContent);
const at = id => document.getElementById(id);
const state = { place: 0, method: null, hidden: new Set(["self_similar", "published", "hertz"]), whole: false };
const COLOURS = { adhesive: "#0173b2", extrapolated: "#56b4e9", direct: "#222222", energy: "#de8f05", self_similar: "#029e73", published: "#cc78bc", hertz: "#8a8a8a", rigid: "#7a5195" };
// dashes of the curves, and their signs in the legend, so that a grey print tells them apart
const DASHES = { direct: ["9 4", "– – "], energy: ["2 3", "···· "], self_similar: ["9 3 2 3", "–·–· "], published: ["5 2", "- - - "], hertz: ["1 5", "· · "] };

function draw(svg, name, attributes, text = "") {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.textContent = text;
  svg.append(node);
  return node;
}

function html(name, properties, ...inside) {
  const node = Object.assign(document.createElement(name), properties);
  node.append(...inside);
  return node;
}

/** Empty a drawing, give it a height, and return its width. */
function clear(svg, height) {
  const width = Math.max(240, svg.parentElement.clientWidth);
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.style.height = `${height}px`;
  return width;
}

/** Draw axes with round ticks and words; return how numbers become pixels. */
function axes(svg, { left, top, width, height, x, y }) {
  const sx = value => left + (value - x.low) / (x.high - x.low) * width;
  const sy = value => top + height - (value - y.low) / (y.high - y.low) * height;
  const step = (low, high, count) => {
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
    return power * [1, 2, 5, 10].find(k => k * power >= 0.999 * rough);
  };
  const ticks = (axis, count) => {
    const low = axis.low / axis.size, high = axis.high / axis.size, each = step(low, high, count);
    const places = Math.max(0, -Math.floor(Math.log10(each) + 1e-9)), first = Math.ceil(low / each - 1e-9);
    return Array.from({ length: Math.floor(high / each + 1e-9) - first + 1 }, (_, k) => [(first + k) * each * axis.size, minus(((first + k) * each).toFixed(places))]);
  };
  for (const [value, words] of ticks(x, width / 70)) draw(svg, "text", { x: sx(value), y: top + height + 16, "text-anchor": "middle" }, words);
  for (const [value, words] of ticks(y, height / 45)) draw(svg, "text", { x: left - 6, y: sy(value) + 4, "text-anchor": "end" }, words);
  draw(svg, "path", { d: `M${left} ${top}V${top + height}H${left + width}`, fill: "none", stroke: "#566270" });
  draw(svg, "text", { x: left + width / 2, y: top + height + 34, "text-anchor": "middle" }, x.words);
  draw(svg, "text", { transform: `translate(13 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, y.words);
  return { sx, sy };
}

const minus = text => String(text).replace("-", "−");
const missing = value => value === null || value === undefined;
const digits = value => missing(value) ? "–" : typeof value === "string" ? value : minus(Number(value.toPrecision(3)));
const forceUnit = most => most >= 1e3 ? ["µN", 1e3] : most >= 1 || most === 0 ? ["nN", 1] : ["pN", 1e-3];
const force = value => { const [unit, size] = forceUnit(Math.abs(value)); return missing(value) ? "–" : `${digits(value / size)} ${unit}`; };
const method = () => data.pulls.find(result => result.name === state.method) || data.pulls[0];
const pullOffs = () => method()?.values || [];

/** Draw the scan with its axes; return how numbers become pixels. */
function drawPicture(svg, picture, [x0, x1, y0, y1]) {
  const left = 60, room = Math.max(240, svg.parentElement.clientWidth) - left - 12, scale = Math.min(room / (x1 - x0), 400 / (y1 - y0));
  const width = (x1 - x0) * scale, height = (y1 - y0) * scale, [unit, size] = Math.max(x1 - x0, y1 - y0) >= 2e3 ? ["µm", 1e3] : ["nm", 1];
  clear(svg, height + 48);
  draw(svg, "image", { x: left, y: 6, width, height, href: picture, preserveAspectRatio: "none" });
  return axes(svg, { left, top: 6, width, height, x: { low: x0, high: x1, size, words: `x [${unit}]` }, y: { low: y0, high: y1, size, words: `y [${unit}]` } });
}

function drawScan() {
  const svg = at("scan"), { sx, sy } = drawPicture(svg, data.scan.picture, data.scan.box), values = pullOffs(), most = Math.max(...values, 0) || 1;
  data.places.forEach((place, k) => {
    const fill = missing(values[k]) ? "none" : `hsl(38 100% ${94 - 50 * values[k] / most}%)`, chosen = k === state.place;
    const node = draw(svg, "circle", { cx: sx(place.x), cy: sy(place.y), r: chosen ? 8 : 5, class: "place", "data-place": k, fill, stroke: chosen ? "#d55e00" : place.debris ? "#cc78bc" : "#fff", "stroke-width": chosen ? 3.5 : 1.5 });
    draw(node, "title", {}, `place ${k}: ${force(values[k])}${place.share ? `, ${digits(100 * place.share)} % of the particles` : ""}${place.debris ? ", debris" : ""}`);
    if (chosen) node.id = "chosen";
  });
  const words = [`Heights from ${digits(data.scan.low)} (dark) to ${digits(data.scan.high)} nm (light). Click a place, or use the arrow keys.`];
  if (data.pulls.length) words.push("A darker circle has a larger pull-off force, a hollow circle none.");
  if (data.places.some(place => place.debris)) words.push("Pink rim: debris.");
  at("scan-words").textContent = words.join(" ");
}

function drawForce() {
  const svg = at("force"), all = data.curves.map(curve => ({ ...curve, lines: curve.lines[state.place] }));
  const named = all.filter((curve, k) => all.findIndex(other => other.name === curve.name) === k);
  at("legend").replaceChildren(...named.map(curve => {
    const shown = !state.hidden.has(curve.name), toggle = () => { shown ? state.hidden.add(curve.name) : state.hidden.delete(curve.name); drawForce(); };
    const button = html("button", { type: "button", onclick: toggle }, html("span", { style: `color: ${COLOURS[curve.name]}` }, curve.events ? "● " : (DASHES[curve.name] ?? ["", "— "])[1]), curve.label);
    button.setAttribute("aria-pressed", shown);
    return button;
  }), html("button", { type: "button", onclick: () => { state.whole = !state.whole; drawForce(); } }, state.whole ? "near the pull-off only" : "whole range of forces"));
  const shown = all.filter(curve => !state.hidden.has(curve.name));
  const points = shown.flatMap(curve => curve.lines.flatMap(line => line.force.map((value, k) => [line.delta[k], value]))).filter(point => !missing(point[0]) && !missing(point[1]));
  if (!points.length) { clear(svg, 10); at("force-words").textContent = "The archive contains no force over displacement of this place."; return; }
  const low = Math.min(0, ...points.map(point => point[1])), most = Math.max(0, ...points.map(point => point[1]));
  const high = low < 0 && most > -4 * low && !state.whole ? -2 * low : most, [unit, size] = forceUnit(Math.max(-low, high));
  const wells = state.whole ? [] : points.filter(point => point[1] < 0.02 * low);
  const active = wells.length > 1 ? wells : points.filter(point => point[1] <= high && Math.abs(point[1]) > 1e-3 * Math.max(-low, high)), range = (active.length > 1 ? active : points).map(point => point[0]);
  const first = Math.min(...range), last = Math.max(...range), margin = Math.max(0.15 * (last - first), 0.25 - (last - first) / 2), width = clear(svg, 340), left = 60, height = 290;
  const { sx, sy } = axes(svg, { left, top: 8, width: width - left - 10, height, x: { low: first - margin, high: last + margin, size: 1, words: "displacement δ [nm]" }, y: { low: 1.05 * low - 0.02 * high, high: 1.05 * high - 0.02 * low || 1, size, words: `force [${unit}]` } });
  draw(draw(svg, "clipPath", { id: "within" }), "rect", { x: left, y: 8, width: width - left - 10, height });
  const inner = draw(svg, "g", { "clip-path": "url(#within)" });
  draw(inner, "line", { x1: left, x2: width, y1: sy(0), y2: sy(0), stroke: "#9aa5b1" });
  for (const curve of [...shown].reverse()) for (const line of curve.lines) {
    const path = line.force.map((value, k) => missing(value) || missing(line.delta[k]) ? null : [sx(line.delta[k]), sy(value)]).filter(point => point);
    if (curve.events) path.forEach(([cx, cy]) => draw(inner, "circle", { cx, cy, r: 4.5, fill: COLOURS[curve.name], class: "event", "data-method": curve.name }));
    else if (path.length) draw(inner, "path", { d: `M${path.map(point => point.map(value => value.toFixed(1)).join(" ")).join("L")}`, class: "curve", "data-method": curve.name, stroke: COLOURS[curve.name], "stroke-width": 1.8, "stroke-dasharray": (DASHES[curve.name] ?? ["none"])[0], fill: "none" });
  }
  at("force-words").textContent = all.some(curve => curve.events) ? "Dot: pull-off in the simulation with adhesion." : "";
}

function drawPulls() {
  const svg = at("pulls"), chosen = method(), values = pullOffs(), known = values.filter(value => !missing(value)), words = at("pulls-words");
  at("method").replaceChildren(...data.pulls.map(result => html("option", { value: result.name, selected: result === chosen }, result.label)));
  at("method").parentElement.style.display = chosen ? "" : "none";
  if (!known.length) { clear(svg, 10); words.textContent = "The archive contains no pull-off: bodies without adhesion."; return; }
  const low = Math.min(...known), high = Math.max(...known), span = high - low || 1, count = Math.max(1, Math.min(30, Math.ceil(Math.sqrt(known.length) * 1.5)));
  const weighted = data.places.some(place => place.share), weight = k => missing(values[k]) ? 0 : weighted ? data.places[k].share || 0 : 1, bins = new Array(count).fill(0);
  values.forEach((value, k) => { if (!missing(value)) bins[Math.min(count - 1, Math.floor((value - low) / span * count))] += weight(k); });
  const width = clear(svg, 320), left = 60, top = 20, height = 254, [unit, size] = forceUnit(high);
  const { sx, sy } = axes(svg, { left, top, width: width - left - 10, height, x: { low: low - 0.05 * span, high: low + 1.05 * span, size, words: `pull-off force [${unit}]` }, y: { low: 0, high: 1.1 * Math.max(...bins), size: 1, words: weighted ? "share of particles" : "places" } });
  bins.forEach((value, k) => draw(svg, "rect", { x: sx(low + k * span / count) + 0.5, y: sy(value), width: Math.max(1, sx(span / count) - sx(0) - 1), height: sy(0) - sy(value), fill: "#9cc7e0" }));
  const own = values[state.place];
  if (missing(own)) { words.textContent = `Place ${state.place} has no pull-off force. ${known.length} of ${values.length} places have one.`; return; }
  draw(svg, "line", { id: "mark", x1: sx(own), x2: sx(own), y1: top - 4, y2: sy(0), stroke: "#d55e00", "stroke-width": 3, "data-value": own });
  words.textContent = `Place ${state.place}: ${force(own)}, more than at ${known.filter(value => value < own).length} of the other ${known.length - 1} places.`;
}

function drawFacts() {
  const place = data.places[state.place], rows = [["x", place.x, "nm"], ["y", place.y, "nm"], ...data.facts.map(fact => [fact.label, fact.values[state.place], fact.unit])];
  at("facts").replaceChildren(...rows.map(([words, value, unit]) => html("tr", {}, html("th", { scope: "row" }, words), html("td", {}, unit === "nN" ? force(value) : `${digits(value)} ${missing(value) ? "" : unit}`))));
}

function drawAll() {
  const place = data.places[state.place], own = pullOffs()[state.place];
  at("current").textContent = `Place ${state.place} at x = ${digits(place.x)}, y = ${digits(place.y)} nm${missing(own) ? "" : `, pull-off force ${force(own)}`}.`;
  at("place").value = state.place;
  for (const panel of [drawScan, drawForce, drawPulls, drawFacts]) panel();
  try { history.replaceState(null, "", `#place=${state.place}`); } catch { /* a page inside another page */ }
}

function choose(place) {
  if (!Number.isFinite(place)) return;
  state.place = Math.max(0, Math.min(data.places.length - 1, Math.round(place)));
  drawAll();
}

/** Return the nearest place in a direction; the distance across counts twice. */
function nearest(dx, dy) {
  const from = data.places[state.place], distances = data.places.map(place => {
    const along = (place.x - from.x) * dx + (place.y - from.y) * dy, across = Math.abs((place.x - from.x) * dy) + Math.abs((place.y - from.y) * dx);
    return along > 1e-9 && across <= 2 * along ? along + 2 * across : Infinity;
  });
  return Math.min(...distances) < Infinity ? distances.indexOf(Math.min(...distances)) : state.place;
}

at("scan").addEventListener("click", event => {
  const far = [...at("scan").querySelectorAll(".place")].map(node => { const box = node.getBoundingClientRect(); return Math.hypot(box.x + box.width / 2 - event.clientX, box.y + box.height / 2 - event.clientY); });
  choose(far.indexOf(Math.min(...far)));
});
at("scan").addEventListener("keydown", event => {
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }, ends = { Home: 0, End: data.places.length - 1 };
  if (!(event.key in steps || event.key in ends)) return;
  event.preventDefault();
  choose(event.key in steps ? nearest(...steps[event.key]) : ends[event.key]);
});
at("place").onchange = event => choose(event.target.valueAsNumber);
at("method").onchange = event => { state.method = event.target.value; drawAll(); };

/** Show the state that the address names. */
function fromAddress() {
  const address = new URLSearchParams(location.hash.slice(1));
  choose(address.has("place") ? Number(address.get("place")) : 0);
}

window.addEventListener("hashchange", fromAddress);
new ResizeObserver(drawAll).observe(document.querySelector("main"));
fromAddress();
