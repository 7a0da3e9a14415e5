// The study: what `dpn paper` wrote, row by row or table by table, looked at from here. Medians over seeds are taken here; all else is read.
const study = { rows: [], paths: new Map(), tables: [] };
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
async function readStudy(list) {
  Object.assign(study, { rows: [], paths: new Map(), tables: [] });
  const unread = [];
  for (const file of list) {
    try {
      if (/\.tum$/.test(file.name)) study.paths.set(file.name, file);
      else if (/\.jsonl$/.test(file.name)) study.rows.push(...(await file.text()).split("\n").filter(Boolean).map((line) => JSON.parse(line)).filter((row) => "ate_se3" in row && row.noise));
      else if (/\.csv$/.test(file.name) && file.size < 2e6 && !/\.seed\d+\.csv$/.test(file.name)) study.tables.push({ name: file.name, ...parsedCsv(await file.text()) });
    } catch (error) { unread.push(`${file.name}: ${error.message}`); }
  }
  const out = unread.length ? [el("p", { class: "weight bad" }, `Not read: ${unread.join("; ")}`)] : [];
  if (!study.rows.length && !study.tables.length) out.push(el("p", {}, "Nothing of a study is in there: give rows.jsonl, the tables (CSV), or the folder with both."));
  if (study.rows.length) out.push(fleet());
  for (const t of study.tables) {
    const number = (cell) => (cell !== "" && Number.isFinite(Number(cell)) ? short(Number(cell)) : cell);
    out.push(el("h3", {}, t.notes[0] || t.name), table(t.name, t.head, t.rows.map((row) => row.map((cell, i) => (i ? number(cell) : cell))), t.name.replace(/\.csv$/, "")), ...t.notes.slice(1).map((note) => el("p", { class: "quiet" }, note)));
  }
  $("study-out").replaceChildren(...out);
}
function fleet() {
  const of = (key) => [...new Set(study.rows.map((row) => row[key]))];
  const [noises, sequences] = [of("noise"), of("sequence")];
  const shown = { noises: new Set(noises.slice(0, 6)), sequences: new Set(sequences) };
  const [body, detail] = [el("div", {}), el("div", { "aria-live": "polite" })];
  const boxes = (legend, names, set) => el("fieldset", {}, el("legend", {}, legend), ...names.map((name) => {
    const box = el("input", { type: "checkbox", checked: set.has(name) });
    box.onchange = () => { if (box.checked) set.add(name); else set.delete(name); draw(); };
    return el("label", { class: "choice" }, box, name);
  }));
  function draw() {
    const columns = noises.filter((n) => shown.noises.has(n));
    const cells = sequences.filter((s) => shown.sequences.has(s)).map((sequence) => {
      const cellsOf = columns.map((noise) => {
        const runs = study.rows.filter((row) => row.sequence === sequence && row.noise === noise);
        const values = runs.map((row) => row.ate_se3).filter(Number.isFinite);
        if (!values.length) return el("td", {}, runs.length ? "failed" : "–");
        const failed = runs.length - values.length ? ` !${runs.length - values.length}` : "";
        const words = values.length > 1 ? ` (${short(Math.min(...values))} to ${short(Math.max(...values))})` : "";
        return el("td", {}, el("button", { class: "small cell", "aria-label": `${sequence}, ${noise}: ${short(median(values))} m`, onclick: () => showCell(sequence, noise, runs) }, short(median(values))), el("span", { class: "quiet" }, words + failed));
      });
      return el("tr", {}, el("th", { scope: "row" }, sequence), ...cellsOf);
    });
    const head = el("tr", {}, el("th", { scope: "col" }, "sequence"), ...columns.map((n) => el("th", { scope: "col" }, n)));
    body.replaceChildren(el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Absolute trajectory errors" }, el("table", {}, el("caption", {}, "Absolute trajectory error [m]: median over seeds (lowest to highest); ! failed runs"), el("thead", {}, head), el("tbody", {}, ...cells))));
  }
  async function showCell(sequence, noise, runs) {
    const keys = [["seed", "seed"], ["ate_se3", "ATE [m]"], ["rpe_1s", "RPE 1 s [m]"], ["nees_position", "NEES position"], ["completion", "completion"], ["restarts", "restarts"]];
    const rows = runs.map((row) => keys.map(([key]) => (row[key] == null ? "–" : row[key])));
    const out = [el("h3", {}, `${sequence}, told ${noise}`), table("Runs", keys.map((k) => k[1]), rows, `${sequence}-${noise}`)];
    const file = runs.map((row) => study.paths.get(`${sequence}.${noise}.seed${row.seed}.tum`)).find(Boolean);
    if (file) out.push(...path(parsedPath(await file.text())));
    else out.push(el("p", { class: "quiet" }, "Choose the run's folder to see this cell's trajectory."));
    detail.replaceChildren(...out);
  }
  draw();
  return el("div", {}, boxes("Noises told", noises, shown.noises), boxes("Sequences", sequences, shown.sequences), body, detail);
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
