// The page of `gfmd serve`. It asks the server that sent it, and no other one.
"use strict";

const $ = (id) => document.getElementById(id);

/** Makes an element with attributes and children; texts are never read as HTML. */
function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === false || value === null || value === undefined) continue;
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

async function ask(path, options = {}) {
  let answer;
  try {
    answer = await fetch(path, options);
  } catch {
    throw new Error("the server does not answer; has it ended?");
  }
  if (!answer.ok) {
    const told = await answer.json().catch(() => ({}));
    throw new Error(told.error || `the server answers ${answer.status}`);
  }
  return answer;
}
const get = async (path) => (await ask(path)).json();
const post = async (path, value) =>
  (await ask(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) })).json();

function tell(id, error) {
  $(id).textContent = error ? error.message || String(error) : "";
  $(id).hidden = !error;
}

// ---- Form

// Options that are seen at once; all others are below "More".
const USUAL = {
  preparation: ["unit", "size", "detrend", "fill", "periodise", "flip"],
  problem: ["young", "poisson", "height", "boundary"],
};
const LOADS = { p_star: "Reduced pressure p*", pressure: "Mean pressure", force: "Force", approach: "Approach" };
// Textbook values, to begin with.
const MATERIALS = [
  ["own values", null, null],
  ["steel", "210GPa", "0.3"],
  ["aluminium", "70GPa", "0.33"],
  ["copper", "120GPa", "0.34"],
  ["titanium", "110GPa", "0.34"],
  ["silicon", "160GPa", "0.22"],
  ["glass", "70GPa", "0.22"],
  ["polycarbonate", "2.4GPa", "0.37"],
  ["rubber", "3MPa", "0.5"],
  ["numbers without a unit: E = 1", "1", "0"],
];
const state = { options: new Map(), scan: null, about: null, shown: null, runs: [], chosen: null };

function named(option) {
  const words = option.flag.slice(2).replaceAll("-", " ");
  return words[0].toUpperCase() + words.slice(1);
}

/** Makes the field of an option. `read` returns its answer, undefined if it is left out. */
function field(option) {
  const id = `option-${option.key}`;
  const help = `${id}-help`;
  const box = make("div", { class: "field" }, make("label", { for: id }, named(option)));
  let read, write, input;
  if (option.value === "" && option.choices.length === 0) {
    input = make("input", { type: "checkbox", id, "aria-describedby": help });
    read = () => (input.checked ? true : undefined);
    write = (value) => (input.checked = value === true);
    box.append(input);
  } else if (option.choices.length > 0 && !option.repeats) {
    input = make("select", { id, "aria-describedby": help });
    if (!option.default) input.append(make("option", { value: "" }, "–"));
    for (const choice of option.choices) input.append(make("option", { value: choice }, choice));
    write = (value) => (input.value = value ?? option.default);
    write();
    read = () => (input.value === option.default ? undefined : input.value);
    box.append(input);
  } else {
    const kinds = [...new Set(option.kinds.filter((kind) => kind !== "1"))].join(", ");
    const place = option.default || [option.value.toLowerCase(), kinds && `(${kinds})`].filter(Boolean).join(" ");
    input = make("input", { type: "text", id, placeholder: place, spellcheck: "false", autocomplete: "off", "aria-describedby": help });
    write = (value) => (input.value = value === true ? "" : value ?? "");
    const text = () => {
      const value = input.value.trim();
      if (!value) return undefined;
      return option.repeats ? value.split(";").map((part) => part.trim()).filter(Boolean) : value;
    };
    if (option.bare) {
      const check = make("input", { type: "checkbox", "aria-label": `${named(option)} with usual values` });
      input.addEventListener("input", () => (check.checked = check.checked || input.value.trim() !== ""));
      read = () => (check.checked ? text() ?? true : undefined);
      box.append(make("span", { class: "pair" }, check, input));
    } else {
      read = text;
      box.append(input);
    }
  }
  const several = option.repeats ? " Several are set apart by ;" : "";
  const error = make("p", { class: "error", role: "alert", hidden: true });
  box.append(make("small", { id: help }, option.meaning + several), error);
  input.addEventListener("input", () => mark(entry, null));
  const entry = { option, box, input, read, write, error };
  return entry;
}

function mark(entry, message) {
  entry.error.textContent = message ?? "";
  entry.error.hidden = !message;
  entry.input.classList.toggle("wrong", Boolean(message));
  if (message) entry.input.setAttribute("aria-invalid", "true");
  else entry.input.removeAttribute("aria-invalid");
}

/** Shows a failure beside the field that it names, or below the button. */
function refuse(id, error) {
  for (const entry of state.options.values()) mark(entry, null);
  const flags = [...(error?.message ?? "").matchAll(/--[a-z][a-z-]*/g)].map((found) => found[0]);
  const all = [...state.options.values()];
  const entry = flags.map((flag) => all.find((entry) => entry.option.flag === flag)).find(Boolean);
  if (entry) {
    mark(entry, error.message);
    entry.box.closest("details")?.setAttribute("open", "");
    entry.input.focus();
  }
  tell(id, error);
}

function build(options) {
  const places = { preparation: $("preparation"), problem: $("problem") };
  const groups = new Map();
  for (const option of options) {
    if (option.group === "Load") continue;
    const entry = field(option);
    state.options.set(option.key, entry);
    const place = option.group === "Surface" || option.group === "Preparation" ? "preparation" : "problem";
    if (USUAL[place].includes(option.key)) continue;
    const name = `${place}:${option.group}`;
    if (!groups.has(name)) groups.set(name, make("details", {}, make("summary", {}, `More: ${option.group.toLowerCase()}`)));
    groups.get(name).append(entry.box);
  }
  for (const [place, keys] of Object.entries(USUAL)) {
    for (const key of keys) if (state.options.has(key)) places[place].append(state.options.get(key).box);
  }
  places.problem.append(loads(options.filter((option) => option.group === "Load")));
  for (const [name, group] of groups) places[name.split(":")[0]].append(group);
  for (const [name] of MATERIALS) $("material").append(make("option", { value: name }, name));
  $("material").addEventListener("change", () => {
    const [, young, poisson] = MATERIALS.find(([name]) => name === $("material").value);
    if (!young) return;
    state.options.get("young").write(young);
    state.options.get("poisson").write(poisson);
  });
}

/** Makes the fields of the load: one of its kinds, and its values. */
function loads(options) {
  const kind = make("select", { id: "load-kind", "aria-label": "Kind of load" });
  for (const [key, name] of Object.entries(LOADS)) kind.append(make("option", { value: key }, name));
  const input = make("input", { type: "text", id: "option-load", value: "0.02, 0.05, 0.1", spellcheck: "false", autocomplete: "off" });
  const help = make("small", {});
  const error = make("p", { class: "error", role: "alert", hidden: true });
  const box = make("div", { class: "field" }, make("label", { for: "option-load" }, "Load"), make("span", { class: "pair" }, kind, input), help, error);
  const usual = { p_star: "0.02, 0.05, 0.1", pressure: "10MPa", force: "1N", approach: "" };
  const explain = () => (help.textContent = options.find((option) => option.key === kind.value)?.meaning ?? "");
  kind.addEventListener("change", () => {
    input.value = usual[kind.value];
    explain();
  });
  explain();
  for (const option of options) {
    const read = () => (kind.value === option.key ? input.value.replaceAll(/\s*,\s*/g, ",").trim() || undefined : undefined);
    const entry = { option, box, input, error, read, write: () => {} };
    state.options.set(option.key, entry);
    input.addEventListener("input", () => mark(entry, null));
  }
  return box;
}

function answers(keep) {
  const found = {};
  for (const [key, entry] of state.options) {
    const value = keep(entry.option) ? entry.read() : undefined;
    if (value !== undefined && value !== "") found[key] = value;
  }
  return found;
}

// ---- Scan

async function send(file) {
  if (!file) return;
  tell("scan-error", null);
  $("scan-status").textContent = `Reading ${file.name} …`;
  try {
    if (file.size > state.limit) throw new Error(`the file is too large; it must be at most ${Math.floor(state.limit / 1048576)} MiB (--upload-limit)`);
    const headers = { "Content-Type": "application/octet-stream", "X-Name": encodeURIComponent(file.name) };
    const about = await (await ask("upload", { method: "POST", headers, body: file })).json();
    state.scan = about.scan;
    state.about = about;
    describe(about);
    $("prepare").disabled = $("press").disabled = false;
    await show({ kind: "raw", scan: about.scan });
    await prepare();
  } catch (error) {
    tell("scan-error", error);
  }
  $("scan-status").textContent = "";
  $("file").value = "";
}

function describe(about) {
  const share = (100 * about.undefined) / (about.n[0] * about.n[1]);
  const facts = [
    ["file", about.name],
    ["format", about.format],
    ["points", about.n[1] === 1 ? about.n[0] : about.n.join(" x ")],
    ["size", about.size ?? "not in the file; the cell is taken to be 1 long"],
    ["unit", about.unit ?? "not in the file"],
    ["missing points", about.undefined ? `${about.undefined} (${share.toPrecision(3)} %)` : "none"],
  ];
  $("about").replaceChildren(...facts.flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, String(text))]));
  const notes = [...about.notes];
  if (!about.unit) notes.unshift("The file names no unit: give one, such as um, to use quantities with a unit such as 70GPa. Without one all numbers are in any consistent units.");
  $("notes").replaceChildren(...notes.map((note) => make("li", {}, note)));
  // Usual choices for a scan, which the user sees and may change.
  state.options.get("detrend").write("plane");
  state.options.get("fill").write(about.undefined ? "harmonic" : undefined);
  state.options.get("boundary").write("free");
  const channel = state.options.get("channel");
  channel.write(undefined);
  const material = about.unit ? "steel" : "numbers without a unit: E = 1";
  if (!state.options.get("young").read()) {
    $("material").value = material;
    $("material").dispatchEvent(new Event("change"));
  }
  if (about.channels.length > 1) channel.box.closest("details")?.setAttribute("open", "");
}

async function prepare() {
  $("prepare-status").textContent = "Preparing …";
  refuse("prepare-error", null);
  try {
    const told = await post("prepare", { scan: state.scan, options: answers((option) => option.prepares) });
    const row = ({ name, text, meaning }) => make("tr", {}, make("th", { scope: "row" }, name.replaceAll("_", " ")), make("td", {}, text), make("td", {}, meaning));
    $("numbers").replaceChildren(...told.numbers.map(row));
    await show({ kind: "prepared", scan: state.scan });
  } catch (error) {
    refuse("prepare-error", error);
  }
  $("prepare-status").textContent = "";
}

// ---- Runs

async function press() {
  refuse("press-error", null);
  $("press-status").textContent = "Starting …";
  try {
    const { run } = await post("run", { scan: state.scan, options: answers(() => true) });
    state.chosen = run;
    await poll();
  } catch (error) {
    refuse("press-error", error);
  }
  $("press-status").textContent = "";
}

const PHASES = { waiting: "waits for another run", running: "runs", done: "done", stopped: "stopped", failed: "failed" };
let polling = null;

async function poll() {
  clearTimeout(polling);
  const before = new Map(state.runs.map((run) => [run.state.run, run.state.phase]));
  try {
    state.runs = await get("runs");
  } catch (error) {
    tell("press-error", error);
    polling = setTimeout(poll, 3000);
    return;
  }
  list();
  for (const run of state.runs) {
    const { phase, message } = run.state;
    const ended = before.get(run.state.run) !== phase && !["waiting", "running"].includes(phase);
    if (ended && run.state.run === state.chosen) {
      if (phase === "failed") refuse("press-error", new Error(message));
      if (run.state.found) await result(run);
    }
  }
  if (state.runs.some((run) => ["waiting", "running"].includes(run.state.phase))) polling = setTimeout(poll, 400);
}

function list() {
  $("runs-section").hidden = state.runs.length === 0;
  const rows = state.runs.map((run) => {
    const { phase, message, name, found } = run.state;
    const active = phase === "waiting" || phase === "running";
    const pressed = run.state.run === state.chosen ? "true" : "false";
    const button = active
      ? make("button", { type: "button", "aria-label": `Stop ${name}`, onclick: () => post(`stop/${run.state.run}`, {}).then(poll) }, "Stop")
      : make("button", { type: "button", "aria-pressed": pressed, disabled: !found, onclick: () => result(run) }, "Show");
    const row = make("li", {}, make("span", {}, `${name}: ${PHASES[phase]}`), button);
    if (phase === "running") {
      row.append(make("progress", { max: "1", value: run.progress.share || null, "aria-label": `Progress of ${name}` }));
    }
    const note = active ? run.progress.note : message;
    if (note) row.append(make("span", { class: `note${phase === "failed" ? " error" : ""}` }, note));
    return row;
  });
  const focused = document.activeElement?.getAttribute("aria-label");
  $("runs").replaceChildren(...rows);
  if (focused) [...$("runs").querySelectorAll("button")].find((button) => button.getAttribute("aria-label") === focused)?.focus();
}

async function result(run) {
  state.chosen = run.state.run;
  list();
  const { found } = run.state;
  $("result").hidden = false;
  $("result-title").textContent = `Result ${run.state.name}`;
  const links = [];
  if (found.page) links.push(make("a", { class: "button", href: `file/${run.state.run}/page`, target: "_blank", rel: "noopener" }, "Open the page"), make("a", { class: "button", href: `file/${run.state.run}/page`, download: found.page }, "Page (HTML)"));
  if (found.file) links.push(make("a", { class: "button", href: `file/${run.state.run}/result`, download: found.file }, "All fields (HDF5)"));
  $("downloads").replaceChildren(...links.flatMap((link) => [link, " "]));
  $("sheets").replaceChildren(...found.sheets.flatMap(sheet));
  $("lines").replaceChildren(...[...found.warnings, ...found.lines].map((line) => make("li", {}, line)));
  $("head").textContent = found.head;
  $("command").textContent = run.command;
  $("python").textContent = run.python ?? `# ${run.no_python}`;
  const first = found.fields.find((known) => known.name === "pressure") ?? found.fields[0];
  if (first) await show({ kind: "run", run: run.state.run, field: first.name, load: found.loads - 1 });
}

function sheet({ title, columns }) {
  const rows = columns[0].map((_, index) => {
    const cells = columns.map((column) => make(index === 0 ? "th" : "td", index === 0 ? { scope: "col" } : {}, column[index]));
    return make("tr", { "data-load": index === 0 ? null : index - 1 }, ...cells);
  });
  return [make("h3", {}, title), make("div", { class: "sheet" }, make("table", {}, ...rows))];
}

// ---- Map

const STOPS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"].map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
function colour(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const [below, rest] = [Math.min(Math.floor(at), STOPS.length - 2), at - Math.min(Math.floor(at), STOPS.length - 2)];
  return STOPS[below].map((value, k) => Math.round(value + rest * (STOPS[below + 1][k] - value)));
}
const view = { map: null, image: null, zoom: 1, x: 0, y: 0, section: null };

async function numbers(path) {
  const bytes = await (await ask(path)).arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  return { ...head, values: new Float32Array(bytes, 4 + length) };
}

const text = (value, unit) => (Number.isFinite(value) ? `${Number(value.toPrecision(6))}${unit ? ` ${unit}` : ""}` : "missing");

/** Shows the map of a scan, or of a field of a run. */
async function show(what) {
  const same = view.what && view.what.kind === "run" && what.kind === "run" && view.what.run === what.run;
  let map;
  try {
    map = await numbers(what.kind === "run" ? `map/run/${what.run}/${what.field}/${what.load}` : `map/${what.kind}/${what.scan}`);
  } catch (error) {
    tell("press-error", error);
    return;
  }
  const kept = same && view.map && map.n.every((count, axis) => count === view.map.n[axis]);
  if (!kept) Object.assign(view, { zoom: 1, x: 0, y: 0, section: null });
  Object.assign(view, { map, what });
  $("view").hidden = false;
  const run = what.kind === "run" ? state.runs.find((run) => run.state.run === what.run) : null;
  $("numbers-section").hidden = what.kind !== "prepared";
  $("result").hidden = what.kind !== "run";
  $("view-title").textContent = run ? `${run.state.name}: ${what.field.replaceAll("_", " ")}` : `${state.about.name}: ${what.kind === "raw" ? "as in the file" : "prepared"}`;
  tools(what, run);
  const thinned = map.step > 1 ? ` Every ${map.step}th point of ${map.points.join(" x ")} is shown.` : "";
  const missing = map.undefined ? ` ${map.undefined} points are missing.` : "";
  $("meaning").textContent = `${map.meaning}.${missing}${thinned}`;
  $("map").setAttribute("aria-label", `Map: ${map.meaning}, from ${text(map.lowest, map.unit)} to ${text(map.highest, map.unit)}`);
  $("lowest").textContent = text(map.lowest, map.unit);
  $("highest").textContent = text(map.highest, map.unit);
  $("pointer").textContent = "";
  paint();
  draw();
}

function tools(what, run) {
  const button = (name, on, act) => make("button", { type: "button", "aria-pressed": on ? "true" : "false", onclick: act }, name);
  const choices = [];
  if (state.scan !== null) {
    choices.push(button("Scan", what.kind === "raw", () => show({ kind: "raw", scan: state.scan })));
    choices.push(button("Prepared", what.kind === "prepared", () => show({ kind: "prepared", scan: state.scan })));
  }
  if (run) {
    for (const { name } of run.state.found.fields) {
      const label = name[0].toUpperCase() + name.slice(1).replaceAll("_", " ");
      choices.push(button(label, name === what.field, () => show({ ...what, field: name })));
    }
  }
  $("choices").replaceChildren(...choices);
  const loads = run ? run.state.found.loads : 1;
  $("load-label").hidden = loads < 2;
  $("load").max = loads - 1;
  $("load").value = what.load ?? 0;
  if (run) {
    const [heads, row] = [run.state.found.sheets[0]?.columns[0] ?? [], (what.load ?? 0) + 1];
    $("load-text").textContent = `${row} of ${loads}${heads[row] ? `: ${heads[0]} ${heads[row].trim()}` : ""}`;
    for (const tr of document.querySelectorAll("#sheets tr[data-load]")) tr.classList.toggle("chosen", Number(tr.dataset.load) === (what.load ?? 0));
  }
}

/** Makes the picture of the numbers, one pixel for each point; y goes up. */
function paint() {
  const { n: [nx, ny], values, lowest, highest } = view.map;
  const range = highest - lowest || 1;
  const image = new ImageData(nx, ny);
  const hollow = view.what.field === "pressure" && lowest === 0;
  for (let j = 0; j < ny; j++) {
    for (let i = 0; i < nx; i++) {
      const value = values[j * nx + i];
      const at = 4 * ((ny - 1 - j) * nx + i);
      // Points without a number are red; points without pressure show the ground.
      const [r, g, b, a] = !Number.isFinite(value) ? [214, 48, 49, 255] : hollow && value === 0 ? [0, 0, 0, 0] : [...colour((value - lowest) / range), 255];
      image.data.set([r, g, b, a], at);
    }
  }
  view.image = new OffscreenCanvas(nx, ny);
  view.image.getContext("2d").putImageData(image, 0, 0);
  const bar = $("colours");
  bar.width = 256;
  bar.height = 1;
  const line = bar.getContext("2d").createImageData(256, 1);
  for (let k = 0; k < 256; k++) line.data.set([...colour(k / 255), 255], 4 * k);
  bar.getContext("2d").putImageData(line, 0, 0);
}

const isLine = () => view.map.n[1] === 1;

/** Sizes of the picture: pixels of the screen for the whole map without zoom. */
function frame() {
  const canvas = $("map");
  const width = canvas.clientWidth || 600;
  const [lx, ly] = isLine() ? [3, 1] : view.map.size;
  return { width, height: Math.min(Math.max((width * ly) / lx, 120), Math.max(320, 0.72 * window.innerHeight)) };
}

function draw() {
  if (!view.map) return;
  const canvas = $("map");
  const { width, height } = frame();
  const ratio = window.devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  if (isLine()) {
    chart(pen, width, height, curve({ from: [0, 0], to: [1, 0] }));
    $("section").hidden = true;
    return;
  }
  const { scale, left, top } = place();
  const [nx, ny] = view.map.n;
  pen.imageSmoothingEnabled = false;
  const side = scale.map((value, axis) => value * [nx, ny][axis]);
  pen.drawImage(view.image, left, top, side[0], side[1]);
  if (view.section) {
    const [from, to] = [view.section.from, view.section.to].map(([u, v]) => [left + u * side[0], top + (1 - v) * side[1]]);
    for (const [color, thick] of [["#000", 4], ["#fff", 2]]) {
      pen.strokeStyle = color;
      pen.lineWidth = thick;
      pen.beginPath();
      pen.moveTo(...from);
      pen.lineTo(...to);
      pen.stroke();
    }
  }
  $("section").hidden = !view.section;
  if (view.section) {
    const below = $("section");
    below.width = Math.round(below.clientWidth * ratio);
    below.height = Math.round(below.clientHeight * ratio);
    const other = below.getContext("2d");
    other.scale(ratio, ratio);
    chart(other, below.clientWidth, below.clientHeight, curve(view.section));
  }
}

/** Place of the map on the screen: pixels of a point along x and y, and the upper left corner. */
function place() {
  const { width, height } = frame();
  const [lx, ly] = view.map.size;
  const fit = Math.min(width / lx, height / ly) * view.zoom;
  const side = [fit * lx, fit * ly];
  const clamp = (shift, whole, part) => (part <= whole ? 0 : Math.min(Math.max(shift, (whole - part) / 2), (part - whole) / 2));
  view.x = clamp(view.x, width, side[0]);
  view.y = clamp(view.y, height, side[1]);
  return { scale: side.map((value, axis) => value / view.map.n[axis]), left: (width - side[0]) / 2 + view.x, top: (height - side[1]) / 2 + view.y, side };
}

/** Returns the place on the map, 0 to 1 along x and y, below a point of the screen. */
function under(event) {
  const box = $("map").getBoundingClientRect();
  const { left, top, side } = place();
  return [(event.clientX - box.left - left) / side[0], 1 - (event.clientY - box.top - top) / side[1]];
}

function valueAt([u, v]) {
  const [nx, ny] = view.map.n;
  const [i, j] = [Math.floor(u * nx), Math.floor(v * ny)];
  return i >= 0 && j >= 0 && i < nx && j < ny ? view.map.values[j * nx + i] : undefined;
}

/** Returns distances and numbers along a section. */
function curve({ from, to }) {
  const [nx, ny] = view.map.n;
  const count = Math.min(2048, Math.max(2, Math.ceil(Math.hypot((to[0] - from[0]) * nx, (to[1] - from[1]) * ny))));
  const length = Math.hypot((to[0] - from[0]) * view.map.size[0], isLine() ? 0 : (to[1] - from[1]) * view.map.size[1]);
  const points = [];
  for (let k = 0; k < count; k++) {
    const share = (k + 0.5) / count;
    points.push([share * length, valueAt([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])])]);
  }
  return { points, length };
}

/** Draws numbers against distance. */
function chart(pen, width, height, { points, length }) {
  const style = getComputedStyle(document.body);
  const [left, right, top, bottom] = [64, 12, 10, 34];
  const known = points.filter(([, value]) => Number.isFinite(value)).map(([, value]) => value);
  const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
  const range = high - low || Math.abs(high) || 1;
  const x = (distance) => left + ((width - left - right) * distance) / (length || 1);
  const y = (value) => height - bottom - ((height - top - bottom) * (value - low)) / range;
  pen.clearRect(0, 0, width, height);
  pen.strokeStyle = style.getPropertyValue("--line");
  pen.strokeRect(left, top, width - left - right, height - top - bottom);
  pen.fillStyle = style.color;
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "right";
  pen.fillText(String(Number(high.toPrecision(4))), left - 5, top + 10);
  pen.fillText(String(Number(low.toPrecision(4))), left - 5, height - bottom);
  pen.textAlign = "left";
  pen.fillText("0", left, height - bottom + 14);
  pen.textAlign = "right";
  pen.fillText(text(Number(length.toPrecision(4)), view.map.length_unit), width - right, height - bottom + 14);
  pen.textAlign = "center";
  pen.fillText("distance along the section", left + (width - left - right) / 2, height - 4);
  pen.save();
  pen.translate(14, top + (height - top - bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.fillText([(view.what.field ?? "height").replaceAll("_", " "), view.map.unit].filter(Boolean).join(" / "), 0, 0);
  pen.restore();
  pen.strokeStyle = style.getPropertyValue("--accent");
  pen.lineWidth = 1.5;
  pen.beginPath();
  let open = false;
  for (const [distance, value] of points) {
    if (!Number.isFinite(value)) open = false;
    else if (open) pen.lineTo(x(distance), y(value));
    else {
      pen.moveTo(x(distance), y(value));
      open = true;
    }
  }
  pen.stroke();
}

function zoom(factor, [x, y]) {
  const before = view.zoom;
  view.zoom = Math.min(Math.max(before * factor, 1), 64);
  const { width, height } = frame();
  const real = view.zoom / before;
  view.x = (view.x + width / 2 - x) * real + x - width / 2;
  view.y = (view.y + height / 2 - y) * real + y - height / 2;
  draw();
}

function watchMap() {
  const canvas = $("map");
  let drag = null;
  canvas.addEventListener("wheel", (event) => {
    if (!view.map || isLine()) return;
    event.preventDefault();
    const box = canvas.getBoundingClientRect();
    zoom(Math.exp(-event.deltaY / 300), [event.clientX - box.left, event.clientY - box.top]);
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (!view.map || isLine()) return;
    canvas.setPointerCapture(event.pointerId);
    drag = { from: under(event), last: [event.clientX, event.clientY], move: event.shiftKey || event.button === 1 };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!view.map) return;
    if (drag?.move) {
      view.x += event.clientX - drag.last[0];
      view.y += event.clientY - drag.last[1];
      drag.last = [event.clientX, event.clientY];
      draw();
    } else if (drag) {
      view.section = { from: drag.from, to: under(event) };
      draw();
    }
    const box = canvas.getBoundingClientRect();
    const at = isLine() ? [(event.clientX - box.left - 64) / (box.width - 76), 0] : under(event);
    const value = valueAt(at);
    const [lx, ly] = view.map.size;
    const where = isLine() ? `x = ${text(at[0] * lx, view.map.length_unit)}` : `x = ${text(at[0] * lx, view.map.length_unit)}, y = ${text(at[1] * ly, view.map.length_unit)}`;
    $("pointer").textContent = value === undefined ? "" : `${where}: ${text(value, view.map.unit)}`;
  });
  const end = () => (drag = null);
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("keydown", (event) => {
    if (!view.map || isLine()) return;
    const { width, height } = frame();
    const middle = [width / 2, height / 2];
    const moves = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
    const { left, top, side } = place();
    const centre = [(middle[0] - left) / side[0], 1 - (middle[1] - top) / side[1]];
    if (event.key === "+" || event.key === "=") zoom(1.5, middle);
    else if (event.key === "-") zoom(1 / 1.5, middle);
    else if (event.key === "Home") whole();
    else if (event.key === "x") view.section = { from: [0, centre[1]], to: [1, centre[1]] };
    else if (event.key === "y") view.section = { from: [centre[0], 0], to: [centre[0], 1] };
    else if (event.key === "Escape") view.section = null;
    else if (moves[event.key]) {
      view.x += moves[event.key][0];
      view.y += moves[event.key][1];
    } else return;
    event.preventDefault();
    draw();
  });
  window.addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

function whole() {
  Object.assign(view, { zoom: 1, x: 0, y: 0 });
  draw();
}

async function begin() {
  const { options, folder, limit } = await get("form");
  state.limit = limit;
  $("folder").textContent = folder;
  build(options);
  watchMap();
  $("file").addEventListener("change", () => send($("file").files[0]));
  const drop = $("drop");
  drop.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      $("file").click();
    }
  });
  for (const name of ["dragover", "dragenter"]) {
    document.addEventListener(name, (event) => {
      event.preventDefault();
      drop.classList.add("over");
    });
  }
  document.addEventListener("dragleave", () => drop.classList.remove("over"));
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    send(event.dataTransfer?.files[0]);
  });
  $("prepare").addEventListener("click", prepare);
  $("form").addEventListener("submit", (event) => {
    event.preventDefault();
    if (!$("press").disabled) press();
  });
  $("whole").addEventListener("click", whole);
  $("load").addEventListener("input", () => view.what?.kind === "run" && show({ ...view.what, load: Number($("load").value) }));
  await poll();
}
begin().catch((error) => tell("scan-error", error));
