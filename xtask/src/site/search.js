// The search above the list of pages: a section is found if it has all words; headings count more than text.
const MOST = 12;
const AROUND = 50;

let loading = null;

// The text of all sections, once it is wanted. A script, as a page opened from a folder may not fetch a file.
function sections() {
  loading ??= new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = "search-index.js";
    script.onload = () => done(globalThis.searchSections.map((one) => ({
      ...one,
      head: `${one.title} ${one.heading}`.toLowerCase(),
      low: one.text.toLowerCase(),
    })));
    script.onerror = failed;
    document.head.append(script);
  });
  return loading;
}

function ranked(all, words) {
  const score = (one) => words.reduce((sum, word) => {
    const head = one.head.includes(word) ? 20 : 0;
    const text = Math.min(one.low.split(word).length - 1, 10);
    return head + text > 0 ? sum + head + text : -Infinity;
  }, 0);
  const found = all.map((one) => ({ one, score: score(one) })).filter((hit) => hit.score > 0);
  return found.sort((a, b) => b.score - a.score).map((hit) => hit.one);
}

function element(name, attributes, ...children) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...children);
  return made;
}

// The text around the first word of the search that stands in it, that word marked.
function excerpt({ text, low }, words) {
  const word = words.find((one) => low.includes(one));
  if (!word) return text.slice(0, 2 * AROUND);
  const at = low.indexOf(word);
  const from = Math.max(0, at - AROUND);
  const end = at + word.length;
  return element("span", {}, `${from > 0 ? "…" : ""}${text.slice(from, at)}`,
    element("mark", {}, text.slice(at, end)), `${text.slice(end, end + AROUND)}…`);
}

const input = element("input", { type: "search", placeholder: "Search", autocomplete: "off" });
input.setAttribute("aria-label", "Search all pages");
const said = element("p", { className: "said" });
said.setAttribute("role", "status");
const list = element("ul", { className: "found" });

async function search() {
  const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) {
    said.textContent = "";
    list.replaceChildren();
    return;
  }
  const asked = input.value;
  const all = await sections().catch(() => null);
  // Something else was typed meanwhile.
  if (asked !== input.value) return;
  if (!all) {
    said.textContent = "The index search-index.js cannot be read.";
    return;
  }
  const found = ranked(all, words);
  const count = found.length === 1 ? "1 place" : `${found.length} places`;
  said.textContent = found.length > MOST ? `${count}; the first ${MOST}:` : found.length ? count : "No place has all of these words.";
  list.replaceChildren(...found.slice(0, MOST).map((one) => element("li", {},
    element("a", { href: `${one.page}#${one.anchor}` }, one.heading === one.title ? one.title : `${one.title}: ${one.heading}`),
    element("small", {}, excerpt(one, words)))));
}

input.addEventListener("input", search);
const form = element("form", {}, input, said, list);
form.setAttribute("role", "search");
form.addEventListener("submit", (event) => {
  event.preventDefault();
  list.querySelector("a")?.click();
});
document.getElementById("contents").prepend(form);
