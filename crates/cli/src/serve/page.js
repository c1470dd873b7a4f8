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
    (
        await ask(path, {
            method: "POST",
            headers: { "Content-Type": "application/json" },
            body: JSON.stringify(value),
        })
    ).json();

function tell(id, error) {
    $(id).textContent = error ? error.message || String(error) : "";
    $(id).hidden = !error;
}

// ---- Form

// What a number of a kind may look like.
const EXAMPLES = { length: "10um", stress: "70GPa", force: "1N", time: "1s", velocity: "1mm/s" };

// Options that are seen at once; all others are below "More".
const USUAL = {
    preparation: ["unit", "size", "detrend", "fill", "periodise", "flip"],
    problem: ["young", "poisson", "height", "boundary"],
};
const LOADS = { p_star: "Reduced pressure p*", pressure: "Mean pressure", force: "Force", approach: "Approach" };
const OWN = "choose, or type below";
const BARE = "numbers without a unit: E = 1";
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
        const kinds = [...new Set(option.kinds.filter((kind) => kind !== "1"))];
        const place =
            option.default ||
            (kinds.length === 1 && EXAMPLES[kinds[0]] && `such as ${EXAMPLES[kinds[0]]}`) ||
            [option.value.toLowerCase(), kinds.length && `(${kinds.join(", ")})`].filter(Boolean).join(" ");
        input = make("input", {
            type: "text",
            id,
            placeholder: place,
            spellcheck: "false",
            autocomplete: "off",
            "aria-describedby": help,
        });
        write = (value) => (input.value = value === true ? "" : (value ?? ""));
        // Values that have names, beside others that have none.
        const names = option.value.split("|").filter((name) => /^[a-z-]+$/.test(name));
        if (names.length > 1) {
            box.append(
                make("datalist", { id: `${id}-names` }, ...names.map((name) => make("option", { value: name }))),
            );
            input.setAttribute("list", `${id}-names`);
        }
        const text = () => {
            const value = input.value.trim();
            if (!value) return undefined;
            return option.repeats
                ? value
                      .split(";")
                      .map((part) => part.trim())
                      .filter(Boolean)
                : value;
        };
        if (option.bare) {
            const check = make("input", { type: "checkbox", "aria-label": `${named(option)} with usual values` });
            input.addEventListener("input", () => (check.checked = check.checked || input.value.trim() !== ""));
            read = () => (check.checked ? (text() ?? true) : undefined);
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
        if (!document.activeElement?.matches("input, select")) entry.input.focus();
    }
    tell(id, error);
}

function build(options, materials) {
    const places = { preparation: $("preparation"), problem: $("problem") };
    const groups = new Map();
    for (const option of options) {
        if (option.group === "Load") continue;
        const entry = field(option);
        state.options.set(option.key, entry);
        // The list of materials sets it.
        if (option.key === "material") continue;
        const place = option.group === "Surface" || option.group === "Preparation" ? "preparation" : "problem";
        if (USUAL[place].includes(option.key)) continue;
        const name = `${place}:${option.group}`;
        if (!groups.has(name))
            groups.set(name, make("details", {}, make("summary", {}, `More: ${option.group.toLowerCase()}`)));
        groups.get(name).append(entry.box);
    }
    for (const [place, keys] of Object.entries(USUAL)) {
        for (const key of keys) if (state.options.has(key)) places[place].append(state.options.get(key).box);
    }
    places.problem.append(loads(options.filter((option) => option.group === "Load")));
    for (const [name, group] of groups) places[name.split(":")[0]].append(group);
    for (const name of [OWN, ...Object.keys(materials), BARE])
        $("material").append(make("option", { value: name }, name));
    $("material").addEventListener("change", () => {
        const name = $("material").value;
        const found = materials[name];
        $("material-source").textContent = found ? `E = ${found.young}, nu = ${found.poisson}: ${found.source}` : "";
        const [material, young, poisson] = ["material", "young", "poisson"].map((key) => state.options.get(key));
        material.write(found ? name : "");
        if (name === OWN && !found) return;
        young.write(found ? "" : "1");
        poisson.write(found ? "" : "0");
    });
    // A value that is typed replaces the one of the material, whose other value stays.
    for (const key of ["young", "poisson", "e_star"]) {
        state.options.get(key).input.addEventListener("input", () => {
            const found = materials[$("material").value];
            $("material").value = OWN;
            $("material").dispatchEvent(new Event("change"));
            const other = { young: "poisson", poisson: "young" }[key];
            if (found && other) state.options.get(other).write(String(found[other]));
        });
    }
}

/** Makes the fields of the load: one of its kinds, and its values. */
function loads(options) {
    const kind = make("select", { id: "load-kind" });
    for (const [key, name] of Object.entries(LOADS)) kind.append(make("option", { value: key }, name));
    const input = make("input", {
        type: "text",
        id: "option-load",
        value: "0.02, 0.05, 0.1",
        spellcheck: "false",
        autocomplete: "off",
    });
    const help = make("small", {});
    const error = make("p", { class: "error", role: "alert", hidden: true });
    const box = make(
        "div",
        { class: "field" },
        make("label", { for: "load-kind" }, "Load"),
        kind,
        make("label", { for: "option-load" }, "Values"),
        input,
        help,
        error,
    );
    const usual = { p_star: "0.02, 0.05, 0.1", pressure: "10MPa", force: "1N", approach: "" };
    const explain = () => (help.textContent = options.find((option) => option.key === kind.value)?.meaning ?? "");
    kind.addEventListener("change", () => {
        input.value = usual[kind.value];
        explain();
    });
    explain();
    for (const option of options) {
        const read = () =>
            kind.value === option.key ? input.value.replaceAll(/\s*,\s*/g, ",").trim() || undefined : undefined;
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
        if (file.size > state.limit)
            throw new Error(
                `the file is too large; it must be at most ${Math.floor(state.limit / 1048576)} MiB (--upload-limit)`,
            );
        const headers = { "Content-Type": "application/octet-stream", "X-Name": encodeURIComponent(file.name) };
        const about = await (await ask("upload", { method: "POST", headers, body: file })).json();
        state.scan = about.scan;
        state.about = about;
        describe(about);
        suggest(about);
        $("prepare").disabled = $("press").disabled = false;
        await show({ kind: "raw", scan: about.scan });
        await prepare();
    } catch (error) {
        tell("scan-error", error);
    }
    $("scan-status").textContent = "";
    $("file").value = "";
}

function describe(about, warnings = []) {
    const share = (100 * about.undefined) / (about.n[0] * about.n[1]);
    const facts = [
        ["file", about.name],
        ["format", about.format],
        ["points", about.n[1] === 1 ? about.n[0] : about.n.join(" x ")],
        ["size", about.size ?? "not in the file; the cell is taken to be 1 long"],
        ["unit", about.unit ?? "not in the file"],
        ["missing points", about.undefined ? `${about.undefined} (${share.toPrecision(3)} %)` : "none"],
    ];
    $("about").replaceChildren(
        ...facts.flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, String(text))]),
    );
    const notes = [...warnings, ...about.notes];
    if (!about.unit)
        notes.unshift(
            "The file names no unit: give one, such as um, to use quantities with a unit such as 70GPa. " +
                "Without one all numbers are in any consistent units.",
        );
    $("notes").replaceChildren(...notes.map((note) => make("li", {}, note)));
}

/** Makes the usual choices for a new scan, which the user sees and may change. */
function suggest(about) {
    state.options.get("detrend").write("plane");
    state.options.get("fill").write(about.undefined ? "harmonic" : undefined);
    state.options.get("boundary").write("free");
    const channel = state.options.get("channel");
    channel.write(undefined);
    suggestMaterial(Boolean(about.unit));
    if (about.channels.length > 1) channel.box.closest("details")?.setAttribute("open", "");
}

/** Without units the modulus is 1; with them the user chooses the material. */
function suggestMaterial(hasUnit) {
    const [young, poisson] = ["young", "poisson"].map((key) => state.options.get(key));
    if (!hasUnit && !young.read() && !state.options.get("e_star").read()) {
        $("material").value = BARE;
        $("material").dispatchEvent(new Event("change"));
    } else if (hasUnit && $("material").value === BARE) {
        $("material").value = OWN;
        young.write("");
        poisson.write("");
    }
}

let prepared = 0;
async function prepare() {
    const turn = ++prepared;
    $("prepare-status").textContent = "Preparing …";
    refuse("prepare-error", null);
    try {
        const told = await post("prepare", { scan: state.scan, options: answers((option) => option.prepares) });
        // A later preparation has begun.
        if (turn !== prepared) return;
        const row = ({ name, text, meaning }) =>
            make(
                "tr",
                {},
                make("th", { scope: "row" }, name.replaceAll("_", " ")),
                make("td", {}, text),
                make("td", {}, meaning),
            );
        describe(told.about, told.warnings);
        $("numbers").replaceChildren(...told.numbers.map(row));
        await show({ kind: "prepared", scan: state.scan });
    } catch (error) {
        if (turn === prepared) refuse("prepare-error", error);
    }
    if (turn === prepared) $("prepare-status").textContent = "";
}

// ---- Runs

async function press() {
    refuse("press-error", null);
    $("press-status").textContent = "Starting …";
    try {
        const { run } = await post("run", { scan: state.scan, options: answers(() => true) });
        state.chosen = run;
        await poll();
        $("runs-section").scrollIntoView();
    } catch (error) {
        refuse("press-error", error);
    }
    $("press-status").textContent = "";
}

const PHASES = {
    waiting: "waits for another run",
    running: "runs",
    done: "done",
    stopped: "stopped",
    failed: "failed",
};
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
            if (run.state.found) {
                await result(run);
                $("view").scrollIntoView();
            }
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
            ? make(
                  "button",
                  {
                      type: "button",
                      "aria-label": `Stop ${name}`,
                      onclick: () => post(`stop/${run.state.run}`, {}).then(poll),
                  },
                  "Stop",
              )
            : make(
                  "button",
                  { type: "button", "aria-pressed": pressed, disabled: !found, onclick: () => result(run) },
                  "Show",
              );
        const resume = () => post(`resume/${run.state.run}`, {}).then(poll, (error) => refuse("press-error", error));
        const again = make("button", { type: "button", "aria-label": `Resume ${name}`, onclick: resume }, "Resume");
        const buttons = make("span", { class: "buttons" }, ...(phase === "stopped" ? [again, button] : [button]));
        const row = make("li", {}, make("span", {}, `${name}: ${PHASES[phase]}`), buttons);
        if (phase === "running") {
            row.append(
                make("progress", { max: "1", value: run.progress.share || null, "aria-label": `Progress of ${name}` }),
            );
        }
        const note = active ? run.progress.note : message;
        if (note) row.append(make("span", { class: `note${phase === "failed" ? " error" : ""}` }, note));
        return row;
    });
    const focused = document.activeElement?.getAttribute("aria-label");
    $("runs").replaceChildren(...rows);
    if (focused)
        [...$("runs").querySelectorAll("button")]
            .find((button) => button.getAttribute("aria-label") === focused)
            ?.focus();
}

async function result(run) {
    state.chosen = run.state.run;
    list();
    const { found } = run.state;
    $("result").hidden = false;
    $("result-title").textContent = `Result ${run.state.name}`;
    const links = [];
    if (found.page)
        links.push(
            make(
                "a",
                { class: "button", href: `file/${run.state.run}/page`, target: "_blank", rel: "noopener" },
                "Open the page",
            ),
            make("a", { class: "button", href: `file/${run.state.run}/page`, download: found.page }, "Page (HTML)"),
        );
    if (found.file)
        links.push(
            make(
                "a",
                { class: "button", href: `file/${run.state.run}/result`, download: found.file },
                "All fields (HDF5)",
            ),
        );
    $("downloads").replaceChildren(...links.flatMap((link) => [link, " "]));
    $("sheets").replaceChildren(...found.sheets.flatMap(sheet));
    $("lines").replaceChildren(...[...found.warnings, ...found.lines].map((line) => make("li", {}, line)));
    $("head").textContent = found.head;
    $("command").textContent = run.command;
    $("python").textContent = run.python ?? `# ${run.no_python}`;
    $("copy-python").hidden = !run.python;
    const first = found.fields.find((known) => known.name === "pressure") ?? found.fields[0];
    if (first) await show({ kind: "run", run: run.state.run, field: first.name, load: found.loads - 1 });
}

function sheet({ title, columns }) {
    const numbered = [["load", ...columns[0].slice(1).map((_, load) => String(load))], ...columns];
    const rows = columns[0].map((_, index) => {
        const cells = numbered.map((column) =>
            make(index === 0 ? "th" : "td", index === 0 ? { scope: "col" } : {}, column[index]),
        );
        return make("tr", { "data-load": index === 0 ? null : index - 1 }, ...cells);
    });
    return [make("h3", {}, title), make("div", { class: "sheet" }, make("table", {}, ...rows))];
}

async function begin() {
    const { options, materials, folder, limit } = await get("form");
    state.limit = limit;
    $("folder").textContent = folder;
    build(options, materials);
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
    $("preparation").addEventListener("change", () => {
        if (state.scan === null) return;
        suggestMaterial(Boolean(state.about.unit || state.options.get("unit").read()));
        prepare();
    });
    state.options.get("boundary").input.addEventListener("change", () => state.scan !== null && prepare());
    $("form").addEventListener("submit", (event) => {
        event.preventDefault();
        if (!$("press").disabled) press();
    });
    $("whole").addEventListener("click", whole);
    for (const name of ["command", "python"]) {
        $(`copy-${name}`).addEventListener("click", async () => {
            await navigator.clipboard
                .writeText($(name).textContent)
                .catch(() => getSelection().selectAllChildren($(name)));
        });
    }
    $("load").addEventListener(
        "input",
        () => view.what?.kind === "run" && show({ ...view.what, load: Number($("load").value) }),
    );
    await poll();
}
begin().catch((error) => tell("scan-error", error));
