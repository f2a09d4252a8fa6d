"use strict";
// The language of a page that holds both. In this order: `#zh` or `#en` in the address, so that a link can choose; what
// the reader chose on a page of Whyroad before; the language that the page was written in (`--lang`).
(() => {
  const KEY = "whyroad.lang";
  const root = document.documentElement;
  const known = (lang) => (lang === "zh" || lang === "en" ? lang : null);
  // A browser may refuse storage, for example in a private window.
  const stored = () => {
    try {
      return known(localStorage.getItem(KEY));
    } catch {
      return null;
    }
  };
  const keep = (lang) => {
    try {
      localStorage.setItem(KEY, lang);
    } catch {
      // The choice holds for this page only.
    }
  };
  const show = (lang) => {
    root.lang = lang;
    for (const o of document.querySelectorAll("option[data-zh]")) {
      o.textContent = `${lang === "zh" ? o.dataset.zh : o.dataset.en} (${o.dataset.n})`;
    }
    for (const radio of document.querySelectorAll("input[type=radio][name=l]")) radio.checked = radio.id === lang;
  };
  const choose = (lang) => {
    keep(lang);
    show(lang);
  };
  for (const b of document.querySelectorAll("button[data-lang]")) {
    b.addEventListener("click", () => choose(b.dataset.lang));
  }
  for (const radio of document.querySelectorAll("input[type=radio][name=l]")) {
    radio.addEventListener("change", () => choose(radio.id));
  }
  show(known(location.hash.slice(1)) ?? stored() ?? root.lang);
})();
