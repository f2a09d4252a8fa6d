// Finds Chinese text in the book's search. mdBook's index keeps only tokens of Latin letters and digits, so a query with
// Chinese characters would find nothing. Such a query is answered by a scan of the stored text of all sections instead.
(() => {
  if (!window.elasticlunr) return;
  const load = elasticlunr.Index.load;
  elasticlunr.Index.load = function (stored) {
    const index = load.call(this, stored);
    const search = index.search.bind(index);
    const sections = Object.entries(stored.documentStore?.docs ?? {});
    index.search = (query, options) => {
      if (!/\p{Script=Han}/u.test(query)) return search(query, options);
      const words = query.toLowerCase().split(/\s+/).filter(Boolean);
      const found = [];
      for (const [ref, doc] of sections) {
        const title = `${doc.title} ${doc.breadcrumbs}`.toLowerCase();
        const body = String(doc.body).toLowerCase();
        if (!words.every((word) => title.includes(word) || body.includes(word))) continue;
        const inTitle = words.filter((word) => title.includes(word)).length;
        found.push({ ref, doc, score: 1 + 10 * inTitle });
      }
      return found.sort((a, b) => b.score - a.score);
    };
    return index;
  };
})();
