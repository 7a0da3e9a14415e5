// The study: what `dpn fleet`, `dpn eval --closed-loop` and `dpn paper` wrote, looked at from here. Medians over seeds and means over the platforms chosen are taken here; all else
// is read.
const study = { runs: new Map(), paths: new Map(), states: new Map(), tables: [], fleets: [] };
const median = (values) => {
  const sorted = [...values].sort((a, b) => a - b);
  const half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
};
/** Rows of a CSV text with quotes; lines with # before them are notes. */
function parsedCsv(text) {
  const notes = [];
  const rows = [];
  for (const line of text.split(/\r?\n/)) {
    if (line.startsWith("#")) notes.push(line.slice(1).trim());
    else if (line) rows.push([...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map((m) => (m[1] != null ? m[1].replaceAll('""', '"') : m[2])));
  }
  return { notes, head: rows[0] || [], rows: rows.slice(1) };
}
/** The folder of the run that a file is of: states and trajectories lie in folders of their own. */
function runOf(file) {
  const parts = (file.webkitRelativePath || file.name).split("/").slice(0, -1);
  if (["states", "trajectories"].includes(parts.at(-1))) parts.pop();
  return parts.slice(1).join("/") || parts[0] || "";
}
/** The name that a cell's files have: what is no letter, digit, point or hyphen is a low line. */
const stem = (sequence, noise, seed) => `${sequence}.${noise.replace(/[^A-Za-z0-9.-]/g, "_").replace(/_+$/, "")}.seed${seed}`;
async function readStudy(list) {
  Object.assign(study, { runs: new Map(), paths: new Map(), states: new Map(), tables: [], fleets: [] });
  const unread = [];
  const add = (run, rows) => study.runs.set(run, (study.runs.get(run) || []).concat(rows.filter((row) => "ate_se3" in row && row.noise)));
  for (const file of list) {
    const run = runOf(file);
    try {
      if (/\.tum$/.test(file.name)) study.paths.set(`${run}/${file.name}`, file);
      else if (/\.seed\d+\.csv$/.test(file.name)) study.states.set(`${run}/${file.name}`, file);
      else if (/^rows\.jsonl$/.test(file.name)) add(run, (await file.text()).split("\n").filter(Boolean).map((line) => JSON.parse(line)));
      else if (/\.json$/.test(file.name) && file.size < 2e8) {
        const read = JSON.parse(await file.text());
        if (Array.isArray(read.platforms) && Array.isArray(read.noises)) study.fleets.push(read);
        else if (read.study && Array.isArray(read.study.noises)) study.tables.push(summary(read.study, run));
      } else if (/\.csv$/.test(file.name) && file.size < 2e6) study.tables.push({ name: [run, file.name].filter(Boolean).join("/"), ...parsedCsv(await file.text()) });
    } catch (error) { unread.push(`${file.name}: ${error.message}`); }
  }
  const out = unread.length ? [el("p", { class: "weight bad" }, `Not read: ${unread.join("; ")}`)] : [];
  if (!study.runs.size && !study.tables.length && !study.fleets.length) out.push(el("p", {}, "Nothing of a study is in there: give fleet.json, closed_loop.json, rows.jsonl, the tables (CSV), or the folder with them."));
  out.push(...study.fleets.map(fleet));
  if (study.runs.size) out.push(cells());
  for (const t of study.tables) {
    const number = (cell) => (cell !== "" && Number.isFinite(Number(cell)) ? short(Number(cell)) : cell);
    out.push(el("h2", {}, t.notes[0] || t.name), table(t.name, t.head, t.rows.map((row) => row.map((cell, i) => (i ? number(cell) : cell))), t.name.replace(/\.csv$/, "").replaceAll("/", "-")), ...t.notes.slice(1).map((note) => el("p", { class: "quiet" }, note)));
  }
  $("study-out").replaceChildren(...out);
}
const interval = (value, ends) => (value == null ? "–" : `${short(value)}${ends ? ` (${short(ends[0])} to ${short(ends[1])})` : ""}`);
/** What `dpn eval --closed-loop` and `dpn fleet` say of each noise of a run. */
function summary(of, run) {
  const rows = of.noises.map((n) => [n.noise, interval(n.ate, n.ate_interval), n.means[1] ?? "–", n.means[2] ?? "–", n.comparison ? interval(n.comparison.ratio, n.comparison.ratio_interval) : "–", n.comparison?.p_holm ?? "–"]);
  return { name: `${run || "the run"}: every noise`, notes: [`${run || "The run"}: every noise${of.reference ? ` against ${of.reference.noise}` : ""}`], head: ["noise", "ATE [m], median over sequences (95 %)", "mean, training", "mean, test", "ratio (95 %)", "p (Holm)"], rows };
}
/** Boxes to choose names by; `draw` is called with every change. */
const boxes = (legend, names, chosen, draw) => el("fieldset", {}, el("legend", {}, legend), ...names.map((name) => {
  const box = el("input", { type: "checkbox", checked: chosen.has(name) });
  box.onchange = () => { if (box.checked) chosen.add(name); else chosen.delete(name); draw(); };
  return el("label", { class: "choice" }, box, name);
}));
/** What `dpn fleet` wrote: scores over the platforms that are chosen, beside the error on each. */
function fleet(of) {
  const [noises, platforms] = [of.noises.map((line) => line.noise), of.platforms.map((platform) => platform.name)];
  const chosen = { noises: new Set(noises), platforms: new Set(platforms) };
  const body = el("div", {});
  function draw() {
    const [columns, lines] = [noises.filter((n) => chosen.noises.has(n)), of.platforms.filter((p) => chosen.platforms.has(p.name))];
    const on = (platform, noise) => platform.noises.find((n) => n.noise === noise);
    const score = (noise) => {
      const logs = lines.map((p) => on(p, noise)?.score).map((s) => (s == null ? NaN : Math.log(s)));
      return logs.length && logs.every(Number.isFinite) ? short(Math.exp(logs.reduce((a, b) => a + b) / logs.length)) : "–";
    };
    const ratios = lines.length === platforms.length ? of.noises.filter((n) => n.comparison && chosen.noises.has(n.noise)) : [];
    body.replaceChildren(
      table("Score: error over that of each platform's best constant, geometric mean over the platforms chosen", ["over", ...columns], [[lines.length === platforms.length ? "all platforms" : lines.length === 1 ? "1 platform" : `${lines.length} platforms`, ...columns.map(score)]], "fleet-score"),
      ...(ratios.length ? [table("Against the constant that is best on the other platforms, over all sequences", ["noise", "ratio (95 %)", "better in", "p (Holm)"], ratios.map((n) => [n.noise, interval(n.comparison.ratio, n.comparison.ratio_interval), `${n.comparison.better} of ${n.comparison.sequences}`, n.comparison.p_holm ?? "–"]), "fleet-ratio")] : []),
      table("Mean absolute trajectory error [m] (over the best constant's)", ["platform", "best constant", ...columns], lines.map((p) => [p.name, `${p.best ?? "none"}${p.at_edge ? ", end of the sweep" : ""}`, ...columns.map((n) => { const cell = on(p, n); return cell?.ate == null ? "lost" : `${short(cell.ate)} (${short(cell.score)})`; })]), "fleet-platforms"),
    );
  }
  draw();
  return el("section", {}, el("h2", {}, "The fleet"), boxes("Noises told", noises, chosen.noises, draw), boxes("Platforms", platforms, chosen.platforms, draw), body);
}
/** The rows of the runs, cell by cell. */
function cells() {
  const runs = [...study.runs.keys()];
  const body = el("div", {});
  const show = (run) => body.replaceChildren(grid(run, study.runs.get(run)));
  const choice = el("select", { onchange: (event) => show(event.target.value) }, ...runs.map((run) => el("option", { value: run }, run || "rows.jsonl")));
  show(runs[0]);
  return el("section", {}, el("h2", {}, "Cell by cell"), runs.length > 1 ? el("label", { class: "choice" }, "Run ", choice) : null, body);
}
function grid(run, rows) {
  const of = (key) => [...new Set(rows.map((row) => row[key]))];
  const [noises, sequences] = [of("noise"), of("sequence")];
  const shown = { noises: new Set(noises.slice(0, 6)), sequences: new Set(sequences) };
  const [body, detail] = [el("div", {}), el("div", { "aria-live": "polite" })];
  function draw() {
    const columns = noises.filter((n) => shown.noises.has(n));
    const lines = sequences.filter((s) => shown.sequences.has(s)).map((sequence) => {
      const cellsOf = columns.map((noise) => {
        const runs = rows.filter((row) => row.sequence === sequence && row.noise === noise);
        const values = runs.map((row) => row.ate_se3).filter(Number.isFinite);
        if (!values.length) return el("td", {}, runs.length ? "failed" : "–");
        const failed = runs.length - values.length ? ` !${runs.length - values.length}` : "";
        const words = values.length > 1 ? ` (${short(Math.min(...values))} to ${short(Math.max(...values))})` : "";
        return el("td", {}, el("button", { class: "small cell", "aria-label": `${sequence}, ${noise}: ${short(median(values))} m`, onclick: () => showCell(sequence, noise, runs) }, short(median(values))), el("span", { class: "quiet" }, words + failed));
      });
      return el("tr", {}, el("th", { scope: "row" }, sequence), ...cellsOf);
    });
    const head = el("tr", {}, el("th", { scope: "col" }, "sequence"), ...columns.map((n) => el("th", { scope: "col" }, n)));
    body.replaceChildren(el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Absolute trajectory errors" }, el("table", {}, el("caption", {}, "Absolute trajectory error [m]: median over seeds (lowest to highest); ! failed runs"), el("thead", {}, head), el("tbody", {}, ...lines))));
  }
  async function showCell(sequence, noise, runs) {
    const keys = [["seed", "seed"], ["ate_se3", "ATE [m]"], ["rpe_1s", "RPE 1 s [m]"], ["nees_position", "NEES position"], ["completion", "completion"], ["restarts", "restarts"]];
    const lines = runs.map((row) => keys.map(([key]) => (row[key] == null ? "–" : row[key])));
    const out = [el("h3", {}, `${sequence}, told ${noise}`), table("Runs", keys.map((k) => k[1]), lines, `${sequence}-${noise}`)];
    const file = (files, ending) => runs.map((row) => files.get(`${run}/${stem(sequence, noise, row.seed)}.${ending}`)).find(Boolean);
    const [states, poses] = [file(study.states, "csv"), file(study.paths, "tum")];
    if (states) out.push(...timeline(await states.text()));
    else if (poses) out.push(...path(parsedPath(await poses.text())));
    else out.push(el("p", { class: "quiet" }, "This cell's trajectory was not kept, or is not among the files: choose the run's folder."));
    detail.replaceChildren(...out);
    detail.scrollIntoView({ block: "nearest" });
  }
  draw();
  return el("div", {}, boxes("Noises told", noises, shown.noises, draw), boxes("Sequences", sequences, shown.sequences, draw), body, detail);
}
/** What the estimator believed at every frame: its path, the noise in force, the biases. */
function timeline(text) {
  const [first, ...lines] = text.split("\n");
  const head = first.slice(1).split(",");
  const rows = lines.filter((line) => line && !line.startsWith("#")).map((line) => line.split(","));
  const column = (name) => head.findIndex((title) => title.startsWith(name));
  const start = Number(rows[0]?.[0] ?? 0) / 1e9;
  const kept = rows.filter((row) => row[column("p_x")] !== "");
  const poses = kept.map((row) => [Number(row[0]) / 1e9, ...["p_x", "p_y", "p_z"].map((name) => Number(row[column(name)]))]);
  const drawn = (title, prefix, unit, log) => plot({ title, label: `${title}; arrow keys tell values.`, unit, file: prefix, x: { label: "s", unit: "s" }, log,
    series: AXES.map(([name, color, dash]) => ({ name, color, dash, x: kept.map((row) => Number(row[0]) / 1e9 - start), y: kept.map((row) => Number(row[column(`${prefix}_${name}`)])) })) });
  if (kept.length < 2) return [el("p", {}, "It never had a state.")];
  return [...path(poses), drawn("Accelerometer noise in force", "accel_noise", "m/s²", true), drawn("Gyroscope noise in force", "gyro_noise", "rad/s", true), drawn("Accelerometer bias", "accel_bias", "m/s²", false), drawn("Gyroscope bias", "gyro_bias", "rad/s", false)];
}
const parsedPath = (text) => text.split("\n").filter((line) => line && !line.startsWith("#")).map((line) => line.split(/\s+/).slice(0, 4).map(Number)).filter((row) => row.every(Number.isFinite));
function path(poses) {
  if (poses.length < 2) return [el("p", {}, "Its trajectory has no poses.")];
  const [xs, ys] = [poses.map((p) => p[1]), poses.map((p) => p[2])];
  const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const size = Math.max(x1 - x0, y1 - y0, 0.1) * 1.06;
  const [cx, cy] = [(x0 + x1) / 2, (y0 + y1) / 2];
  const svg = shape("svg", { class: "plot path", viewBox: "0 0 500 500", role: "img", "aria-label": "The estimated path from above" });
  const at = ([, x, y]) => `${(250 + ((x - cx) / size) * 500).toFixed(1)},${(250 - ((y - cy) / size) * 500).toFixed(1)}`;
  svg.append(shape("polyline", { points: poses.map(at).join(" "), fill: "none", stroke: "var(--x)", "stroke-width": 1.4 }));
  const start = poses[0][0];
  const series = AXES.map(([name, color, dash], a) => ({ name, color, dash, x: poses.map((p) => p[0] - start), y: poses.map((p) => p[1 + a]) }));
  return [el("figure", {}, el("figcaption", {}, el("b", {}, `From above; the frame is ${short(size)} m wide`)), svg), plot({ title: "Position over time", label: "Position over time; arrow keys tell values.", unit: "m", file: "position", x: { label: "s", unit: "s" }, log: false, series })];
}
picked($("study-file"), readStudy);
picked($("study-folder"), readStudy);
