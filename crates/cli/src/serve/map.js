// Maps of the page: numbers of the server as a picture with zoom, sections and values under the pointer.
"use strict";

const STOPS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"].map(
    (hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)),
);
function colour(share) {
    const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
    const [below, rest] = [Math.min(Math.floor(at), STOPS.length - 2), at - Math.min(Math.floor(at), STOPS.length - 2)];
    return STOPS[below].map((value, k) => Math.round(value + rest * (STOPS[below + 1][k] - value)));
}
// `detail` has all points of the visible part of a map that is sent with every second, third, ... point.
const view = { map: null, detail: null, image: null, zoom: 1, x: 0, y: 0, section: null };

async function numbers(path) {
    const bytes = await (await ask(path)).arrayBuffer();
    const length = new DataView(bytes).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
    return { ...head, values: new Float32Array(bytes, 4 + length) };
}

/** Returns a number with its unit, and with a power of ten if it is small or large. */
function text(value, unit) {
    if (!Number.isFinite(value)) return "missing";
    const size = Math.abs(value);
    const number =
        size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(4) : String(Number(value.toPrecision(6)));
    return unit ? `${number} ${unit}` : number;
}

/** Shows the map of a scan, or of a field of a run. */
async function show(what) {
    const same = view.what && view.what.kind === "run" && what.kind === "run" && view.what.run === what.run;
    const path =
        what.kind === "run" ? `map/run/${what.run}/${what.field}/${what.load}` : `map/${what.kind}/${what.scan}`;
    let map;
    try {
        map = await numbers(path);
    } catch (error) {
        tell("press-error", error);
        return;
    }
    const kept = same && view.map && map.n.every((count, axis) => count === view.map.n[axis]);
    if (!kept) Object.assign(view, { zoom: 1, x: 0, y: 0, section: null });
    Object.assign(view, { map, what, path, detail: null });
    $("view").hidden = false;
    const run = what.kind === "run" ? state.runs.find((run) => run.state.run === what.run) : null;
    $("numbers-section").hidden = what.kind !== "prepared";
    $("result").hidden = what.kind !== "run";
    $("view-title").textContent = run
        ? `${run.state.name}: ${what.field.replaceAll("_", " ")}`
        : `${state.about.name}: ${what.kind === "raw" ? "as in the file" : "prepared"}`;
    tools(what, run);
    const thinned =
        map.step > 1
            ? ` One of ${map.step} points along each side of ${map.points.join(" x ")} is shown; zoomed, more.`
            : "";
    const missing = map.undefined ? ` ${map.undefined} points are missing (red).` : "";
    $("meaning").textContent = `${map.meaning}.${missing}${thinned}`;
    $("map").setAttribute(
        "aria-label",
        `Map: ${map.meaning}, from ${text(map.lowest, map.unit)} to ${text(map.highest, map.unit)}`,
    );
    map.brightest = brightest(map, what.field);
    const largest = text(map.highest, map.unit);
    // Rounding leaves gaps of zero a little below it.
    $("lowest").textContent = text(Math.abs(map.lowest) < 1e-8 * map.highest ? 0 : map.lowest, map.unit);
    const bright = text(Number(map.brightest.toPrecision(4)), map.unit);
    $("highest").textContent = map.brightest < map.highest ? `${bright} and above, up to ${largest}` : largest;
    $("pointer").textContent = "";
    view.image = picture(map);
    bar();
    draw();
}

function tools(what, run) {
    const button = (name, on, act) =>
        make("button", { type: "button", "aria-pressed": on ? "true" : "false", onclick: act }, name);
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
        $("load-text").textContent =
            `${row - 1} (${row} of ${loads})${heads[row] ? `: ${heads[0]} ${heads[row].trim()}` : ""}`;
        for (const tr of document.querySelectorAll("#sheets tr[data-load]"))
            tr.classList.toggle("chosen", Number(tr.dataset.load) === (what.load ?? 0));
    }
}

/** Returns the upper end of the colours. A few sharp peaks would make all other pressures dark. */
function brightest({ values, lowest, highest }, field) {
    if (field !== "pressure" || lowest !== 0) return highest;
    const pressed = values.filter((value) => value > 0).sort();
    const most = pressed[Math.floor(0.99 * pressed.length)];
    return highest > 2 * most ? most : highest;
}

/** Makes the picture of the numbers, one pixel for each point; y goes up. */
function picture({ n: [nx, ny], values }) {
    const { lowest, brightest } = view.map;
    const range = brightest - lowest || 1;
    const image = new ImageData(nx, ny);
    const hollow = view.what.field === "pressure" && lowest === 0;
    for (let j = 0; j < ny; j++) {
        for (let i = 0; i < nx; i++) {
            const value = values[j * nx + i];
            const at = 4 * ((ny - 1 - j) * nx + i);
            // Points without a number are red; points without pressure show the ground.
            const [r, g, b, a] = !Number.isFinite(value)
                ? [214, 48, 49, 255]
                : hollow && value === 0
                  ? [0, 0, 0, 0]
                  : [...colour((value - lowest) / range), 255];
            image.data.set([r, g, b, a], at);
        }
    }
    const canvas = new OffscreenCanvas(nx, ny);
    canvas.getContext("2d").putImageData(image, 0, 0);
    return canvas;
}

/** Draws the colours. */
function bar() {
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
    if (view.detail) {
        const { from, step, n, image } = view.detail;
        const size = [0, 1].map((axis) => side[axis] / view.map.points[axis]);
        const [width, height] = [0, 1].map((axis) => n[axis] * step * size[axis]);
        pen.drawImage(image, left + from[0] * size[0], top + side[1] - from[1] * size[1] - height, width, height);
    }
    clearTimeout(refining);
    if (view.map.step > 1) refining = setTimeout(refine, 200);
    if (view.section) {
        const [from, to] = [view.section.from, view.section.to].map(([u, v]) => [
            left + u * side[0],
            top + (1 - v) * side[1],
        ]);
        for (const [color, thick] of [
            ["#000", 4],
            ["#fff", 2],
        ]) {
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

let refining = null;
/** Asks for the points of the visible part if they are finer than the ones that are there. */
async function refine() {
    const { map, path } = view;
    const { width, height } = frame();
    const { left, top, side } = place();
    const ends = [
        [-left / side[0], (width - left) / side[0]],
        [1 - (height - top) / side[1], 1 + top / side[1]],
    ];
    const [from, to] = [0, 1].map((end) =>
        ends.map((pair, axis) => {
            const point = Math.min(Math.max(pair[end], 0), 1) * map.points[axis];
            return end ? Math.ceil(point) : Math.floor(point);
        }),
    );
    const count = to.map((point, axis) => point - from[axis]);
    const step = Math.ceil(Math.max(...count) / Math.max(...map.n));
    const { detail } = view;
    const isInside = (axis) =>
        from[axis] >= detail.from[axis] && to[axis] <= detail.from[axis] + detail.n[axis] * detail.step;
    if (step >= map.step || (detail && detail.step <= step && isInside(0) && isInside(1))) return;
    const found = await numbers(`${path}/part/${from.join("/")}/${count.join("/")}`).catch(() => null);
    if (!found || view.map !== map) return;
    view.detail = { ...found, image: picture(found) };
    draw();
}

/** Place of the map on the screen: pixels of a point along x and y, and the upper left corner. */
function place() {
    const { width, height } = frame();
    const [lx, ly] = view.map.size;
    const fit = Math.min(width / lx, height / ly) * view.zoom;
    const side = [fit * lx, fit * ly];
    const clamp = (shift, whole, part) =>
        part <= whole ? 0 : Math.min(Math.max(shift, (whole - part) / 2), (part - whole) / 2);
    view.x = clamp(view.x, width, side[0]);
    view.y = clamp(view.y, height, side[1]);
    return {
        scale: side.map((value, axis) => value / view.map.n[axis]),
        left: (width - side[0]) / 2 + view.x,
        top: (height - side[1]) / 2 + view.y,
        side,
    };
}

/** Returns the place on the map, 0 to 1 along x and y, below a point of the screen. */
function under(event) {
    const box = $("map").getBoundingClientRect();
    const { left, top, side } = place();
    return [(event.clientX - box.left - left) / side[0], 1 - (event.clientY - box.top - top) / side[1]];
}

function valueAt([u, v]) {
    if (view.detail) {
        const { from, step, n, values } = view.detail;
        const [i, j] = [u, v].map((share, axis) => Math.floor((share * view.map.points[axis] - from[axis]) / step));
        if (i >= 0 && j >= 0 && i < n[0] && j < n[1]) return values[j * n[0] + i];
    }
    const [nx, ny] = view.map.n;
    const [i, j] = [Math.floor(u * nx), Math.floor(v * ny)];
    return i >= 0 && j >= 0 && i < nx && j < ny ? view.map.values[j * nx + i] : undefined;
}

/** Returns distances and numbers along a section. */
function curve({ from, to }) {
    const [nx, ny] = view.detail ? view.map.points : view.map.n;
    const count = Math.min(2048, Math.max(2, Math.ceil(Math.hypot((to[0] - from[0]) * nx, (to[1] - from[1]) * ny))));
    const length = Math.hypot(
        (to[0] - from[0]) * view.map.size[0],
        isLine() ? 0 : (to[1] - from[1]) * view.map.size[1],
    );
    const points = [];
    for (let k = 0; k < count; k++) {
        const share = (k + 0.5) / count;
        points.push([
            share * length,
            valueAt([from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]),
        ]);
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
    pen.strokeStyle = getComputedStyle($("map")).borderTopColor;
    pen.strokeRect(left, top, width - left - right, height - top - bottom);
    pen.fillStyle = style.color;
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.fillText(text(Number(high.toPrecision(4))), left - 5, top + 10);
    pen.fillText(text(Number(low.toPrecision(4))), left - 5, height - bottom);
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
    pen.strokeStyle = getComputedStyle($("prepare")).color;
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
    canvas.addEventListener(
        "wheel",
        (event) => {
            if (!view.map || isLine()) return;
            event.preventDefault();
            const box = canvas.getBoundingClientRect();
            zoom(Math.exp(-event.deltaY / 300), [event.clientX - box.left, event.clientY - box.top]);
        },
        { passive: false },
    );
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
        const where = isLine()
            ? `x = ${text(at[0] * lx, view.map.length_unit)}`
            : `x = ${text(at[0] * lx, view.map.length_unit)}, y = ${text(at[1] * ly, view.map.length_unit)}`;
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
