// Looks at the page of `dpn paper` in headless Chromium: errors, requests, overflow, small letters, pictures, links, axe-core; sorting by mouse and keyboard;
// all of it wide, narrower and on a phone, light and dark, folded and unfolded, and once without script.
import { chromium } from "playwright-core";
import axe from "axe-core";
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";

const page = resolve(process.env.PAGE);
const shots = process.env.SHOTS ? resolve(process.env.SHOTS) : null;
if (shots) mkdirSync(shots, { recursive: true });
const faults = [];

/** What is asked of the page itself, in the page. */
function looked() {
  const found = [];
  const root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) found.push(`the page is ${root.scrollWidth} px wide in a window of ${root.clientWidth} px`);
  const scrolls = (e) => e && e !== document.body && (["auto", "scroll"].includes(getComputedStyle(e).overflowX) || scrolls(e.parentElement));
  for (const e of document.querySelectorAll("body *")) {
    const box = e.getBoundingClientRect();
    if (box.width > 0 && box.right > root.clientWidth + 1 && !scrolls(e)) found.push(`<${e.tagName.toLowerCase()}> reaches to ${Math.round(box.right)} px: ${(e.textContent || "").trim().slice(0, 60)}`);
    const words = [...e.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
    const size = parseFloat(getComputedStyle(e).fontSize);
    if (words && box.width > 0 && size < 11) found.push(`<${e.tagName.toLowerCase()}> has letters of ${size} px: ${e.textContent.trim().slice(0, 60)}`);
  }
  for (const image of document.images) {
    if (!image.complete || image.naturalWidth === 0) found.push(`the picture "${image.alt}" does not load`);
    if (image.getBoundingClientRect().width > root.clientWidth) found.push(`the picture "${image.alt}" does not scale`);
  }
  if (document.images.length === 0 || document.querySelectorAll("table").length === 0) found.push("no picture, or no table");
  // What a table concludes stands in its first three columns.
  for (const table of document.querySelectorAll("table")) {
    const right = table.tHead?.rows[0].cells[2].getBoundingClientRect().right ?? 0;
    if (right > root.clientWidth) found.push(`the third column of ${table.id} ends at ${Math.round(right)} px`);
  }
  const ids = [...document.querySelectorAll("[id]")].map((e) => e.id);
  if (new Set(ids).size < ids.length) found.push("two elements share an id");
  for (const a of document.querySelectorAll('a[href^="#"]')) if (!ids.includes(a.getAttribute("href").slice(1))) found.push(`a link leads nowhere: ${a.getAttribute("href")}`);
  // Letters of a strip's columns cover no others.
  for (const row of document.querySelectorAll(".forest li")) {
    const boxes = [...row.querySelectorAll(".name, .ratio, .better, .scale i")].map((e) => e.getBoundingClientRect()).filter((box) => box.width > 0);
    for (const [i, a] of boxes.entries()) for (const b of boxes.slice(i + 1)) if (a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1) found.push(`words cover each other: ${row.textContent}`);
  }
  return found;
}

async function sorts(tab) {
  const [head, column] = [tab.locator("#table-study th").nth(2), () => tab.evaluate(() => [...document.querySelectorAll("#table-study td:nth-child(3)")].map((td) => td.textContent))];
  const before = await column();
  const numbers = (all) => all.map(Number.parseFloat).filter((n) => !Number.isNaN(n));
  await head.locator("button").click();
  const up = numbers(await column());
  const found = [];
  if ((await head.getAttribute("aria-sort")) !== "ascending" || up.some((n, i) => i && n < up[i - 1])) found.push("a click does not sort a table");
  await head.locator("button").press("Enter");
  const down = numbers(await column());
  if ((await head.getAttribute("aria-sort")) !== "descending" || down.some((n, i) => i && n > down[i - 1])) found.push("the keyboard does not sort a table");
  await head.locator("button").press("Space");
  if ((await head.getAttribute("aria-sort")) !== null || String(await column()) !== String(before)) found.push("a third press does not bring the order back");
  return found;
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM || "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
let views = 0;
for (const scheme of ["light", "dark"]) for (const width of [1400, 800, 390]) {
  views++;
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme: scheme, isMobile: width === 390, deviceScaleFactor: width === 390 ? 2 : 1 });
  const tab = await context.newPage();
  const say = (text) => faults.push(`${width} px, ${scheme}: ${text}`);
  tab.on("console", (message) => { if (["error", "warning"].includes(message.type())) say(`console: ${message.text()}`); });
  tab.on("pageerror", (error) => say(`script: ${error.message}`));
  tab.on("request", (request) => { if (request.url().startsWith("http")) say(`a request leaves the page: ${request.url().slice(0, 80)}`); });
  await tab.goto(`file://${page}`);
  if (shots) await tab.screenshot({ path: join(shots, `${width}-${scheme}.png`), fullPage: true });
  for (const found of await tab.evaluate(looked)) say(found);
  await tab.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
  for (const found of await tab.evaluate(looked)) say(`unfolded: ${found}`);
  const violations = await tab.evaluate(async (source) => { (0, eval)(source); return (await window.axe.run(document, { resultTypes: ["violations"] })).violations.map((v) => `axe ${v.id}: ${v.nodes.length} x ${v.nodes[0].target} ${v.nodes[0].failureSummary?.slice(0, 160)}`); }, axe.source);
  violations.forEach(say);
  (await sorts(tab)).forEach(say);
  await context.close();
}
const context = await browser.newContext({ javaScriptEnabled: false });
const tab = await context.newPage();
await tab.goto(`file://${page}`);
if ((await tab.locator("th button, .larger").count()) !== 0 || !(await tab.locator("#table-study").isVisible())) faults.push("without script: buttons that do nothing, or no table");
await browser.close();
faults.forEach((fault) => console.log(fault));
console.log(`${page}: ${faults.length} fault(s) in ${views} views`);
process.exit(faults.length ? 1 : 0);
