// Pictures and tables as files, with what they were made from in them.
import { element } from "./dom.js";

// Hands a file to the browser.
function save(name, content, type) {
  const address = URL.createObjectURL(new Blob([content], { type }));
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

// A field of a CSV file.
function field(value) {
  if (value === null || value === undefined || (typeof value === "number" && !Number.isFinite(value))) return "";
  const text = String(value);
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

// Rows as CSV: the columns are the fields of the first.
export function csv(rows) {
  const names = Object.keys(rows[0] ?? {});
  const lines = rows.map((row) => names.map((name) => field(row[name])).join(","));
  return [names.join(","), ...lines].join("\n") + "\n";
}

const CHECKS = Uint32Array.from({ length: 256 }, (_, n) => {
  let check = n;
  for (let bit = 0; bit < 8; bit += 1) check = check & 1 ? 0xedb88320 ^ (check >>> 1) : check >>> 1;
  return check >>> 0;
});

function crc32(bytes) {
  let check = 0xffffffff;
  for (const byte of bytes) check = CHECKS[(check ^ byte) & 255] ^ (check >>> 8);
  return (check ^ 0xffffffff) >>> 0;
}

// A PNG file with a text under the keyword `made_from` in it (chunk iTXt, before the end).
function stamped(png, text) {
  const letters = new TextEncoder();
  const body = letters.encode(`iTXtmade_from\0\0\0\0\0${text}`);
  const chunk = new Uint8Array(body.length + 8);
  const view = new DataView(chunk.buffer);
  view.setUint32(0, body.length - 4);
  chunk.set(body, 4);
  view.setUint32(chunk.length - 4, crc32(body));
  const end = png.length - 12;
  return new Blob([png.slice(0, end), chunk, png.slice(end)], { type: "image/png" });
}

// An SVG file's text as PNG, twice as sharp as it is shown.
async function toPng(text, madeFrom) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = element("canvas", { width: 2 * image.width, height: 2 * image.height });
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  context.drawImage(image, 0, 0);
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  return stamped(new Uint8Array(await blob.arrayBuffer()), JSON.stringify(madeFrom));
}

// Buttons that save. `of` has `name` (of the files), `madeFrom()`, and of `picture()` (the text of an SVG file), `rows()` (a table)
// and `value()` (anything JSON can say) those that there are.
export function saveButtons(of) {
  const button = (kind, what, act) => element("button", { type: "button", class: "save", "aria-label": `save ${what} as ${kind}`, onclick: act }, kind);
  const made = [];
  if (of.picture) {
    made.push(button("SVG", of.name, () => save(`${of.name}.svg`, of.picture(), "image/svg+xml")));
    made.push(button("PNG", of.name, async () => save(`${of.name}.png`, await toPng(of.picture(), of.madeFrom()), "image/png")));
  }
  if (of.rows) made.push(button("CSV", of.name, () => save(`${of.name}.csv`, csv(of.rows()), "text/csv")));
  const value = of.value ?? (of.rows && (() => ({ rows: of.rows() })));
  if (value) made.push(button("JSON", of.name, () => save(`${of.name}.json`, JSON.stringify({ ...value(), made_from: of.madeFrom() }, null, 2) + "\n", "application/json")));
  return element("span", { class: "saves" }, ...made);
}
