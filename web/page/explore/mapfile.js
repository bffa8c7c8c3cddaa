// The map as a picture file: the cells as pixels, axes, marks and the colours' names as drawn.
import { REGIMES, regimeWords } from "../common/colours.js";
import { svg } from "../common/dom.js";
import { themeColour } from "../common/theme.js";

const LEGEND = 18;

export function mapFile(map, madeFrom) {
  const { width, height } = map.space();
  const names = map.colour === "force" ? [] : map.explained.split(",").filter(Boolean).map((index) => REGIMES[Number(index)]);
  const across = Math.max(1, Math.floor(width / 90));
  const rows = Math.ceil(names.length / across);
  const over = map.over.cloneNode(true);
  const all = svg("svg", { xmlns: "http://www.w3.org/2000/svg", width, height: height + rows * LEGEND + 6, viewBox: `0 0 ${width} ${height + rows * LEGEND + 6}` });
  const colours = ["paper", "plot", "ink", "line", "faint", "accent"].map((name) => `--${name}: ${themeColour(name)};`).join(" ");
  all.append(
    svg("title", {}, `Map of ${madeFrom.rig.name}: ${map.colour === "force" ? "force of 1/1" : "regimes z = p/n"} over frequency and gap`),
    svg("metadata", { id: "made_from" }, JSON.stringify(madeFrom)),
    svg("style", {}, `svg { ${colours} } ${PLANE_STYLE}`),
    svg("rect", { width, height: height + rows * LEGEND + 6, fill: "var(--paper)" }),
    svg("image", { href: map.canvas.toDataURL(), width, height }),
    ...over.childNodes,
  );
  names.forEach(([name, colour], index) => {
    const [x, y] = [10 + (index % across) * 90, height + 12 + Math.floor(index / across) * LEGEND];
    all.append(svg("rect", { x, y: y - 9, width: 11, height: 11, fill: colour, stroke: "var(--line)" }), svg("text", { x: x + 16, y }, regimeWords(name)));
  });
  return new XMLSerializer().serializeToString(all);
}

// As style.css has it for the map on the page.
const PLANE_STYLE = `text { fill: var(--ink); font: 12px system-ui, "DejaVu Sans", sans-serif; } .grid { stroke: none; }
.frame { fill: none; stroke: var(--line); } .halo { fill: none; stroke: #ffffff; stroke-width: 5; } .gapline { stroke: #000000; stroke-width: 1.4; stroke-dasharray: 5 4; }
.band { stroke: #000000; stroke-width: 4; } .best { fill: #ffffff; stroke: #000000; stroke-width: 2; } .cross { fill: none; stroke: #000000; stroke-width: 2; }`;
