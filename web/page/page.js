// The page: a log goes to a worker, what comes back is shown as it comes. No number is made here.
const $ = (id) => document.getElementById(id);
const UNITS = { accel: "m/s²", gyro: "rad/s" };
const SENSORS = { accel: "Accelerometer", gyro: "Gyroscope" };
const AXES = [["x", "--x", ""], ["y", "--y", "7 3"], ["z", "--z", "2 2.5"]];
const PHASES = { rest: "at rest", motors: "motors on", moving: "moving" };
/** The texts that came back, to be saved as they are: what `dpn --json` prints. */
const results = {};
window.dpnResults = results;

async function unpacked(id) {
  const packed = Uint8Array.from(atob($(id).textContent.trim()), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
const compiled = unpacked("wasm").then((bytes) => WebAssembly.compile(bytes));
const workerUrl = URL.createObjectURL(new Blob([$("worker").textContent], { type: "text/javascript" }));
let worker = null;
let last = null;
let waiting = null;

/** Begins with a log; whatever ran before ends. */
async function begin(source, name, { topic, config } = {}) {
  stop();
  for (const key of Object.keys(results)) delete results[key];
  last = { source, name, config };
  $("drop").hidden = true;
  $("result").hidden = true;
  $("failure").hidden = true;
  $("work").hidden = false;
  $("status").textContent = `${name} …`;
  $("bar").removeAttribute("value");
  for (const id of ["findings", "noise", "allan", "paste", "config"]) $(id).replaceChildren();
  waiting = performance.now();
  const now = (worker = new Worker(workerUrl));
  now.onmessage = ({ data }) => { if (worker === now) take(data); };
  now.onerror = (event) => {
    event.preventDefault();
    if (worker === now && $("failure").hidden) fail("The reader ended without a word.\nLook at the log with `dpn check LOG`, and tell us of it.");
  };
  try {
    now.postMessage({ module: await compiled, source, name, topic, config });
  } catch (error) {
    fail(`This browser cannot run the page (${error.message}).\nTake one from the last three years, or the command line: \`dpn check LOG\`.`);
  }
}
function stop() {
  worker?.terminate();
  worker = null;
  $("work").hidden = true;
}
function home() {
  stop();
  $("result").hidden = true;
  $("failure").hidden = true;
  $("drop").hidden = false;
  $("file").focus();
}
function fail(text) {
  stop();
  const [what, ...hint] = text.split("\n");
  const box = $("failure");
  box.replaceChildren(el("h1", {}, what), ...(hint.length ? [el("p", {}, hint.join(" "))] : []));
  const topic = /--topic (\S+)/.exec(text);
  if (topic && last) {
    const field = el("input", { value: topic[1], "aria-label": "Topic", spellcheck: "false" });
    const form = el("form", { class: "actions" }, field, el("button", {}, "Read this topic"));
    form.onsubmit = (event) => { event.preventDefault(); begin(last.source, last.name, { topic: field.value, config: last.config }); };
    box.append(form);
  }
  box.append(el("p", { class: "actions" }, el("button", { onclick: home }, "Another log")));
  box.hidden = false;
  $("drop").hidden = true;
}

const WORDS = { check: "Reading", noise: "Noise along the log", allan: "Allan deviation at rest" };
function take(data) {
  const shown = { read: showRead, made: showMade, begin: (d) => { $("work").hidden = false; $("status").textContent = `${WORDS[d.what]} …`; $("bar").removeAttribute("value"); },
    check: showCheck, noise: showNoise, "noise-none": (d) => none("noise", d.text), allan: showAllan, "allan-none": showNoAllan, "config-none": (d) => none("config", d.text),
    failure: (d) => fail(d.text), done: (d) => { $("work").hidden = true; results.memory = d.memory; results.seconds = (performance.now() - waiting) / 1000; document.body.dataset.done = "1"; showDownloads(); } };
  shown[data.kind]?.(data);
}
function showRead({ done, total }) {
  $("bar").max = total;
  $("bar").value = done;
  $("status").textContent = `Reading, ${(done / 1e6).toFixed(done < 1e7 ? 1 : 0)} of ${(total / 1e6).toFixed(total < 1e7 ? 1 : 0)} MB`;
}
function showMade({ share }) {
  $("bar").max = 1;
  $("bar").value = share;
  $("status").textContent = `${WORDS.noise}, ${Math.round(100 * share)} %`;
}
function none(id, text) {
  const [what, hint] = text.split("\n");
  $(id).replaceChildren(el("p", {}, `${what[0].toUpperCase()}${what.slice(1)}.`), ...(hint ? [el("p", { class: "remedy" }, sentence(hint))] : []));
}
const sentence = (text) => `${text[0].toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;

function showCheck({ json, told }) {
  results.check = json;
  const check = JSON.parse(json);
  const log = JSON.parse(told);
  $("result").hidden = false;
  $("facts").textContent = `${last.name} · ${check.samples.toLocaleString("en")} samples · ${check.length_s.toFixed(1)} s at ${check.rate_hz.toFixed(1)} Hz${log.topic ? ` · ${log.topic}` : ""}`;
  const first = check.findings.find((f) => f.weight !== "note");
  $("verdict").textContent = first ? sentence(first.text) : "Nothing is wrong with this log.";
  $("verdict-remedy").textContent = first?.remedy ? sentence(first.remedy) : "";
  const row = (weight, about, text, remedy) => el("li", {}, el("span", { class: `weight ${weight}` }, weight, el("br"), el("span", { class: "quiet" }, about)), el("div", {}, el("p", {}, sentence(text)), remedy ? el("p", { class: "remedy" }, sentence(remedy)) : null));
  const rows = check.findings.map((f) => row(f.weight, f.about, f.text, f.remedy));
  if (log.guesses.length) rows.push(row("note", "guessed", `taken for granted: ${log.guesses.join(", ")}`));
  $("findings").replaceChildren(rows.length ? el("ul", { class: "findings" }, ...rows) : el("p", {}, "None."));
  $("verdict").focus({ preventScroll: true });
}

function showNoise({ json, picture }) {
  results.noise = json;
  results.firstPicture = (performance.now() - waiting) / 1000;
  const noise = JSON.parse(json);
  const drawn = JSON.parse(picture);
  const summary = noise.summary;
  const spans = summary.stretches.map((s) => ({ from: s.from_s, to: s.to_s, kind: s.phase, label: PHASES[s.phase] }));
  const out = [];
  if (drawn.note) out.push(el("p", {}, sentence(drawn.note)));
  for (const warning of noise.warnings) out.push(el("p", {}, el("span", { class: "weight warning" }, "warning "), sentence(warning)));
  out.push(el("p", { class: "quiet" }, `Standard deviation of one sample, by ${noise.noise}; along the top at rest, motors on and moving. Drag or press + to zoom, arrow keys tell values.`));
  const kinds = [...new Set(spans.map((s) => s.kind))];
  out.push(el("ul", { class: "key" }, ...kinds.map((kind) => el("li", {}, el("i", { style: `background:var(--${kind})` }), PHASES[kind])),
    summary.outside.length ? el("li", {}, el("i", { style: "background:repeating-linear-gradient(45deg,var(--bad) 0 1px,transparent 1px 4px)" }), "unlike anything the network was trained on") : null));
  ["accel", "gyro"].forEach((sensor, s) => {
    const series = AXES.map(([name, color, dash], a) => {
      const ranges = drawn.ranges[3 * s + a];
      return { name, color, dash, x: drawn.t_s, y: ranges.map(([low, high]) => (low + high) / 2), low: ranges.map((r) => r[0]), high: ranges.map((r) => r[1]) };
    });
    const marks = summary.outside.filter((o) => o.sensor === sensor).map((o) => ({ from: o.from_s, to: o.to_s }));
    if (drawn.t_s.length) out.push(plot({ title: SENSORS[sensor], label: `Noise of the ${SENSORS[sensor].toLowerCase()} over time; the table below has its quantiles. Arrow keys tell values, plus and minus zoom.`, unit: UNITS[sensor], file: `noise-${sensor}`, x: { label: "s", unit: "s" }, log: true, series, spans, marks }));
  });
  const rows = summary.phases.flatMap((p) => p.axes.map((a) => [p.phase ? PHASES[p.phase] : "whole log", `${a.sensor} ${a.axis}, ${UNITS[a.sensor]}`, a.sigma.low, a.sigma.middle, a.sigma.high]));
  out.push(el("h3", {}, "Quantiles"), table("Deviation of one sample by phase", ["when", "axis", "a twentieth below", "median", "a twentieth above"], rows, "noise-quantiles"));
  if (noise.rest) {
    const densities = noise.rest.sensors.flatMap((of) => of.axes.map((axis, a) => [of, axis, AXES[a][0]]).filter(([, axis]) => axis?.density));
    const cells = densities.map(([of, { density }, name]) => [`${of.sensor} ${name}, ${UNITS[of.sensor]}/sqrt(Hz)`, density.value, density.low, density.high]);
    if (cells.length) out.push(el("h3", {}, "At rest"), table("Density of the white noise by the spectrum, with its 95 % interval", ["axis", "density", "low", "high"], cells, "rest-densities"));
  }
  for (const { sensor, between } of noise.effective?.hidden ?? []) {
    const [low, high] = between.map(short);
    out.push(el("p", {}, el("span", { class: "weight warning" }, "warning "), `In motion the white noise of the ${SENSORS[sensor].toLowerCase()} is not known: its spectrum falls as behind a low pass, so that the density lies between ${low} and ${high} ${UNITS[sensor]}/sqrt(Hz). Ten seconds at rest in the log show the low pass.`));
  }
  $("noise").replaceChildren(...out);
  const formats = noise.effective ? [...noise.effective.pasted, ...drawn.formats] : [];
  results.moving = formats.length ? formats : null;
  showPaste();
  const check = drawn.check;
  if (check) showConfig(`${last.config?.name || "It"}, read as ${check.format}, against this log (${check.levels})`, check.findings, [check.walks_by, ...check.remarks]);
}

function showAllan({ json, more }) {
  results.allan = json;
  results.allanAt = (performance.now() - waiting) / 1000;
  const allan = JSON.parse(json);
  const shown = JSON.parse(more);
  const out = [el("p", { class: "quiet" }, `From ${allan.log.length_s.toFixed(0)} s at rest. Points with their 95 % intervals, the fitted model as a line.`)];
  for (const sensor of ["accel", "gyro"]) {
    const series = allan.log.axes.filter((a) => a.sensor === sensor).flatMap((a) => {
      const [name, color, dash] = AXES.find(([axis]) => axis === a.axis);
      const of = (key) => a.points.map((p) => p[key]);
      return [{ name, color, dash, x: of("tau"), y: of("model") }, { name: `${name} measured`, quiet: true, points: true, color, dash: "0 9", x: of("tau"), y: of("deviation"), low: of("low"), high: of("high") }];
    });
    out.push(plot({ title: SENSORS[sensor], label: `Allan deviation of the ${SENSORS[sensor].toLowerCase()}; the table below has its coefficients.`, unit: UNITS[sensor], file: `allan-${sensor}`, x: { label: "averaging time, s", unit: "s", log: true }, log: true, series }));
  }
  const rows = allan.log.axes.flatMap((a) => a.estimates.map((e) => [`${a.sensor} ${a.axis}`, e.coefficient, e.seen ? short(e.value) : "not seen", e.seen ? `${short(e.low)} to ${short(e.high)}` : `below ${short(e.high)}`]));
  out.push(el("h3", {}, "Coefficients"), table("Coefficients with 95 % intervals, SI units", ["axis", "coefficient", "value", "interval"], rows, "allan-coefficients"));
  $("allan").replaceChildren(...out);
  results.rest = { formats: [...allan.formats, ...shown.formats], advice: allan.advice };
  showPaste();
  if (shown.check.length) showConfig(`${last.config?.name || "It"}, against this log at rest`, shown.check, []);
}
function showNoAllan({ text }) {
  none("allan", text);
  showPaste();
}

let format = "kalibr";
function showPaste() {
  const source = results.rest || (results.moving && { formats: results.moving });
  if (!source) { $("paste").replaceChildren(el("p", {}, "This log neither rests long enough nor shows its noise in motion: there is nothing to paste from it.")); return; }
  const chosen = source.formats.find((f) => f.format === format) || source.formats[0];
  const names = el("p", { class: "formats" }, ...source.formats.map((f) => el("button", { "aria-pressed": String(f === chosen), onclick: () => { format = f.format; showPaste(); } }, f.format)));
  const why = results.rest ? `From the Allan deviation at rest. ${source.advice}` : "From this log in motion, vibration included: it does not rest long enough for an Allan deviation.";
  $("paste").replaceChildren(el("p", {}, why), names, ...pasted(chosen));
}
function pasted(written) {
  const copy = el("button", { class: "small", onclick: async () => { await navigator.clipboard?.writeText(written.text); copy.textContent = "copied"; } }, "copy");
  const steps = written.steps.map((s) => [s.name, s.from, s.meaning, s.result]);
  return [el("pre", { tabindex: "0", "aria-label": `Figures for ${written.format}` }, written.text), el("p", { class: "actions" }, copy, el("button", { class: "small", onclick: () => save(`${written.format}.txt`, written.text, "text/plain") }, "save")),
    steps.length ? table("The arithmetic", ["key", "from", "as", "becomes"], steps, `${written.format}-arithmetic`) : null,
    written.remarks.length ? el("ul", { class: "remarks" }, ...written.remarks.map((r) => el("li", {}, sentence(r)))) : null].filter(Boolean);
}
function showConfig(head, findings, remarks) {
  $("config").append(el("h3", {}, head), el("ul", { class: "findings" }, ...findings.map(({ weight, text }) => [weight === "note" ? "ok" : weight, text]).map(([weight, text]) => el("li", {}, el("span", { class: `weight ${weight}` }, weight), el("p", {}, sentence(text))))),
    ...(remarks.length ? [el("ul", { class: "remarks" }, ...remarks.map((r) => el("li", {}, sentence(r))))] : []));
}
function showDownloads() {
  const saver = (name) => el("button", { class: "small", onclick: () => save(`${name}.json`, results[name] + "\n", "application/json") }, `${name}.json`);
  $("downloads").replaceChildren(...["check", "noise", "allan"].filter((name) => results[name]).map(saver));
}

// What comes in: files by drop, choice, example, or from `dpn page`.
const CONFIG = /\.(ya?ml|json)$/i;
async function files(list) {
  const all = [...list];
  if (!all.length) return;
  const config = all.find((f) => CONFIG.test(f.name));
  const log = all.find((f) => f !== config);
  if (config && config.size > 4e6) return fail(`${config.name} is no configuration: it has ${(config.size / 1e6).toFixed(0)} MB.`);
  const held = config && { name: config.name, bytes: await config.arrayBuffer() };
  if (log) begin({ file: log }, log.name, { config: held });
  else if (worker && !$("result").hidden) hold(held);
  else fail(`${config.name} is a configuration.\nDrop a log beside it, or first.`);
}
function hold(config) {
  last.config = config;
  $("config").replaceChildren();
  delete document.body.dataset.done;
  waiting = performance.now();
  worker.postMessage({ config });
}
const picked = (input, use) => { input.onchange = () => { const list = [...input.files]; input.value = ""; use(list); }; };
picked($("file"), files);
picked($("config-file"), async ([file]) => { if (file) hold({ name: file.name, bytes: await file.arrayBuffer() }); });
addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("over"); });
addEventListener("dragleave", (event) => { if (!event.relatedTarget) document.body.classList.remove("over"); });
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("over");
  choose("log");
  const folder = [...(event.dataTransfer.items || [])].map((item) => item.webkitGetAsEntry?.()).find((entry) => entry?.isDirectory);
  if (folder) fail(`${folder.name} is a folder.\nDrop the file in it (data.csv of an ASL folder, the *.mcap of a rosbag2), or run \`dpn page ${folder.name}\`.`);
  else files(event.dataTransfer.files);
});
$("example").onclick = async () => begin({ file: new Blob([await unpacked("example-log")]) }, "V1_01_easy.csv");
$("cancel").onclick = home;
$("again").onclick = home;

// Tabs, by pointer and by arrow keys.
const TABS = ["log", "convert", "study"];
function choose(name) {
  for (const tab of TABS) {
    $(tab).hidden = tab !== name;
    $(`tab-${tab}`).setAttribute("aria-selected", String(tab === name));
    $(`tab-${tab}`).tabIndex = tab === name ? 0 : -1;
  }
  if (name === "convert" && !$("converted").hasChildNodes()) convert();
}
TABS.forEach((name, i) => {
  $(`tab-${name}`).onclick = () => choose(name);
  $(`tab-${name}`).onkeydown = ({ key }) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[key];
    if (!by) return;
    const next = TABS[(i + by + TABS.length) % TABS.length];
    choose(next);
    $(`tab-${next}`).focus();
  };
});

// The converter has a worker of its own, which lives as long as the page.
let converter = null;
async function convert() {
  if (!converter) {
    converter = new Worker(workerUrl);
    converter.postMessage({ module: await compiled });
    converter.onmessage = ({ data }) => {
      if (data.text) { const [what, hint] = data.text.split("\n"); $("converted").replaceChildren(el("p", { class: "weight bad" }, sentence(what)), ...(hint ? [el("p", { class: "remedy" }, sentence(hint))] : [])); return; }
      const made = JSON.parse(data.json);
      results.converted = data.json.trimEnd();
      $("converted").replaceChildren(...pasted({ format: made.to, text: made.text, steps: made.steps, remarks: made.remarks }));
    };
  }
  const form = new FormData($("converter"));
  const of = (name) => String(form.get(name) || "");
  converter.postMessage({ convert: [of("config"), "configuration", ["accel_noise", "accel_walk", "gyro_noise", "gyro_walk"].map(of), of("rate"), of("to"), of("to_rate")] });
}
$("converter").oninput = convert;
$("converter").onsubmit = (event) => event.preventDefault();

// `dpn page LOG` names the log it serves in the page's address.
const served = new URLSearchParams(location.hash.slice(1));
if (served.get("log")) begin({ url: new URL(served.get("log"), location.href).href, size: Number(served.get("size")) }, served.get("name") || "log");
