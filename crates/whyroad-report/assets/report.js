"use strict";
(() => {
  const root = document.documentElement;
  const form = document.querySelector(".filter");
  const cards = [...document.querySelectorAll(".card")];

  const language = (lang) => {
    root.lang = lang;
    for (const o of document.querySelectorAll("option[data-zh]")) {
      o.textContent = `${lang === "zh" ? o.dataset.zh : o.dataset.en} (${o.dataset.n})`;
    }
  };
  for (const b of document.querySelectorAll("button[data-lang]")) {
    b.addEventListener("click", () => language(b.dataset.lang));
  }
  // `#zh` and `#en` in the address choose the language, so that a link can.
  const wanted = location.hash.slice(1);
  language(wanted === "zh" || wanted === "en" ? wanted : root.lang);

  const filter = () => {
    const leaf = form.leaf.value, drive = form.drive.value, primary = form.primary.checked;
    let shown = 0;
    for (const c of cards) {
      const ok = (!leaf || c.dataset.leaf === leaf) && (!drive || c.dataset.drive === drive) && (!primary || c.dataset.primary === "1");
      c.hidden = !ok;
      shown += ok ? 1 : 0;
    }
    form.querySelector(".shown").textContent = shown;
  };
  if (form) {
    form.addEventListener("change", filter);
    form.addEventListener("submit", (e) => e.preventDefault());
  }

  const detail = document.getElementById("detail");
  const show = (cell) => {
    const row = document.getElementById(`leaf-${cell.dataset.leaf}`);
    if (!row) return;
    const copy = document.createDocumentFragment();
    for (const cells = row.cells, order = [0, 2, 6], i = { n: 0 }; i.n < order.length; i.n++) {
      const part = document.createElement(i.n === 0 ? "div" : "span");
      part.append(...[...cells[order[i.n]].childNodes].map((n) => n.cloneNode(true)));
      copy.append(part, " ");
    }
    detail.classList.remove("faint");
    detail.replaceChildren(copy);
  };
  for (const cell of document.querySelectorAll(".tm-leaf")) {
    cell.addEventListener("mouseenter", () => show(cell));
    cell.addEventListener("focus", () => show(cell));
    cell.addEventListener("click", (e) => {
      const leaf = cell.dataset.leaf;
      for (const c of document.querySelectorAll(".chosen")) c.classList.remove("chosen");
      cell.classList.add("chosen");
      document.getElementById(`leaf-${leaf}`)?.classList.add("chosen");
      if (form && [...form.leaf.options].some((o) => o.value === leaf)) {
        // A leaf with episodes leads to them; any other to its line in the table.
        e.preventDefault();
        form.leaf.value = leaf;
        filter();
        document.getElementById("episodes").scrollIntoView();
      }
    });
  }
})();
