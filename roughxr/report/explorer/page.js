"use strict";
// Draws what the archive told of the place that is chosen. All numbers come in nm, nN, GPa; null is what is missing.
const told = JSON.parse(document.getElementById("told").textContent);
const at = id => document.getElementById(id);
const state = { place: 0, values: {}, source: null, frame: null, method: null, hidden: new Set(["self_similar", "published", "hertz"]), whole: false };
const LOOKS = {
  adhesive: { stroke: "#0173b2", "stroke-width": 2.4 },
  direct: { stroke: "#222222", "stroke-width": 1.8 },
  energy: { stroke: "#de8f05", "stroke-width": 1.8, "stroke-dasharray": "8 3" },
  self_similar: { stroke: "#029e73", "stroke-width": 1.8, "stroke-dasharray": "8 3 2 3" },
  published: { stroke: "#cc78bc", "stroke-width": 1.8, "stroke-dasharray": "2 3" },
  hertz: { stroke: "#8a8a8a", "stroke-width": 1.8, "stroke-dasharray": "12 3 2 3 2 3" },
};
const SIGNS = { "first contact": "▽", "turning point": "◇", "pull-off": "●", "parting": "✕" };
let grey = null; // the scan's picture without its colours, for the ground below a contact map

// Pieces of drawings

function draw(name, attributes = {}, ...inside) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  for (const one of inside) made.append(one);
  return made;
}

function html(name, properties = {}, ...inside) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...inside);
  return made;
}

/** Empty a drawing and give it so many pixels. */
function canvas(svg, height) {
  const width = Math.max(240, svg.parentElement.clientWidth);
  svg.replaceChildren();
  for (const [key, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` })) svg.setAttribute(key, value);
  svg.style.height = `${height}px`;
  return width;
}

/** Round numbers between two ends, about so many. */
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1), power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(k => k * power >= rough * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/** Axes with ticks, words and units; returns how numbers become pixels. */
function frame(svg, { left, top, width, height, x, y }) {
  const sx = value => left + (value - x.low) / (x.high - x.low) * width;
  const sy = value => top + height - (value - y.low) / (y.high - y.low) * height;
  const across = ticks(x.low / x.size, x.high / x.size, width / 70), up = ticks(y.low / y.size, y.high / y.size, height / 45);
  for (const value of across.found) {
    const px = sx(value * x.size);
    svg.append(draw("line", { x1: px, x2: px, y1: top + height, y2: top + height + 4, stroke: "#566270" }));
    svg.append(draw("text", { x: px, y: top + height + 17, "text-anchor": "middle" }, signed(value.toFixed(across.digits))));
  }
  for (const value of up.found) {
    const py = sy(value * y.size);
    svg.append(draw("line", { x1: left - 4, x2: left, y1: py, y2: py, stroke: "#566270" }));
    svg.append(draw("text", { x: left - 7, y: py + 4, "text-anchor": "end" }, signed(value.toFixed(up.digits))));
  }
  svg.append(draw("path", { d: `M${left} ${top}V${top + height}H${left + width}`, fill: "none", stroke: "#566270" }));
  svg.append(draw("text", { x: left + width / 2, y: top + height + 36, "text-anchor": "middle" }, x.words));
  svg.append(draw("text", { x: 0, y: 0, transform: `translate(13 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, y.words));
  return { sx, sy };
}

/** A bar of colours with numbers at its ends, and zero where it lies within. */
function colourBar(svg, { left, top, width, picture, low, high, words, zero }) {
  svg.append(draw("image", { x: left, y: top, width, height: 10, href: picture, preserveAspectRatio: "none" }));
  svg.append(draw("text", { x: left, y: top + 24 }, low));
  svg.append(draw("text", { x: left + width, y: top + 24, "text-anchor": "end" }, high));
  if (zero) svg.append(draw("text", { x: left + width * zero, y: top + 24, "text-anchor": "middle" }, "0"));
  svg.append(draw("text", { x: left + width / 2, y: top + 40, "text-anchor": "middle", class: "soft" }, words));
}

// Numbers in words

const signed = text => String(text).replace(/^-/, "−").replace(/^−(0(\.0*)?)$/, "$1");

function digits(value, count = 3) {
  if (value === null || value === undefined) return "–";
  if (Number.isInteger(value) && Math.abs(value) < 1e4) return signed(value);
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size >= 6 || size < -4) return signed(value.toExponential(count - 1));
  return signed(size >= count ? value.toFixed(0) : value.toFixed(Math.min(6, count - 1 - size)));
}

const forceUnit = most => most >= 1e3 ? ["µN", 1e3] : most >= 1 || most === 0 ? ["nN", 1] : ["pN", 1e-3];
const lengthUnit = most => most >= 2e3 ? ["µm", 1e3] : ["nm", 1];
const force = value => { if (value === null || value === undefined) return "–"; const [unit, size] = forceUnit(Math.abs(value)); return `${digits(value / size)} ${unit}`; };

// What is held for the state

const keyOf = over => over.map(name => told.axes.find(axis => axis.name === name).words[state.values[name] || 0]).join(";");
const held = (one, field) => one ? one[field][keyOf(one.over)] : undefined;
const sheetOf = map => (held(map, "sheets") || [])[state.place] || null;
const method = () => told.pulls.find(one => one.name === state.method) || told.pulls[0];

function chosenMap() {
  const there = told.maps.filter(sheetOf);
  return there.find(map => map.name === state.source) || there[0] || null;
}

/** The step that is shown: the chosen one, else that of the largest pull, or the last. */
function chosenFrame(map, sheet) {
  const last = sheet.delta.length - 1;
  if (state.frame !== null && state.frame <= last) return state.frame;
  if (map.name !== "adhesive") return last;
  return sheet.force.reduce((best, value, k) => value !== null && value <= sheet.force[best] ? k : best, 0);
}

// Panels

function drawScan() {
  const svg = at("scan"), [x0, x1, y0, y1] = told.scan.box, [unit, size] = lengthUnit(Math.max(x1 - x0, y1 - y0));
  const room = Math.max(240, svg.parentElement.clientWidth), left = 52;
  const scale = Math.min((room - left - 12) / (x1 - x0), 430 / (y1 - y0));
  const width = (x1 - x0) * scale, height = (y1 - y0) * scale;
  canvas(svg, height + 100);
  svg.append(draw("image", { x: left, y: 6, width, height, href: told.scan.picture, preserveAspectRatio: "none", style: "image-rendering: auto" }));
  const { sx, sy } = frame(svg, { left, top: 6, width, height, x: { low: x0, high: x1, size, words: `x [${unit}]` }, y: { low: y0, high: y1, size, words: `y [${unit}]` } });
  const values = held(method(), "values") || [], known = values.filter(value => value !== null);
  const most = Math.max(...known, 0) || 1, radius = Math.max(3.5, Math.min(9, 0.28 * Math.sqrt(width * height / told.places.length)));
  const mostShare = Math.max(...told.places.map(place => place.share || 0));
  told.places.forEach((place, k) => {
    const share = values[k] === null || values[k] === undefined ? null : values[k] / most;
    const size = radius * (place.share ? Math.max(0.5, Math.sqrt(place.share / mostShare)) : 1);
    const spot = { cx: sx(place.x), cy: sy(place.y), r: size, class: "place", "data-place": k, stroke: place.debris ? "#d55e00" : "#fff", "stroke-width": place.debris ? 2.5 : 1.4 };
    spot.fill = share === null ? "none" : `hsl(38 100% ${94 - 50 * share}%)`;
    const words = values[k] === undefined ? "" : `: ${values[k] === null ? "does not pull" : force(values[k])}`;
    svg.append(draw("circle", spot, draw("title", {}, `place ${k}${words}${place.share ? `, ${digits(100 * place.share, 2)} % of the particles` : ""}${place.debris ? ", debris" : ""}`)));
    if (told.maps.some(map => map.name === "adhesive" && (held(map, "sheets") || [])[k]))
      svg.append(draw("circle", { cx: spot.cx, cy: spot.cy, r: 0.35 * radius, fill: "#0173b2" }));
  });
  const here = told.places[state.place];
  svg.append(draw("circle", { cx: sx(here.x), cy: sy(here.y), r: radius + 5, fill: "none", stroke: "#fff", "stroke-width": 5 }));
  svg.append(draw("circle", { id: "chosen", cx: sx(here.x), cy: sy(here.y), r: radius + 5, fill: "none", stroke: "#d55e00", "stroke-width": 3, "data-place": state.place }));
  colourBar(svg, { left, top: height + 52, width, picture: told.scan.colours, low: `${digits(told.scan.low)} nm`, high: `${digits(told.scan.high)} nm`, words: "height" });
  svg.places = told.places.map(place => [sx(place.x), sy(place.y)]);
  const words = ["Click a place, or use the arrow keys."];
  if (mostShare) words.push("Particles come to rest at these places; a larger circle: more of them.");
  if (told.pulls.length) words.push(`Darker: larger pull-off force (${method().label}); hollow: no pull-off.`);
  if (told.places.some(place => place.debris)) words.push("Red rim: debris, by the rule.");
  if (told.maps.some(map => map.name === "adhesive")) words.push("Blue dot: contact maps with adhesion.");
  at("scan-words").textContent = words.join(" ");
}

function drawMap() {
  const svg = at("map"), map = chosenMap(), sheet = map && sheetOf(map), controls = at("map-controls");
  controls.hidden = !sheet;
  controls.style.display = sheet ? "" : "none";
  if (!sheet) {
    canvas(svg, 40);
    at("map-words").textContent = told.maps.length ? "Nothing touches at this place." : "The archive holds no contact maps, nor the bodies to compute them.";
    return;
  }
  const k = chosenFrame(map, sheet), [x0, x1, y0, y1] = sheet.box, here = told.places[state.place];
  const room = Math.max(240, svg.parentElement.clientWidth), left = 60;
  const scale = Math.min((room - left - 12) / (x1 - x0), 430 / (y1 - y0)), width = (x1 - x0) * scale, height = (y1 - y0) * scale;
  canvas(svg, height + 100);
  const inside = { x: left, y: 6, width, height, preserveAspectRatio: "none" };
  const [s0, s1, t0, t1] = told.scan.box;
  if (grey) svg.append(draw("svg", { ...inside, viewBox: `${here.x + x0} ${-(here.y + y1)} ${x1 - x0} ${y1 - y0}` },
    draw("image", { x: s0, y: -t1, width: s1 - s0, height: t1 - t0, href: grey, preserveAspectRatio: "none", style: "image-rendering: pixelated" })));
  svg.append(draw("svg", { ...inside, id: "sheet", "data-frame": k, viewBox: `0 ${k * sheet.rows} ${sheet.columns} ${sheet.rows}` },
    draw("image", { x: 0, y: 0, width: sheet.columns, height: sheet.rows * sheet.delta.length, href: sheet.picture, preserveAspectRatio: "none", style: "image-rendering: pixelated" })));
  frame(svg, { left, top: 6, width, height, x: { low: x0, high: x1, size: 1, words: "x from the contact centre [nm]" }, y: { low: y0, high: y1, size: 1, words: "y from the contact centre [nm]" } });
  const pulls = map.pull > 0;
  colourBar(svg, { left, top: height + 52, width, picture: map.colours, low: pulls ? `−${digits(map.pull)} GPa` : "0", high: `${digits(map.push)} GPa or more`,
    words: pulls ? "traction: pull, push" : "contact pressure", zero: pulls ? 127 / 255 : 0 });
  const there = told.maps.filter(sheetOf);
  at("source").replaceChildren(...there.map(one => html("option", { value: one.name, selected: one === map }, one.label)));
  Object.assign(at("frame"), { max: sheet.delta.length - 1 });
  at("frame").value = k;
  const way = sheet.branch.includes("retraction") ? `${sheet.branch[k] === "loading" ? "Loading" : "Retraction"}, ` : "";
  const words = `${way}δ = ${digits(sheet.delta[k], 4)} nm: force ${force(sheet.force[k])}, contact area ${digits(sheet.area[k])} nm². Grey: heights before contact.`;
  at("frame").setAttribute("aria-valuetext", words);
  at("map-words").textContent = words;
  if (told.maps.some(one => one.name === "adhesive") && !there.some(one => one.name === "adhesive"))
    at("map-words").textContent += ` Maps with adhesion are at other places only: roughxr explore --loops ${told.places.length} computes all.`;
}

/** All lines of the place: what the archive holds as curves, and the loop that was followed again. */
function linesHere() {
  const found = told.curves.map(one => ({ name: one.name, label: one.label, lines: (held(one, "lines") || [])[state.place] || [] }));
  const map = told.maps.find(one => one.name === "adhesive"), sheet = map && sheetOf(map);
  if (sheet && !told.curves.some(one => one.name === "adhesive")) {
    const of = way => sheet.branch.map((branch, k) => branch === way ? k : -1).filter(k => k >= 0);
    const line = way => ({ branch: way, delta: of(way).map(k => sheet.delta[k]), force: of(way).map(k => sheet.force[k]) });
    found.unshift({ name: "adhesive", label: "simulation with adhesion", lines: [line("loading"), line("retraction")] });
  }
  return found;
}

function drawForce() {
  const svg = at("force"), all = linesHere(), events = (held(told.events, "points") || [])[state.place] || [];
  const shown = all.filter(one => !state.hidden.has(one.name));
  const width = canvas(svg, 340), left = 60, top = 8, height = 280, right = width - 10;
  const points = shown.flatMap(one => one.lines.flatMap(line => line.force.map((value, k) => [line.delta[k], value]))).filter(point => point[1] !== null)
    .concat(events.map(event => [event.delta, event.force]));
  at("legend").replaceChildren(...legendButtons(all));
  if (!points.length) { at("force-words").textContent = "The archive holds no force over displacement of this place."; return; }
  const pull = -Math.min(0, ...points.map(point => point[1])), most = Math.max(...points.map(point => point[1]));
  const near = pull > 0 && most > 3 * pull && !state.whole;
  const y = { low: pull > 0 ? -1.25 * pull : -0.05 * most, high: near ? 2 * pull : 1.05 * Math.max(most, 0.2 * pull) };
  const within = points.filter(point => point[1] > y.low && point[1] < y.high && Math.abs(point[1]) > 1e-3 * (near ? pull : Math.max(most, pull)));
  const x = { low: Math.min(...within.map(point => point[0])), high: Math.max(...within.map(point => point[0])) };
  const edge = 0.06 * (x.high - x.low) || 1;
  const [unit, size] = forceUnit(Math.max(-y.low, y.high));
  Object.assign(x, { low: x.low - edge, high: x.high + edge, size: 1, words: "displacement δ [nm]" });
  Object.assign(y, { size, words: `force [${unit}]` });
  const { sx, sy } = frame(svg, { left, top, width: right - left, height, x, y });
  svg.append(draw("clipPath", { id: "within" }, draw("rect", { x: left, y: top, width: right - left, height })));
  const inner = draw("g", { "clip-path": "url(#within)", fill: "none" });
  inner.append(draw("line", { x1: left, x2: right, y1: sy(0), y2: sy(0), stroke: "#9aa5b1" }));
  for (const one of [...shown].reverse()) for (const line of one.lines) {
    const path = line.force.map((value, k) => value === null ? null : `${sx(line.delta[k]).toFixed(1)} ${sy(value).toFixed(1)}`).filter(point => point);
    const thin = line.branch === "loading" && one.lines.length > 1 ? { "stroke-width": 1.2, "stroke-dasharray": "4 3" } : {};
    if (path.length) inner.append(draw("path", { d: `M${path.join("L")}`, class: "curve", "data-method": one.name, ...LOOKS[one.name], ...thin }));
  }
  const map = chosenMap(), sheet = map && sheetOf(map);
  if (sheet) {
    const k = chosenFrame(map, sheet);
    inner.append(draw("circle", { id: "now", cx: sx(sheet.delta[k]), cy: sy(sheet.force[k]), r: 6, stroke: "#d55e00", "stroke-width": 2.5, fill: "#fff" }));
  }
  for (const event of events)
    inner.append(draw("text", { x: sx(event.delta), y: sy(event.force) + 4, "text-anchor": "middle", style: "fill: #0173b2; stroke: none", class: "event" }, SIGNS[event.is], draw("title", {}, `${event.is}: δ = ${digits(event.delta, 4)} nm, ${force(event.force)}`)));
  svg.append(inner);
  const words = events.length ? [`With adhesion: ${events.map(event => `${SIGNS[event.is]} ${event.is}`).join(", ")}.`] : [];
  if (all.some(one => one.lines.length > 1)) words.push("Thin dashes: loading.");
  if (sheet) words.push("Circle: the state of the contact map.");
  at("force-words").textContent = words.join(" ");
}

function legendButtons(all) {
  const made = all.map(one => {
    const shown = !state.hidden.has(one.name);
    const sample = draw("svg", { viewBox: "0 0 26 8", "aria-hidden": "true" }, draw("line", { x1: 0, x2: 26, y1: 4, y2: 4, ...LOOKS[one.name] }));
    const button = html("button", { type: "button", onclick: () => { shown ? state.hidden.add(one.name) : state.hidden.delete(one.name); drawForce(); again(one.name); } }, sample, one.label);
    button.dataset.method = one.name;
    button.setAttribute("aria-pressed", shown);
    return button;
  });
  const whole = html("button", { type: "button", onclick: () => { state.whole = !state.whole; drawForce(); again("whole"); } }, "whole range of forces");
  whole.dataset.method = "whole";
  whole.setAttribute("aria-pressed", state.whole);
  return [...made, whole];
}

/** Keep the focus on a button that was drawn anew. */
const again = name => at("legend").querySelector(`[data-method="${name}"]`).focus();

function drawPulls() {
  const svg = at("pulls"), chosen = method();
  at("method").replaceChildren(...told.pulls.map(one => html("option", { value: one.name, selected: one === chosen }, one.label)));
  if (!chosen) { canvas(svg, 10); at("method").parentElement.style.display = "none"; at("pulls-words").textContent = "The archive holds no pull-off: bodies without adhesion."; return; }
  const values = held(chosen, "values"), bins = held(chosen, "bins");
  if (!values) { canvas(svg, 10); at("pulls-words").textContent = "Not in the archive at these values."; return; }
  const known = values.filter(value => value !== null), last = bins.length - 2, rests = told.places.some(place => place.share);
  const weight = k => values[k] === null ? 0 : rests ? told.places[k].share : 1, sum = which => values.reduce((all, value, k) => all + (which(value) ? weight(k) : 0), 0);
  const counts = bins.slice(1).map((high, k) => sum(value => value >= bins[k] && (value < high || (k === last && value <= high * 1.0001))));
  const width = canvas(svg, 340), left = 60, top = 24, height = 264, right = width - 10;
  const [unit, size] = forceUnit(Math.max(...bins));
  const margin = 0.04 * (bins[last + 1] - bins[0]) || 1;
  const x = { low: bins[0] - margin, high: bins[last + 1] + margin, size, words: `pull-off force [${unit}]` };
  const y = { low: 0, high: 1.12 * Math.max(...counts, rests ? 0.01 : 1), size: 1, words: rests ? "share of particles" : "places" };
  const { sx, sy } = frame(svg, { left, top, width: right - left, height, x, y });
  counts.forEach((count, k) => svg.append(draw("rect", { x: sx(bins[k]) + 0.5, y: sy(count), width: Math.max(1, sx(bins[k + 1]) - sx(bins[k]) - 1), height: sy(0) - sy(count), fill: "#9cc7e0" })));
  for (const value of known) svg.append(draw("line", { x1: sx(value), x2: sx(value), y1: sy(0), y2: sy(0) - 7, stroke: "#0173b2" }));
  const own = values[state.place];
  if (own === null) { at("pulls-words").textContent = `Place ${state.place} does not pull, or its pull-off is not known. ${known.length} of ${values.length} places pull.`; return; }
  svg.append(draw("line", { id: "mark", x1: sx(own), x2: sx(own), y1: top - 4, y2: sy(0), stroke: "#d55e00", "stroke-width": 3, "data-value": own }));
  const half = (left + right) / 2, side = sx(own) > half ? "end" : "start";
  svg.append(draw("text", { x: sx(own) + (side === "end" ? -7 : 7), y: top + 4, "text-anchor": side, style: "font-weight: 600; fill: #b34e00" }, `place ${state.place}: ${force(own)}`));
  const fewer = known.filter(value => value < own).length;
  at("pulls-words").textContent = `Place ${state.place}: ${force(own)}, more than at ${fewer} of the ${known.length - 1} other places that pull; the mean ${rests ? "over particles" : "of them all"} is ${force(values.reduce((all, value, k) => all + weight(k) * value, 0) / sum(() => true))}.`;
}

function drawFacts() {
  const here = told.places[state.place], rows = [["x", digits(here.x, 5), "nm"], ["y", digits(here.y, 5), "nm"]];
  for (const one of told.pulls) {
    const value = (held(one, "values") || [])[state.place];
    if (one.name !== "adhesive") rows.push([`pull-off force, ${one.label}`, ...scaled(value, "nN")]);
  }
  const columns = held(told.facts, "values") || [];
  (told.facts ? told.facts.rows : []).forEach((row, k) => rows.splice(2 + k, 0, [row.label, ...scaled((columns[k] || [])[state.place], row.unit)]));
  at("facts").replaceChildren(...rows.map(([words, value, unit]) => html("tr", {}, html("th", { scope: "row" }, words), html("td", {}, value), html("td", { className: "unit" }, unit))));
  const doubts = [...told.doubts[state.place], ...(here.debris ? ["debris, by the rule"] : [])];
  if (doubts.length) at("facts").append(html("tr", {}, html("th", { colSpan: 3 }, `Caution: ${doubts.join("; ")}.`)));
}

function scaled(value, unit) {
  if (unit !== "nN" || value === null || value === undefined) return [digits(value), unit];
  const [larger, size] = forceUnit(Math.abs(value));
  return [digits(value / size), larger];
}

function say() {
  const here = told.places[state.place], [unit, size] = lengthUnit(Math.max(...told.scan.box.map(Math.abs)));
  const own = told.pulls.length ? (held(method(), "values") || [])[state.place] : undefined;
  const pull = own === undefined ? "" : own === null ? ", does not pull" : `, pulled off at ${force(own)}`;
  at("said").textContent = `Place ${state.place} at x = ${digits(here.x / size)}, y = ${digits(here.y / size)} ${unit}${pull}.`;
  at("place").value = state.place;
}

function drawAll() {
  for (const panel of [say, drawScan, drawMap, drawForce, drawPulls, drawFacts]) panel();
  const words = [`place=${state.place}`, ...told.axes.map(axis => `${axis.name}=${axis.words[state.values[axis.name]]}`)];
  try { history.replaceState(null, "", `#${words.join("&")}`); } catch { /* a page that may not say where it is */ }
}

// What a reader does

function choose(place) {
  if (!Number.isFinite(place)) return;
  const next = Math.max(0, Math.min(told.places.length - 1, Math.round(place)));
  if (next !== state.place && (chosenMap() || {}).name === "adhesive") state.frame = null; // each loop has steps of its own
  state.place = next;
  drawAll();
}

/** The nearest place in a direction; what lies aside counts double. */
function towards(dx, dy) {
  const here = told.places[state.place];
  const ranked = told.places.map((place, k) => {
    const along = (place.x - here.x) * dx + (place.y - here.y) * dy, aside = Math.abs((place.x - here.x) * dy) + Math.abs((place.y - here.y) * dx);
    return [k, along > 1e-9 && aside <= 2 * along ? along + 2 * aside : Infinity];
  }).sort((a, b) => a[1] - b[1]);
  return ranked[0][1] < Infinity ? ranked[0][0] : state.place;
}

at("scan").addEventListener("click", event => {
  const box = at("scan").getBoundingClientRect(), far = at("scan").places.map(([x, y]) => Math.hypot(x - (event.clientX - box.left), y - (event.clientY - box.top)));
  choose(far.indexOf(Math.min(...far)));
});
at("scan").addEventListener("keydown", event => {
  const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const next = event.key in steps ? towards(...steps[event.key]) : { Home: 0, End: told.places.length - 1 }[event.key];
  if (next === undefined) return;
  event.preventDefault();
  choose(next);
});
at("before").onclick = () => choose(state.place - 1);
at("after").onclick = () => choose(state.place + 1);
at("place").onchange = event => choose(event.target.valueAsNumber);
at("source").onchange = event => { state.source = event.target.value; state.frame = null; drawMap(); drawForce(); };
at("frame").oninput = event => { state.frame = event.target.valueAsNumber; drawMap(); drawForce(); };
at("method").onchange = event => { state.method = event.target.value; drawAll(); };

for (const axis of told.axes) {
  const shown = html("output"), slider = html("input", { type: "range", min: 0, max: axis.values.length - 1, step: 1, id: `slide-${axis.name}` });
  const tell = () => { shown.textContent = `${axis.words[state.values[axis.name]]} ${axis.unit}`; slider.setAttribute("aria-valuetext", shown.textContent); };
  state.values[axis.name] = 0;
  slider.oninput = () => { state.values[axis.name] = slider.valueAsNumber; state.frame = null; tell(); drawAll(); };
  axis.set = k => { slider.value = state.values[axis.name] = k; tell(); };
  at("sliders").append(html("div", { className: "control" }, html("label", { htmlFor: slider.id }, axis.label), slider, shown));
}

/** Take over what the address says, so that a state can be linked to. */
function fromAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  for (const axis of told.axes) axis.set(Math.max(0, axis.words.indexOf(asked.get(axis.name))));
  choose(asked.has("place") ? Number(asked.get("place")) : told.places.findIndex((_, k) => told.maps.length && (held(told.maps[0], "sheets") || [])[k]) || 0);
}

window.addEventListener("hashchange", fromAddress);
new ResizeObserver(drawAll).observe(document.querySelector("main"));
const picture = new Image();
picture.onload = () => {
  const sheet = html("canvas", { width: picture.width, height: picture.height }), pen = sheet.getContext("2d");
  pen.drawImage(picture, 0, 0);
  const pixels = pen.getImageData(0, 0, sheet.width, sheet.height);
  for (let k = 0; k < pixels.data.length; k += 4) {
    const light = 0.21 * pixels.data[k] + 0.72 * pixels.data[k + 1] + 0.07 * pixels.data[k + 2];
    pixels.data[k] = pixels.data[k + 1] = pixels.data[k + 2] = 110 + 0.55 * light;
  }
  pen.putImageData(pixels, 0, 0);
  grey = sheet.toDataURL();
  drawMap();
};
picture.src = told.scan.picture;
fromAddress();
