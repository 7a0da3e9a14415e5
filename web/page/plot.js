"use strict";
// Line plots as SVG: zoom by dragging, wheel or keys, values under the pointer or the cursor keys, saved as SVG, PNG and CSV.

const SVG = "http://www.w3.org/2000/svg";
const el = (name, attributes = {}, ...children) => {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node[key] = value;
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child != null));
  return node;
};
const shape = (name, attributes, text) => {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text != null) node.textContent = text;
  return node;
};
/** A number for people: three digits. */
const short = (v) => {
  if (v == null || !Number.isFinite(v)) return "–";
  if (v === 0) return "0";
  const size = Math.abs(v);
  if (size >= 1e5 || size < 1e-3) return v.toExponential(2).replace("e", " e").replace(" e", "e");
  return String(Number(v.toPrecision(3)));
};
function save(name, data, type) {
  const url = URL.createObjectURL(data instanceof Blob ? data : new Blob([data], { type }));
  el("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
const csv = (rows) => rows.map((row) => row.map((cell) => (/[",\n]/.test(cell) ? `"${String(cell).replaceAll('"', '""')}"` : cell)).join(",")).join("\n") + "\n";

function ticks(from, to, log, most) {
  if (log) {
    const [a, b] = [Math.floor(Math.log10(from)), Math.ceil(Math.log10(to))];
    const steps = b - a > most ? [1] : b - a > 2 ? [1, 3] : [1, 2, 5];
    const all = [];
    for (let decade = a; decade <= b; decade++) for (const step of steps) all.push(Number(`${step}e${decade}`));
    const shown = all.filter((v) => v >= from * 0.999 && v <= to * 1.001);
    // Within a few tenths of a decade, even steps say more than one number.
    if (shown.length > 1) return shown;
  }
  const raw = (to - from) / most;
  const unit = 10 ** Math.floor(Math.log10(raw));
  const step = unit * ([1, 2, 5, 10].find((m) => m * unit >= raw) || 10);
  const all = [];
  for (let v = Math.ceil(from / step) * step; v <= to + step * 1e-9; v += step) all.push(Number(v.toPrecision(12)));
  return all;
}

/**
 * spec: title, unit, file, x {label, log, unit}, log (of y), series [{name, color, dash, x, y, low, high, points}], spans [{from, to, kind, label}] along the top,
 * marks [{from, to}] hatched. Values at an x are those of the nearest sample.
 */
function plot(spec) {
  const pad = { left: 62, right: 34, top: 16, bottom: 34 };
  const svg = shape("svg", { class: "plot", role: "img", tabindex: "0", "aria-label": spec.label });
  const readout = el("p", { class: "readout", "aria-live": "polite" });
  const buttons = el("span", {});
  const figure = el("figure", {}, el("figcaption", {}, el("b", {}, spec.title), buttons), svg, readout);
  const all = spec.series.flatMap((s) => s.x);
  const whole = [all.reduce((a, b) => Math.min(a, b), Infinity), all.reduce((a, b) => Math.max(a, b), -Infinity)];
  if (whole[0] === whole[1]) whole[1] = whole[0] + 1;
  let [from, to] = whole;
  let cursor = null;
  let dragged = null;
  let box = { width: 900, height: 300 };
  const to01 = (v, a, b, log) => (log ? Math.log(v / a) / Math.log(b / a) : (v - a) / (b - a));
  const from01 = (u, a, b, log) => (log ? a * (b / a) ** u : a + u * (b - a));
  const xOf = (v) => pad.left + to01(v, from, to, spec.x.log) * (box.width - pad.left - pad.right);
  const valueAt = (px) => from01(Math.min(1, Math.max(0, (px - pad.left) / (box.width - pad.left - pad.right))), from, to, spec.x.log);

  function range() {
    let [low, high] = [Infinity, -Infinity];
    for (const s of spec.series) for (let i = 0; i < s.x.length; i++) {
      if (s.x[i] < from || s.x[i] > to) continue;
      const [a, b] = [s.low && s.low[i] > 0 ? s.low[i] : s.y[i], s.high ? s.high[i] : s.y[i]];
      if (!(spec.log && a <= 0)) low = Math.min(low, a);
      if (Number.isFinite(b)) high = Math.max(high, b);
    }
    if (!(low < Infinity) || !(high > -Infinity)) return [0.1, 1];
    if (spec.log) { low = Math.max(low, high * 1e-9); return high / low < 1.5 ? [low / 1.3, high * 1.3] : [low / 1.12, high * 1.12]; }
    return low === high ? [low - 1, high + 1] : [low - 0.05 * (high - low), high + 0.05 * (high - low)];
  }
  function nearest(s, v) {
    let [a, b] = [0, s.x.length - 1];
    while (b - a > 1) { const m = (a + b) >> 1; if (s.x[m] < v) a = m; else b = m; }
    return Math.abs(s.x[a] - v) < Math.abs(s.x[b] - v) ? a : b;
  }
  function draw() {
    const width = Math.max(280, svg.parentNode.clientWidth || 900);
    box = { width, height: Math.round(Math.min(340, Math.max(230, width * 0.36))) };
    svg.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
    svg.replaceChildren();
    const css = getComputedStyle(document.documentElement);
    const colour = (name) => css.getPropertyValue(name).trim();
    const [low, high] = range();
    const yOf = (v) => box.height - pad.bottom - to01(v, low, high, spec.log) * (box.height - pad.bottom - pad.top);
    const id = `c${Math.random().toString(36).slice(2)}`;
    const defs = shape("defs", {});
    const clip = shape("clipPath", { id });
    clip.append(shape("rect", { x: pad.left, y: pad.top - 10, width: box.width - pad.left - pad.right, height: box.height - pad.top - pad.bottom + 10 }));
    const hatch = shape("pattern", { id: `${id}h`, width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
    hatch.append(shape("line", { x1: 0, y1: 0, x2: 0, y2: 6, stroke: colour("--bad"), "stroke-width": 1.2, "stroke-opacity": 0.35 }));
    defs.append(clip, hatch);
    svg.append(defs);
    const inside = shape("g", { "clip-path": `url(#${id})` });
    for (const span of spec.spans || []) {
      const [a, b] = [xOf(Math.max(span.from, from)), xOf(Math.min(span.to, to))];
      if (b > a) inside.append(shape("rect", { x: a, y: pad.top - 10, width: b - a, height: 7, fill: colour(`--${span.kind}`) }));
    }
    for (const mark of spec.marks || []) {
      const [a, b] = [xOf(Math.max(mark.from, from)), xOf(Math.min(mark.to, to))];
      if (b > a) inside.append(shape("rect", { x: a, y: pad.top, width: Math.max(1, b - a), height: box.height - pad.top - pad.bottom, fill: `url(#${id}h)` }));
    }
    for (const v of ticks(low, high, spec.log, 5)) {
      svg.append(shape("line", { x1: pad.left, x2: box.width - pad.right, y1: yOf(v), y2: yOf(v), stroke: colour("--line"), "stroke-width": 0.7 }));
      svg.append(shape("text", { x: pad.left - 8, y: yOf(v) + 4, "text-anchor": "end" }, short(v)));
    }
    const down = box.height - pad.bottom;
    svg.append(shape("line", { x1: pad.left, x2: box.width - pad.right, y1: down, y2: down, stroke: colour("--soft"), "stroke-width": 0.8 }));
    let free = -Infinity;
    for (const v of ticks(from, to, spec.x.log, Math.max(3, Math.floor(width / 110)))) {
      if (xOf(v) - free < 34) continue;
      free = xOf(v);
      svg.append(shape("line", { x1: xOf(v), x2: xOf(v), y1: down, y2: down + 4, stroke: colour("--soft") }), shape("text", { x: xOf(v), y: down + 17, "text-anchor": "middle" }, short(v)));
    }
    svg.append(shape("text", { x: box.width - pad.right, y: box.height - 2, "text-anchor": "end" }, spec.x.label), shape("text", { x: pad.left, y: box.height - 2 }, spec.unit));
    svg.append(inside);
    const ends = [];
    for (const s of spec.series) {
      const stroke = colour(s.color);
      const shown = [];
      for (let i = 0; i < s.x.length; i++) if ((s.x[i] >= from && s.x[i] <= to) || (s.x[i + 1] >= from && s.x[i] < from) || (s.x[i - 1] <= to && s.x[i] > to)) shown.push(i);
      // As many places as there are pixels.
      const step = Math.max(1, Math.ceil(shown.length / (width * 1.2)));
      const places = [];
      for (let k = 0; k < shown.length; k += step) {
        const part = shown.slice(k, k + step);
        const pick = (of, f) => part.reduce((m, i) => f(m, of[i]), of[part[0]]);
        places.push({ x: xOf(s.x[part[0]]), y: s.y[part[part.length >> 1]], low: s.low && pick(s.low, Math.min), high: s.high && pick(s.high, Math.max) });
      }
      const at = (v) => yOf(spec.log ? Math.max(v, low * 1e-3) : v).toFixed(1);
      if (s.low && places.length) {
        const up = places.map((p) => `${p.x.toFixed(1)},${at(p.high)}`);
        const back = places.map((p) => `${p.x.toFixed(1)},${at(p.low)}`).reverse();
        inside.append(shape("polygon", { points: [...up, ...back].join(" "), fill: stroke, "fill-opacity": 0.16 }));
      }
      const line = places.filter((p) => !(spec.log && !(p.y > 0)));
      if (line.length) {
        inside.append(shape("polyline", { points: line.map((p) => `${p.x.toFixed(1)},${at(p.y)}`).join(" "), fill: "none", stroke, "stroke-width": 1.4, "stroke-linejoin": "round", "stroke-dasharray": s.dash || "none" }));
        if (!s.quiet) ends.push({ y: Number(at(line[line.length - 1].y)), name: s.name, stroke });
      }
      if (s.points) for (const p of places) inside.append(shape("circle", { cx: p.x, cy: at(p.y), r: 1.9, fill: stroke }));
    }
    ends.sort((a, b) => a.y - b.y).forEach((end, i) => {
      if (i && end.y - ends[i - 1].y < 13) end.y = ends[i - 1].y + 13;
      const text = shape("text", { x: box.width - pad.right + 6, y: end.y + 4, style: `fill:${end.stroke}` }, end.name);
      svg.append(text);
    });
    if (dragged) svg.append(shape("rect", { x: Math.min(...dragged), y: pad.top, width: Math.abs(dragged[1] - dragged[0]), height: down - pad.top, fill: colour("--accent"), "fill-opacity": 0.12 }));
    if (cursor != null) svg.append(shape("line", { x1: xOf(cursor), x2: xOf(cursor), y1: pad.top - 10, y2: down, stroke: colour("--ink"), "stroke-width": 0.8 }));
    say();
  }
  function say() {
    if (cursor == null) { readout.textContent = spec.say || " "; return; }
    const parts = spec.series.filter((s) => !s.quiet).map((s) => {
      const i = nearest(s, cursor);
      const width = s.low && s.high[i] !== s.low[i] ? ` (${short(s.low[i])} to ${short(s.high[i])})` : "";
      return `${s.name} ${short(s.y[i])}${width}`;
    });
    const span = (spec.spans || []).find((s) => cursor >= s.from && cursor <= s.to);
    const marked = (spec.marks || []).some((m) => cursor >= m.from && cursor <= m.to);
    readout.textContent = `${short(cursor)} ${spec.x.unit}: ${parts.join(", ")} ${spec.unit}${span ? `; ${span.label}` : ""}${marked ? "; out of the trained range" : ""}`;
  }
  function zoom(a, b) {
    const least = spec.x.log ? whole[0] * 1.05 - whole[0] : (whole[1] - whole[0]) / 2000;
    [from, to] = [Math.max(whole[0], Math.min(a, b)), Math.min(whole[1], Math.max(a, b))];
    if (to - from < least) [from, to] = whole;
    draw();
  }
  const scaled = (factor) => {
    const u = cursor == null ? 0.5 : to01(cursor, from, to, spec.x.log);
    zoom(from01(u - u * factor, from, to, spec.x.log), from01(u + (1 - u) * factor, from, to, spec.x.log));
  };
  const pixel = (event) => ((event.clientX - svg.getBoundingClientRect().left) / svg.getBoundingClientRect().width) * box.width;
  svg.onpointerdown = (event) => { if (event.button === 0 && event.pointerType === "mouse") dragged = [pixel(event), pixel(event)]; };
  svg.onpointermove = (event) => { cursor = valueAt(pixel(event)); if (dragged) dragged[1] = pixel(event); draw(); };
  svg.onpointerup = () => {
    const drag = dragged;
    dragged = null;
    if (drag && Math.abs(drag[1] - drag[0]) > 6) zoom(valueAt(drag[0]), valueAt(drag[1]));
  };
  svg.onpointerleave = () => { dragged = null; cursor = null; draw(); };
  svg.ondblclick = () => zoom(...whole);
  svg.addEventListener("wheel", (event) => { if (event.ctrlKey || event.metaKey) { event.preventDefault(); scaled(event.deltaY > 0 ? 1.25 : 0.8); } }, { passive: false });
  svg.onkeydown = (event) => {
    const by = (u) => { cursor = from01(Math.min(1, Math.max(0, (cursor == null ? 0.5 : to01(cursor, from, to, spec.x.log)) + u)), from, to, spec.x.log); draw(); };
    const keys = { ArrowLeft: () => by(-0.01), ArrowRight: () => by(0.01), "+": () => scaled(0.5), "=": () => scaled(0.5), "-": () => scaled(2), 0: () => zoom(...whole), Escape: () => { cursor = null; draw(); } };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  };
  const standing = () => {
    const copy = svg.cloneNode(true);
    copy.setAttribute("xmlns", SVG);
    copy.setAttribute("width", box.width);
    copy.setAttribute("height", box.height);
    const css = getComputedStyle(document.documentElement);
    copy.prepend(shape("rect", { width: "100%", height: "100%", fill: css.getPropertyValue("--paper").trim() }));
    copy.querySelectorAll("text").forEach((text) => {
      text.setAttribute("font-family", "sans-serif");
      text.setAttribute("font-size", "12");
      if (!text.getAttribute("style")) text.setAttribute("fill", css.getPropertyValue("--soft").trim());
    });
    return new XMLSerializer().serializeToString(copy);
  };
  const png = () => {
    const image = new Image();
    image.onload = () => {
      const canvas = el("canvas", { width: box.width * 2, height: box.height * 2 });
      canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob((blob) => save(`${spec.file}.png`, blob));
    };
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(standing())}`;
  };
  const table = () => {
    const rows = [["series", spec.x.label, spec.unit, "low", "high"]];
    for (const s of spec.series) s.x.forEach((x, i) => rows.push([s.name, x, s.y[i], s.low ? s.low[i] : "", s.high ? s.high[i] : ""]));
    return csv(rows);
  };
  const saver = (kind, act) => el("button", { class: "small", "aria-label": `Save ${spec.title} as ${kind}`, onclick: act }, kind);
  const tool = (sign, act) => el("button", { class: "small", "aria-label": `${sign}: ${spec.title}`, onclick: act }, sign);
  buttons.append(
    tool("closer", () => scaled(0.5)), tool("wider", () => scaled(2)), tool("all", () => zoom(...whole)),
    saver("SVG", () => save(`${spec.file}.svg`, standing(), "image/svg+xml")), saver("PNG", png), saver("CSV", () => save(`${spec.file}.csv`, table(), "text/csv")),
  );
  new ResizeObserver(() => { if (svg.parentNode.clientWidth && svg.parentNode.clientWidth !== box.width) draw(); }).observe(figure);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  return figure;
}

/** A table that can be saved. */
function table(caption, head, rows, file) {
  const cell = (name, text, scope) => el(name, scope ? { scope } : {}, String(text));
  const button = el("button", { class: "small", "aria-label": `Save ${caption} as CSV`, onclick: () => save(`${file}.csv`, csv([head, ...rows]), "text/csv") }, "CSV");
  const body = rows.map((row) => el("tr", {}, ...row.map((text, i) => (i ? cell("td", typeof text === "number" ? short(text) : text) : cell("th", text, "row")))));
  const made = el("table", {}, el("caption", {}, caption, " ", button), el("thead", {}, el("tr", {}, ...head.map((text) => cell("th", text, "col")))), el("tbody", {}, ...body));
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, made);
}
