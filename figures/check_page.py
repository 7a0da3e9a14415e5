#!/usr/bin/env python3
"""Looks at index.html in headless Chromium: no console error, no request, no overflow, every picture loads, in light and dark, wide and on a phone.

usage: check_page.py [PAGE] [--shots DIR]      PAGE: euroc/index.html beside this script

Exit code 0 where all is well, 1 with a line for every fault. With --shots, full-page screenshots are left in DIR.
needs: playwright (pip install playwright) and a Chromium: `playwright install chromium`, or one on the PATH.
"""
import argparse
import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

VIEWS = [("wide", 1280, 900), ("phone", 375, 740)]
SCHEMES = ["light", "dark"]

# What is asked of the page itself, in the page.
FAULTS = """() => {
  const faults = [];
  const root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) {
    faults.push(`the page is ${root.scrollWidth} px wide in a window of ${root.clientWidth} px`);
  }
  const scrolls = (e) => e && e !== document.body && (['auto', 'scroll'].includes(getComputedStyle(e).overflowX) || scrolls(e.parentElement));
  for (const e of document.querySelectorAll('body *')) {
    const box = e.getBoundingClientRect();
    if (box.width > 0 && box.right > root.clientWidth + 1 && !scrolls(e)) {
      faults.push(`<${e.tagName.toLowerCase()}> reaches to ${Math.round(box.right)} px: ${(e.textContent || '').trim().slice(0, 60)}`);
    }
  }
  const pictures = [...document.images];
  for (const i of pictures) {
    if (!i.complete || i.naturalWidth === 0) faults.push(`the picture "${i.alt}" does not load`);
    if (!i.alt) faults.push(`a picture without words: ${i.src.slice(0, 60)}`);
  }
  if (pictures.length === 0) faults.push('no picture on the page');
  if (document.querySelectorAll('table').length === 0) faults.push('no table on the page');
  const size = parseFloat(getComputedStyle(document.body).fontSize);
  if (size < 14) faults.push(`the text is ${size} px high`);
  const ids = new Set();
  for (const e of document.querySelectorAll('[id]')) {
    if (ids.has(e.id)) faults.push(`two elements are called ${e.id}`);
    ids.add(e.id);
  }
  for (const a of document.querySelectorAll('a[href^="#"]')) {
    if (!ids.has(a.getAttribute('href').slice(1))) faults.push(`a link leads nowhere: ${a.getAttribute('href')}`);
  }
  return faults;
}"""

# Text against the background it stands on, by WCAG's contrast.
CONTRAST = """() => {
  const parse = (c) => (c.match(/[\\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
  const behind = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c.length < 4 || c[3] > 0) return c; } return [255, 255, 255]; };
  let worst = [99, ''];
  for (const e of document.querySelectorAll('p, li, td, th, h1, h2, h3, a, summary, figcaption')) {
    const [a, b] = [light(parse(getComputedStyle(e).color)), light(behind(e))];
    const ratio = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
    if (ratio < worst[0]) worst = [ratio, e.tagName.toLowerCase()];
  }
  return worst;
}"""


def look(browser, page_file, scheme, view, shots):
    name, width, height = view
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, device_scale_factor=1, is_mobile=name == "phone"
    )
    page = context.new_page()
    faults = []
    page.on("console", lambda m: faults.append(f"console: {m.text}") if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: faults.append(f"script: {e}"))
    page.on("requestfailed", lambda r: faults.append(f"a request failed: {r.url[:80]}"))
    page.on("request", lambda r: faults.append(f"a request leaves the page: {r.url[:80]}") if r.url.startswith("http") else None)
    page.goto(page_file.resolve().as_uri(), wait_until="load")
    for folded in (True, False):
        if not folded:
            page.evaluate("() => document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        faults += page.evaluate(FAULTS)
    ratio, where = page.evaluate(CONTRAST)
    if ratio < 4.5:
        faults.append(f"text in <{where}> has a contrast of {ratio:.1f}; 4.5 is needed")
    if shots:
        shots.mkdir(parents=True, exist_ok=True)
        page.evaluate("() => document.querySelectorAll('details').forEach((d) => { d.open = false; })")
        page.screenshot(path=str(shots / f"{name}-{scheme}.png"), full_page=True)
    context.close()
    return [f"{name}, {scheme}: {fault}" for fault in dict.fromkeys(faults)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", nargs="?", type=pathlib.Path, default=pathlib.Path(__file__).with_name("euroc") / "index.html")
    parser.add_argument("--shots", type=pathlib.Path)
    args = parser.parse_args()
    if not args.page.is_file():
        sys.exit(f"{args.page} does not exist; make it with `dpn paper --out {args.page.parent}`")
    with sync_playwright() as p:
        own = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
        browser = p.chromium.launch(executable_path=own, args=["--no-sandbox"])
        faults = [f for scheme in SCHEMES for view in VIEWS for f in look(browser, args.page, scheme, view, args.shots)]
        browser.close()
    for fault in faults:
        print(fault)
    print(f"{args.page}: {len(faults)} faults in {len(SCHEMES) * len(VIEWS)} views")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
