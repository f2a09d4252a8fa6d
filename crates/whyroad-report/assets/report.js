"use strict";
(() => {
  const form = document.querySelector(".filter");
  const cards = [...document.querySelectorAll(".card")];

  // A few cards a page: all of them would be tens of thousands of pixels.
  const PER_PAGE = 6;
  let page = 0;
  let matching = cards;
  const pager = document.createElement("nav");
  pager.className = "pager";
  const turn = (to) => {
    const pages = Math.max(1, Math.ceil(matching.length / PER_PAGE));
    page = Math.min(pages - 1, Math.max(0, to));
    const shown = new Set(matching.slice(page * PER_PAGE, (page + 1) * PER_PAGE));
    for (const c of cards) c.hidden = !shown.has(c);
    pager.hidden = pages === 1;
    pager.replaceChildren(
      ...[...Array(pages).keys()]
        .filter((n) => n === 0 || n === pages - 1 || Math.abs(n - page) <= 3)
        .map((n) => {
          const b = document.createElement("button");
          b.type = "button";
          b.textContent = n + 1;
          if (n === page) b.setAttribute("aria-current", "page");
          b.addEventListener("click", () => {
            turn(n);
            document.getElementById("episodes").scrollIntoView();
          });
          return b;
        }),
    );
  };
  if (cards.length > 0) {
    cards[cards.length - 1].after(pager);
    turn(0);
  }
  // A link to a card opens its page.
  const reveal = () => {
    const card = location.hash.length > 1 ? document.getElementById(decodeURIComponent(location.hash.slice(1)))?.closest(".card") : null;
    const at = card ? matching.indexOf(card) : -1;
    if (at >= 0 && card.hidden) {
      turn(Math.floor(at / PER_PAGE));
      card.scrollIntoView();
    }
  };
  addEventListener("hashchange", reveal);
  reveal();
  // What is printed is the whole.
  addEventListener("beforeprint", () => matching.forEach((c) => (c.hidden = false)));
  addEventListener("afterprint", () => turn(page));

  const filter = () => {
    const leaf = form.leaf.value, drive = form.drive.value, primary = form.primary.checked;
    matching = cards.filter((c) => (!leaf || c.dataset.leaf === leaf) && (!drive || c.dataset.drive === drive) && (!primary || c.dataset.primary === "1"));
    turn(0);
    form.querySelector(".shown").textContent = matching.length;
  };
  if (form) {
    form.addEventListener("change", filter);
    form.addEventListener("submit", (e) => e.preventDefault());
  }

  // The table of all classes opens when something leads into it.
  const leaves = document.querySelector("#leaves details");
  const unfold = () => {
    if (leaves && location.hash.startsWith("#leaf-")) leaves.open = true;
  };
  addEventListener("hashchange", unfold);
  unfold();
  addEventListener("beforeprint", () => leaves && (leaves.open = true));

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
      } else if (leaves) leaves.open = true;
    });
  }
})();
