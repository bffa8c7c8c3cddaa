// Sphinx finds pages, and reads them again for an excerpt, which a page opened from a folder may not. This finds the sections
// that have all words, from the script of all sections; a heading counts more than text.
Search._performSearch = (query) => {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const plain = (text) => new Option(text).innerHTML;
  const titles = Object.fromEntries(Search._index.docnames.map((page, at) => [page, Search._index.titles[at]]));
  const score = (head, text) => words.reduce((sum, word) => {
    const found = (head.includes(word) ? 20 : 0) + Math.min(text.split(word).length - 1, 10);
    return found > 0 ? sum + found : -Infinity;
  }, 0);
  const found = Search.sections.map(([page, anchor, heading, text]) => {
    const low = text.toLowerCase();
    const title = titles[page] === heading ? heading : `${titles[page]}: ${heading}`;
    const at = Math.max(0, low.indexOf(words.find((word) => low.includes(word))) - 60);
    const around = `${at > 0 ? "…" : ""}${text.slice(at, at + 200)}…`;
    return [page, plain(title), `#${anchor}`, plain(around), score(title.toLowerCase(), low)];
  });
  // The best comes last.
  return found.filter((one) => one[4] > 0).sort((a, b) => a[4] - b[4]);
};
