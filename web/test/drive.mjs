// Drives the page in headless Chromium: the numbers of eight logs against `dpn --json`, hostile files, accessibility, times, pictures.
import { chromium } from "playwright-core";
import axe from "axe-core";
import { execFileSync, spawn } from "node:child_process";
import { closeSync, existsSync, mkdirSync, mkdtempSync, openSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync, writeSync } from "node:fs";
import { basename, dirname, join, resolve } from "node:path";
import { tmpdir } from "node:os";

const root = resolve(process.env.ROOT);
const dpn = resolve(process.env.DPN);
const page = resolve(process.env.PAGE, "index.html");
const out = resolve(process.env.OUT);
mkdirSync(out, { recursive: true });
const only = process.argv.slice(2);
const wants = (name) => !only.length || only.includes(name);

const LOGS = [
  "tests/data/euroc/V1_01_easy/mav0/imu0/data.csv", "tests/data/tumvi/dataset-room1_512_16/mav0/imu0/data.csv", "golden/logs/px4.ulg", "golden/logs/ardupilot.bin",
  "golden/bags/lz4.bag", "golden/bags/zstd.mcap", "golden/logs/packed.csv.xz", "golden/logs/xsens.csv",
];
// Recordings that not everybody has: longer, one of them at rest.
LOGS.push(...["data/euroc/V1_01_easy/mav0/imu0/data.csv", "data/static/adis16405_imu1.csv"].filter((log) => existsSync(join(root, log))));
/** How far two numbers may be apart: a browser has other vector widths than a processor, which a network's sums of 32-bit numbers show, and another sine and exponential, which networks that answer a logarithm pass on. */
const TOLERANCE = { networks: 3e-6, else: 1e-11 };
let faults = 0;
const say = (ok, text) => { faults += ok ? 0 : 1; console.log(`${ok ? "ok  " : "FAIL"} ${text}`); };

const context = await chromium.launchPersistentContext(mkdtempSync(join(tmpdir(), "dpn-page-")), {
  executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
const tab = context.pages()[0] || (await context.newPage());
const errors = [];
tab.on("pageerror", (error) => errors.push(error.message));
tab.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });

async function open(size = [1400, 1000], scheme = "light") {
  await tab.setViewportSize({ width: size[0], height: size[1] });
  await tab.emulateMedia({ colorScheme: scheme });
  await tab.goto(`file://${page}`);
}
/** Drops files; returns what came back. */
async function drop(files) {
  await tab.evaluate(() => { delete document.body.dataset.done; });
  await tab.setInputFiles("#file", files);
  await tab.waitForFunction(() => document.body.dataset.done || !document.getElementById("failure").hidden, null, { timeout: 600_000 });
  return tab.evaluate(() => ({ ...window.dpnResults, failure: document.getElementById("failure").hidden ? null : document.getElementById("failure").innerText }));
}
function told(args, cwd) {
  try {
    return { text: execFileSync(dpn, [...args, "--json", "--out", join(tmpdir(), "dpn-page-out")], { cwd, maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }).toString().trimEnd() };
  } catch (error) {
    return { code: error.status };
  }
}
/** Where two answers differ: numbers with their relative distance, all else as a fault. */
function compare(a, b, at = "", found = { numbers: 0, same: 0, worst: 0, where: "", other: [] }) {
  if (typeof a === "number" && typeof b === "number") {
    found.numbers++;
    const distance = a === b ? 0 : Math.abs(a - b) / Math.max(Math.abs(a), Math.abs(b));
    if (distance === 0) found.same++;
    if (distance > found.worst) [found.worst, found.where] = [distance, at];
  } else if (a && b && typeof a === "object" && typeof b === "object") {
    for (const key of new Set([...Object.keys(a), ...Object.keys(b)])) compare(a[key], b[key], `${at}/${key}`, found);
  } else if (a !== b) found.other.push(`${at}: ${JSON.stringify(a)} | ${JSON.stringify(b)}`);
  return found;
}

if (wants("numbers")) {
  const total = { numbers: 0, same: 0, worst: 0 };
  for (const log of LOGS) {
    const [path, name, cwd] = [join(root, log), basename(log), resolve(root, log, "..")];
    await open();
    const got = await drop([path]);
    for (const what of ["check", "noise", "allan"]) {
      const expected = told([what, name], cwd);
      if (!expected.text || !got[what]) { say(!expected.text === !got[what], `${log} ${what}: ${got[what] ? "an answer" : "none"} in the page, ${expected.text ? "an answer" : `exit ${expected.code}`} from the command`); continue; }
      const most = JSON.parse(expected.text).noise?.startsWith("dualpronet") ? TOLERANCE.networks : TOLERANCE.else;
      const found = compare(JSON.parse(got[what]), JSON.parse(expected.text));
      total.numbers += found.numbers; total.same += found.same; total.worst = Math.max(total.worst, found.worst);
      const bytes = got[what] === expected.text;
      say(bytes || (found.other.length === 0 && found.worst <= most), `${log} ${what}: ${bytes ? "the same bytes" : `${found.same} of ${found.numbers} numbers the same, farthest ${found.worst.toExponential(1)} at ${found.where} ${found.other.slice(0, 3).join("; ")}`}`);
    }
  }
  console.log(`     ${total.same} of ${total.numbers} numbers the same to the last digit; farthest ${total.worst.toExponential(1)}`);
}

if (wants("hostile")) {
  const dir = mkdtempSync(join(tmpdir(), "dpn-hostile-"));
  const made = (name, bytes) => { const path = join(dir, name); writeFileSync(path, bytes); return path; };
  const whole = (name) => readFileSync(join(root, name));
  const files = [
    made("empty.csv", ""), made("zeros.bin", Buffer.alloc(1 << 20)), made("noise.bag", Buffer.from(Array.from({ length: 65536 }, (_, i) => (i * 7919 + (i >> 3) * 104729) & 255))),
    made("magic.bag", "#ROSBAG V2.0\n"), made("magic.db3", "SQLite format 3\0"), made("half.gz", Buffer.from([0x1f, 0x8b, 8, 0, 0])), made("words.csv", "a,b,c\nthis is,no,log\n"),
    made("nan.csv", "#timestamp [ns],x,y,z,a,b,c\n" + "1,nan,nan,nan,nan,nan,nan\n".repeat(500)), made("one.csv", "0,1,2,3,4,5,6\n"), made("script.csv", "<script>document.title='x'</script>,1,2,3,4,5,6\n".repeat(9)),
    made("cut.mcap", whole("golden/bags/zstd.mcap").subarray(0, 200)), made("cut.ulg", whole("golden/logs/px4.ulg").subarray(0, 64)),
    join(root, "golden/bags/no_imu.bag"), join(root, "golden/bags/two_imus.bag"), join(root, "golden/bags/sqlite/sqlite.db3"), join(root, "golden/bags/json.mcap"),
  ];
  for (const path of files) {
    await open();
    const got = await drop([path]);
    const sentence = got.failure || got.check;
    const live = await tab.evaluate(() => { document.getElementById("tab-convert").click(); return !document.getElementById("convert").hidden; });
    say(Boolean(sentence) && live, `${basename(path)}: ${(got.failure || "findings").split("\n")[0].slice(0, 150)}`);
  }
  say(errors.length === 0, `no error in the console ${errors.slice(0, 3).join(" | ")}`);
}

// A log of more rows than a page can hold; by name alone, for it is more than a gigabyte.
if (only.includes("large")) {
  const path = join(mkdtempSync(join(tmpdir(), "dpn-large-")), "large.csv");
  const row = (i) => `${1_400_000_000n + BigInt(i) / 200n}${String((i % 200) * 5_000_000).padStart(9, "0")},0.00${i % 7},-0.00${i % 5},0.00${i % 11},0.0${i % 13},-0.0${i % 17},9.8${i % 9}\n`;
  const file = openSync(path, "w");
  for (let i = 0; i < 26_000_000; i += 65_536) writeSync(file, Array.from({ length: 65_536 }, (_, k) => row(i + k)).join(""));
  closeSync(file);
  await open();
  const got = await drop([path]);
  say(/does not fit[^]*dpn page/.test(got.failure || ""), `${(statSync(path).size / 1e9).toFixed(1)} GB: ${(got.failure || "findings").replace(/\n/g, " ").slice(0, 200)}`);
  rmSync(path);
  await drop([join(root, LOGS[0])]);
  say(await tab.evaluate(() => Boolean(window.dpnResults.check)), "the next log is read");
}

async function accessible(what) {
  const found = await tab.evaluate(async (source) => { (0, eval)(source); return (await window.axe.run(document, { resultTypes: ["violations"] })).violations.map((v) => `${v.id}: ${v.nodes.length} x ${v.nodes[0].target} ${v.nodes[0].failureSummary?.slice(0, 160)}`); }, axe.source);
  say(found.length === 0, `axe, ${what}: ${found.length ? found.join("\n       ") : "no violation"}`);
}
const euroc = join(root, "data/euroc/V1_01_easy/mav0/imu0/data.csv");
const static_ = join(root, "data/static/adis16405_imu1.csv");
const there = (path) => { try { return statSync(path).size; } catch { return 0; } };
const long = there(euroc) ? euroc : join(root, LOGS[0]);
const rest = there(static_) ? static_ : null;

if (wants("axe")) {
  const config = join(mkdtempSync(join(tmpdir(), "dpn-config-")), "vins.yaml");
  writeFileSync(config, "%YAML:1.0\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\n");
  for (const scheme of ["light", "dark"]) {
    await open([1400, 1000], scheme);
    await accessible(`start, ${scheme}`);
    const got = await drop([long, config]);
    say(!got.failure && (await tab.evaluate(() => document.getElementById("config").textContent.length > 40)), `a configuration beside the log is held against it, ${scheme}`);
    await accessible(`result, ${scheme}`);
    await tab.click("#tab-convert");
    await tab.waitForFunction(() => document.getElementById("converted").textContent.length > 20);
    await accessible(`units, ${scheme}`);
    await tab.click("#tab-study");
    await accessible(`study, ${scheme}`);
  }
  await open();
  await drop([join(root, "golden/bags/no_imu.bag")]);
  await accessible("failure");
}

// The page of `dpn report`: from a file, on a screen, a telephone and paper, without network.
if (wants("report")) {
  const dir = mkdtempSync(join(tmpdir(), "dpn-report-"));
  for (const [name, logs] of [["one", [long]], ["several", [LOGS[0], LOGS[1], "golden/logs/betaflight.bbl"]]]) {
    const file = join(dir, `${name}.html`);
    execFileSync(dpn, ["report", ...logs, "--out", file], { cwd: root, stdio: "ignore" });
    say(statSync(file).size < 2e6, `report of ${name}: ${(statSync(file).size / 1e6).toFixed(1)} MB`);
    const asked = [];
    const listen = (request) => { if (!request.url().startsWith("file:") && !request.url().startsWith("data:")) asked.push(request.url()); };
    tab.on("request", listen);
    for (const scheme of ["light", "dark"]) for (const width of [1400, 390]) {
      await tab.setViewportSize({ width, height: 900 });
      await tab.emulateMedia({ colorScheme: scheme });
      await tab.goto(`file://${file}`);
      await accessible(`report of ${name}, ${width} px, ${scheme}`);
      const [wide, pictures] = await tab.evaluate(() => [document.documentElement.scrollWidth > innerWidth, document.querySelectorAll("svg, img").length]);
      say(!wide && pictures > 0, `report of ${name}: nothing is wider than the page at ${width} px, ${scheme}; ${pictures} pictures`);
      await tab.screenshot({ path: join(out, `report-${name}-${width}-${scheme}.png`), fullPage: true });
    }
    await tab.emulateMedia({ media: "print", colorScheme: "dark" });
    const ink = await tab.evaluate(() => getComputedStyle(document.body).backgroundColor);
    say(["rgba(0, 0, 0, 0)", "rgb(255, 255, 255)"].includes(ink), `report of ${name}: white on paper whatever the screen's colours are (${ink})`);
    writeFileSync(join(out, `report-${name}.pdf`), await tab.pdf({ format: "A4" }));
    await tab.emulateMedia({ media: "screen" });
    tab.off("request", listen);
    say(asked.length === 0, `report of ${name}: nothing is fetched${asked.length ? `, but ${asked[0]}` : ""}`);
  }
}

if (wants("times")) {
  const more = (process.env.MORE || "").split(":").filter(Boolean);
  for (const path of [long, rest, ...more].filter(Boolean)) {
    await open();
    const got = await drop([path]);
    const [memory, size] = [got.memory + (await tab.evaluate(() => performance.memory?.usedJSHeapSize ?? 0)), statSync(path).size];
    console.log(`     ${basename(path)} of ${(statSync(path).size / 1e6).toFixed(1)} MB: first picture ${got.firstPicture?.toFixed(2)} s, Allan ${got.allanAt?.toFixed(2) ?? "none"} s, all ${got.seconds?.toFixed(2)} s; memory of the worker and of the page's heap ${(memory / 1e6).toFixed(0)} MB, ${(memory / size).toFixed(1)} times the log`);
  }
}

if (wants("pictures")) {
  for (const scheme of ["light", "dark"]) for (const width of [1400, 800, 390]) {
    await open([width, 900], scheme);
    if (scheme === "light") await tab.screenshot({ path: join(out, `start-${width}.png`) });
    await drop([long]);
    await tab.evaluate(() => scrollTo(0, 0));
    await tab.screenshot({ path: join(out, `log-${width}-${scheme}.png`), fullPage: true });
    const wide = await tab.evaluate(() => document.documentElement.scrollWidth > innerWidth);
    say(!wide, `nothing is wider than the page at ${width} px, ${scheme}`);
  }
  if (rest) {
    await open([1400, 900]);
    await drop([rest]);
    await tab.screenshot({ path: join(out, "rest-1400.png"), fullPage: true });
  }
  await open([1400, 900]);
  await tab.click("#tab-convert");
  await tab.waitForFunction(() => document.getElementById("converted").textContent.length > 20);
  await tab.screenshot({ path: join(out, "units-1400.png"), fullPage: true });
}

if (wants("study")) {
  const work = mkdtempSync(join(tmpdir(), "dpn-study-"));
  const plan = join(work, "fleet.toml");
  const flight = (name, folder, sequence, more = "") => `[[platform]]\nname = "${name}"\nfolder = "${folder}"\n[platform.run]\nsequences = "${sequence}"\nfrom = 70.0\nto = 80.0\nseeds = 2\n${more}`;
  writeFileSync(plan, `constants = ["x1", "x4"]\nnoises = ["self", "mean(diff2)"]\n${flight("spiral", "spiral", "room-spiral", "trajectories = true\n")}${flight("room", "room", "room-medium")}`);
  execFileSync(dpn, ["fleet", plan, "--data", work, "--out", join(work, "fleet")], { stdio: "ignore" });
  execFileSync(dpn, ["run", "room-spiral", "--from", "70", "--to", "80", "--noise", "x4", "--out", join(work, "run")], { stdio: "ignore" });
  mkdirSync(join(work, "fleet/spiral/states"));
  const cell = readFileSync(join(work, "fleet/spiral/rows.jsonl"), "utf8").split("\n").filter(Boolean).map((line) => JSON.parse(line)).find((row) => row.noise === "x4");
  writeFileSync(join(work, `fleet/spiral/states/${cell.sequence}.x4.seed0.csv`), readFileSync(join(work, "run/states.csv")));
  const score = JSON.parse(readFileSync(join(work, "fleet/fleet.json"), "utf8"));
  for (const scheme of ["light", "dark"]) {
    await open([1400, 1000], scheme);
    await tab.click("#tab-study");
    await tab.setInputFiles("#study-folder", join(work, "fleet"));
    await tab.waitForSelector("#study-out table");
    const text = () => tab.evaluate(() => document.getElementById("study-out").innerText);
    const shown = async (words) => (await text()).includes(words);
    const three = (v) => String(Number(v.toPrecision(3)));
    say(await shown(three(score.noises.find((n) => n.noise === "self").score)), `the study: the fleet's score of self, ${scheme}`);
    // One platform alone: its own score.
    await tab.click("#study-out fieldset:has(legend:text('Platforms')) label:has-text('room')");
    say(await shown(three(score.platforms[0].noises.find((n) => n.noise === "self").score)), "the study: platforms are chosen");
    await tab.locator("#study-out button.cell", { hasText: /./ }).nth(1).click();
    await tab.waitForSelector("#study-out svg.path");
    say((await tab.locator("#study-out svg.plot").count()) === 6, "the study: a cell's path, position, noise in force and biases");
    await tab.locator("#study-out button[aria-label*='mean(diff2)']").first().click();
    await tab.waitForFunction(() => document.querySelectorAll("#study-out svg.plot").length === 2);
    say(true, "the study: a cell without states has its trajectory");
    await tab.selectOption("#study-out select", "room");
    await tab.locator("#study-out button.cell").first().click();
    await tab.waitForFunction(() => document.getElementById("study-out").innerText.includes("was not kept"));
    say(true, "the study: a cell of another run without files says so");
    await accessible(`study with data, ${scheme}`);
    for (const width of [1400, 390]) {
      await tab.setViewportSize({ width, height: 900 });
      await tab.screenshot({ path: join(out, `study-${width}-${scheme}.png`), fullPage: true });
      say(!(await tab.evaluate(() => document.documentElement.scrollWidth > innerWidth)), `the study is not wider than the page at ${width} px`);
    }
  }
}

if (wants("use")) {
  await open();
  const saved = async (selector) => {
    const [file] = await Promise.all([tab.waitForEvent("download"), tab.locator(selector).first().click()]);
    return { name: file.suggestedFilename(), text: readFileSync(await file.path(), "latin1") };
  };
  await tab.click("#example");
  await tab.waitForFunction(() => document.body.dataset.done);
  say(await tab.evaluate(() => Boolean(window.dpnResults.check) && !document.getElementById("result").hidden), "the example has findings");
  const plot = tab.locator("#noise svg.plot").first();
  const readout = () => tab.locator("#noise .readout").first().innerText();
  await plot.hover({ position: { x: 300, y: 60 } });
  const pointed = await readout();
  say(/\d s: .*m\/s/.test(pointed), `the pointer tells values: ${pointed.slice(0, 80)}`);
  await plot.focus();
  await tab.keyboard.press("ArrowRight");
  await tab.keyboard.press("ArrowRight");
  const keyed = await readout();
  say(/\d s: /.test(keyed) && keyed !== pointed, `the arrow keys tell values: ${keyed.slice(0, 60)}`);
  const axis = () => plot.evaluate((svg) => [...svg.querySelectorAll("text")].map((t) => t.textContent).join(" "));
  const whole = await axis();
  const box = await plot.boundingBox();
  await tab.mouse.move(box.x + 0.3 * box.width, box.y + 60);
  await tab.mouse.down();
  await tab.mouse.move(box.x + 0.6 * box.width, box.y + 60, { steps: 5 });
  await tab.mouse.up();
  const part = await axis();
  say(part !== whole, "dragging zooms");
  await plot.focus();
  await tab.keyboard.press("Escape");
  const back = await axis();
  await tab.keyboard.press("0");
  say(back === whole || (await axis()) === whole, "a key shows all again");
  const [svg, png, text] = [await saved("#noise button:text-is('SVG')"), await saved("#noise button:text-is('PNG')"), await saved("#noise button:text-is('CSV')")];
  say(svg.text.includes("<svg") && svg.name.endsWith(".svg"), `a plot is saved as ${svg.name}`);
  say(png.text.slice(1, 4) === "PNG", `a plot is saved as ${png.name}`);
  say(text.text.split("\n").length > 10, `a plot is saved as ${text.name}`);
  // A drop, as people do it.
  await open();
  const bytes = readFileSync(join(root, "golden/logs/px4.ulg")).toString("base64");
  await tab.evaluate((bytes) => {
    const data = new DataTransfer();
    data.items.add(new File([Uint8Array.from(atob(bytes), (letter) => letter.charCodeAt(0))], "px4.ulg"));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, bytes);
  await tab.waitForFunction(() => document.body.dataset.done);
  say(await tab.evaluate(() => Boolean(window.dpnResults.check)), "a dropped log has findings");
  // Cancelling long work brings the start back.
  await open();
  await tab.setInputFiles("#file", long);
  await tab.waitForSelector("#work:not([hidden])");
  await tab.click("#cancel");
  say(await tab.evaluate(() => !document.getElementById("drop").hidden && document.getElementById("work").hidden), "cancelling brings the start back");
}

if (wants("serve")) {
  for (const [log, what] of [["golden/bags/sqlite/sqlite.db3", "a rosbag2 database"], ["golden/logs/realsense_ros2", "a rosbag2 folder"], ["golden/logs/phyphox", "a folder of CSV"]]) {
    const server = spawn(dpn, ["page", join(root, log), "--web", resolve(process.env.PAGE)], { stdio: ["ignore", "pipe", "inherit"] });
    const url = await new Promise((done) => { let text = ""; server.stdout.on("data", (part) => { text += part; const found = /http:\S+/.exec(text); if (found) done(found[0]); }); });
    const status = async (path, headers) => (await fetch(new URL(path, url), { headers })).status;
    say((await status("/")) === 404 && (await status("/etc/passwd")) === 404 && (await status("log")) === 416 && (await status("other")) === 404, `dpn page of ${what} serves the page and the log, and nothing else`);
    await tab.goto(url);
    await tab.waitForFunction(() => document.body.dataset.done || !document.getElementById("failure").hidden, null, { timeout: 60_000 });
    say(await tab.evaluate(() => Boolean(window.dpnResults.check)), `dpn page of ${what} has findings ${await tab.evaluate(() => document.getElementById("failure").innerText)}`);
    server.kill();
  }
}

if (wants("forms")) {
  // A configuration after the log, in both shapes of the answer; the converter; progress.
  const config = join(mkdtempSync(join(tmpdir(), "dpn-config-")), "vins.yaml");
  writeFileSync(config, "%YAML:1.0\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\n");
  await open();
  await tab.evaluate(() => { window.dpnShares = []; new MutationObserver(() => window.dpnShares.push(document.getElementById("status").textContent)).observe(document.getElementById("status"), { childList: true, characterData: true, subtree: true }); });
  await drop([long]);
  const shares = await tab.evaluate(() => window.dpnShares.map((text) => /Noise along the log, (\d+) %/.exec(text)?.[1]).filter(Boolean).map(Number));
  say(shares.length > 1 && shares.every((share) => share > 0 && share <= 100), `the share of the noise that is made is told: ${shares.slice(0, 5).join(", ")} %`);
  for (const [format, words] of [["okvis2", "sigma_g_c"], ["ros", "covariance"], ["kalibr", "gyroscope_noise_density"]]) {
    await tab.locator("#paste .formats button", { hasText: new RegExp(`^${format}$`) }).click();
    say((await tab.locator("#paste pre").innerText()).includes(words), `figures to paste of a log in motion: ${format}`);
  }
  await tab.evaluate(() => { delete document.body.dataset.done; });
  await tab.setInputFiles("#config-file", config);
  await tab.waitForFunction(() => document.body.dataset.done);
  const answer = told(["noise", long, "--check", config], dirname(long));
  const expected = answer.text ? JSON.parse(answer.text).check : undefined;
  const shown = await tab.evaluate(() => JSON.parse(window.dpnResults.noise).check);
  const found = compare(shown, expected);
  say(Boolean(expected) && found.other.length === 0 && found.worst <= TOLERANCE.networks, `a configuration after the log: as \`dpn noise --check\` ${found.other.slice(0, 3).join("; ")}`);
  say((await tab.locator("#config .findings li").count()) > 0, "a configuration after the log is held against it");

  await tab.click("#tab-convert");
  const converted = (words) => tab.waitForFunction((words) => document.getElementById("converted").innerText.includes(words), words).then(() => true, () => false);
  await tab.fill("input[name=accel_noise]", "0.2 mg/sqrt(Hz)");
  await tab.selectOption("select[name=to]", "openvins");
  say(await converted("0.0019613"), "the converter: 0.2 mg/sqrt(Hz) is 0.0019613 m/s^2/sqrt(Hz)");
  await tab.fill("input[name=accel_noise]", "0.2 furlongs");
  say(await converted("furlongs"), "the converter: a unit that is none is told by name");
  await tab.fill("input[name=accel_noise]", "");
  await tab.fill("input[name=gyro_noise]", "");
  await tab.fill("textarea[name=config]", readFileSync(config, "utf8"));
  await tab.selectOption("select[name=to]", "vins");
  say(await converted("0.08"), "the converter takes a configuration");
}
await context.close();
console.log(faults ? `${faults} fault(s)` : "all well");
process.exit(faults ? 1 : 0);
