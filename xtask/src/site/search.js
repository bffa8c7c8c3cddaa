// Sphinx finds pages, and reads them again for an excerpt, which a page opened from a folder may not. This finds the sections
// that have all words, from the script of all sections; a heading counts more than text, and the glossary before other pages. A
// word that stands nowhere is taken for the nearest one that does.
const EMPTY = new Set("a an and are can do does for get how i in is it my of on or that the to what when where which why with".split(" "));

// How many letters must be changed, put in or left out, or two neighbours exchanged.
function distance(one, other) {
  const rows = [[...Array(other.length + 1).keys()]];
  for (let i = 1; i <= one.length; i += 1) {
    rows.push([i]);
    for (let j = 1; j <= other.length; j += 1) {
      const swapped = i > 1 && j > 1 && one[i - 1] === other[j - 2] && one[i - 2] === other[j - 1] ? rows[i - 2][j - 2] + 1 : Infinity;
      rows[i].push(Math.min(rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + (one[i - 1] === other[j - 1] ? 0 : 1), swapped));
    }
  }
  return rows[one.length][other.length];
}

function nearest(word) {
  const all = Search.sections.map(([, , heading, text]) => `${heading} ${text}`).join(" ").toLowerCase();
  if (all.includes(word)) return word;
  const most = word.length > 5 ? 2 : word.length > 3 ? 1 : 0;
  let best = [most + 1, word];
  for (const other of new Set(all.match(/[\p{L}-]+/gu))) {
    if (Math.abs(other.length - word.length) >= best[0]) continue;
    const far = distance(word, other);
    if (far < best[0]) best = [far, other];
  }
  return best[1];
}

Search._performSearch = (query) => {
  const asked = query.toLowerCase().split(/\s+/).filter(Boolean);
  const words = (asked.some((word) => !EMPTY.has(word)) ? asked.filter((word) => !EMPTY.has(word)) : asked).map(nearest);
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
    return [page, plain(title), `#${anchor}`, plain(around), score(title.toLowerCase(), low) + (page === "docs/glossary" ? 15 : 0)];
  });
  // The best comes last.
  return found.filter((one) => one[4] > 0).sort((a, b) => a[4] - b[4]);
};
