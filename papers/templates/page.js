// Tables sort by a click on a head (a third one brings back their order), within their groups; pictures grow where they are small.
for (const table of document.querySelectorAll("table")) {
  const groups = [...table.tBodies].map((body) => ({ body, rows: [...body.rows] }));
  const heads = [...table.tHead.rows[0].cells];
  const value = (row, i) => {
    const text = row.cells[i].textContent.trim();
    const number = Number.parseFloat(text.replace(/^</, ""));
    return heads[i].classList.contains("n") ? number : text;
  };
  const before = (a, b) => {
    if (typeof a === "string") return a.localeCompare(b, "en", { numeric: true });
    if (Number.isNaN(a) || Number.isNaN(b)) return 0;
    return a - b;
  };
  heads.forEach((head, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const next = { ascending: "descending", descending: null }[head.getAttribute("aria-sort")];
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      const order = next === undefined ? "ascending" : next;
      if (order) head.setAttribute("aria-sort", order);
      for (const { body, rows } of groups) {
        // What is no number stays below, whichever way the others go.
        const missing = (row) => Number.isNaN(value(row, i));
        const there = rows.filter((row) => !order || !missing(row));
        if (order) there.sort((a, b) => (order === "ascending" ? 1 : -1) * before(value(a, i), value(b, i)));
        body.append(...there, ...rows.filter((row) => order && missing(row)));
      }
    });
  });
}
for (const figure of document.querySelectorAll("figure.drawn")) {
  const [frame, button] = [figure.querySelector(".frame"), document.createElement("button")];
  button.type = "button";
  button.className = "larger";
  const show = (large) => {
    figure.classList.toggle("large", large);
    button.setAttribute("aria-pressed", large);
    button.textContent = "Enlarge";
    if (large) frame.tabIndex = 0; else frame.removeAttribute("tabindex");
  };
  button.addEventListener("click", () => show(!figure.classList.contains("large")));
  show(false);
  frame.after(button);
}
