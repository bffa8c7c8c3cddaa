// Charts with axes, units and round ticks, drawn as SVG in the size they are shown at.
import { element, fresh, svg } from "./dom.js";
import { around, digits, ticks } from "./numbers.js";
import { themeColour } from "./theme.js";

// What a chart's parts look like; a saved picture takes this along.
const STYLE = `
.paper { fill: var(--paper); }
.plot { fill: var(--plot); stroke: var(--line); }
.grid { stroke: var(--faint); }
text { fill: var(--ink); font: 12px system-ui, "DejaVu Sans", sans-serif; }
.mark { stroke: var(--ink); fill: none; }
`;

export const MARGIN = { left: 62, right: 12, top: 26, bottom: 42 };
const TITLE = { letter: 7.2, line: 15 };

// The space between two values, on the screen.
export function scale([low, high], [from, to]) {
  const along = (value) => from + ((value - low) / (high - low)) * (to - from);
  along.back = (place) => low + ((place - from) / (to - from)) * (high - low);
  return along;
}

// Axes around a rectangle: grid, ticks, labels.
export function axes(x, y, rangeX, rangeY, { left, top, width, height }, labels) {
  const group = svg("g");
  for (const { value, text } of ticks(...rangeX, Math.max(2, width / 80))) {
    group.append(
      svg("line", { class: "grid", x1: x(value), x2: x(value), y1: top, y2: top + height }),
      svg("text", { x: x(value), y: top + height + 16, "text-anchor": "middle" }, text),
    );
  }
  for (const { value, text } of ticks(...rangeY, Math.max(2, height / 45))) {
    group.append(
      svg("line", { class: "grid", x1: left, x2: left + width, y1: y(value), y2: y(value) }),
      svg("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, text),
    );
  }
  group.append(
    svg("text", { x: left + width / 2, y: top + height + 34, "text-anchor": "middle" }, labels.x),
    svg("text", { transform: `translate(14 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, labels.y),
  );
  return group;
}

// A title in as many lines as it needs.
function wrapped(title, room) {
  const lines = [""];
  for (const word of title.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (longer.length * TITLE.letter > room && lines.at(-1)) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  return lines;
}

// One point in the shape of its series.
function mark(shape, x, y, colour) {
  if (shape === "cross") return svg("path", { d: `M${x - 3} ${y - 3}l6 6m0 -6l-6 6`, stroke: colour, fill: "none" });
  if (shape === "square") return svg("rect", { x: x - 3, y: y - 3, width: 6, height: 6, fill: colour });
  if (shape === "ring") return svg("circle", { cx: x, cy: y, r: 4, stroke: colour, fill: "none", "stroke-width": 1.5 });
  return svg("circle", { cx: x, cy: y, r: 2.5, fill: colour });
}

// A chart with a caption below it. `draw` takes { title, x, y: names with units, series, bands, lines, posts, circles, description }.
// A series is { label, points: [[x, y], …], colour, kind: "line" or "points", dash, shape }, a band { label, from, to, colour } over x,
// a line { at } across, a post the x of an upright line, a circle { radius } about the origin. The ranges are those of the points,
// unless rangeX or rangeY say otherwise; `tight` leaves no margin over x, `least` are the narrowest spans, `equal` gives x the scale of
// y, `left` is where the plot begins.
export class Chart {
  constructor({ height = 260, label = "chart" } = {}) {
    this.height = height;
    this.picture = svg("svg", { role: "img", "aria-label": label, class: "chart", height });
    this.readout = element("output", { class: "readout" });
    this.legend = element("div", { class: "legend" });
    this.figure = element("figure", {}, this.picture, this.legend, this.readout);
    this.data = null;
    new ResizeObserver(() => this.redraw()).observe(this.figure);
    this.picture.addEventListener("pointermove", (event) => this.point(event));
    this.picture.addEventListener("pointerleave", () => { this.readout.textContent = ""; });
  }

  draw(data) {
    this.data = data;
    this.redraw();
  }

  redraw() {
    const { data, picture } = this;
    const width = Math.max(240, this.figure.clientWidth || 480);
    if (!data) return;
    const all = data.series.flatMap((one) => one.points);
    let rangeX = data.rangeX ?? around(all.map((p) => p[0]), data.tight ? 0 : 0.04, data.least?.[0]);
    const rangeY = data.rangeY ?? around(all.map((p) => p[1]).concat((data.lines ?? []).map((l) => l.at)), 0.04, data.least?.[1]);
    const title = wrapped(data.title, width - 2 * MARGIN.right);
    const top = MARGIN.top + TITLE.line * (title.length - 1);
    const tall = this.height - top - MARGIN.bottom;
    // Room for the longest number beside the axis's name.
    const letters = Math.max(...ticks(...rangeY, Math.max(2, tall / 45)).map(({ text }) => text.length), 0);
    const left = data.left ?? Math.max(MARGIN.left, 32 + 7.2 * letters);
    const plot = { left, top, width: width - left - MARGIN.right, height: tall };
    // Above the plot where it fits there, else from the left edge.
    const titleX = title.length > 1 || title[0].length * TITLE.letter > plot.width ? MARGIN.right : left;
    if (data.equal) {
      const half = ((rangeY[1] - rangeY[0]) / 2) * (plot.width / plot.height);
      rangeX = [(rangeX[0] + rangeX[1]) / 2 - half, (rangeX[0] + rangeX[1]) / 2 + half];
    }
    const x = scale(rangeX, [plot.left, plot.left + plot.width]);
    const y = scale(rangeY, [plot.top + plot.height, plot.top]);
    this.space = { x, y, plot };
    const clip = fresh("clip");
    picture.setAttribute("viewBox", `0 0 ${width} ${this.height}`);
    picture.setAttribute("height", this.height);
    picture.setAttribute("aria-label", `${data.title}. ${data.description ?? ""}`);
    picture.replaceChildren(
      svg("title", {}, data.title),
      svg("style", {}, STYLE),
      svg("clipPath", { id: clip }, svg("rect", { x: plot.left, y: plot.top, width: plot.width, height: plot.height })),
      svg("rect", { class: "paper", width, height: this.height }),
      svg("rect", { class: "plot", x: plot.left, y: plot.top, width: plot.width, height: plot.height }),
      ...title.map((line, i) => svg("text", { x: titleX, y: 16 + TITLE.line * i, "font-weight": "bold" }, line)),
      axes(x, y, rangeX, rangeY, plot, { x: data.x, y: data.y }),
      this.contents(data, clip),
    );
    this.legend.replaceChildren(...data.series.filter((one) => one.label).map((one) => element("span", {},
      svg("svg", { width: 22, height: 10, "aria-hidden": "true" }, one.kind === "points" ? mark(one.shape, 11, 5, one.colour)
        : svg("line", { x1: 1, x2: 21, y1: 5, y2: 5, stroke: one.colour, "stroke-width": 2, "stroke-dasharray": one.dash ?? null })),
      ` ${one.label}`)), ...(data.bands ?? []).filter((one) => one.label).map((one) => element("span", {},
      svg("svg", { width: 22, height: 10, "aria-hidden": "true" }, svg("rect", { x: 1, width: 20, height: 10, fill: one.colour, opacity: 0.35 })), ` ${one.label}`)));
  }

  contents(data, clip) {
    const { x, y, plot } = this.space;
    const group = svg("g", { "clip-path": `url(#${clip})` });
    for (const band of data.bands ?? []) {
      group.append(svg("rect", { x: x(band.from), width: Math.max(1, x(band.to) - x(band.from)), y: plot.top, height: plot.height, fill: band.colour, opacity: 0.35 }));
    }
    for (const line of data.lines ?? []) {
      group.append(svg("line", { class: "mark", x1: plot.left, x2: plot.left + plot.width, y1: y(line.at), y2: y(line.at), "stroke-dasharray": "4 3" }));
    }
    for (const post of data.posts ?? []) {
      group.append(svg("line", { class: "mark", x1: x(post), x2: x(post), y1: plot.top, y2: plot.top + plot.height, "stroke-dasharray": "4 3" }));
    }
    for (const circle of data.circles ?? []) {
      const [rx, ry] = [x(circle.radius) - x(0), y(0) - y(circle.radius)];
      group.append(svg("ellipse", { class: "mark", cx: x(0), cy: y(0), rx, ry, "stroke-dasharray": "4 3" }));
    }
    for (const one of data.series) {
      if (one.kind === "points") {
        for (const [px, py] of one.points) group.append(mark(one.shape, x(px), y(py), one.colour));
      } else {
        const points = one.points.map(([px, py]) => `${x(px).toFixed(2)},${y(py).toFixed(2)}`).join(" ");
        group.append(svg("polyline", { points, fill: "none", stroke: one.colour, "stroke-width": 1.6, "stroke-linejoin": "round", "stroke-dasharray": one.dash ?? null }));
      }
    }
    return group;
  }

  // The values nearest to the pointer, below the chart.
  point(event) {
    if (!this.data || !this.space) return;
    const box = this.picture.getBoundingClientRect();
    const at = [event.clientX - box.left, event.clientY - box.top];
    let best = null;
    for (const one of this.data.series) {
      for (const [px, py] of one.points) {
        const far = Math.hypot(this.space.x(px) - at[0], this.space.y(py) - at[1]);
        if (far < (best?.far ?? 40)) best = { far, one, px, py };
      }
    }
    this.readout.textContent = best ? `${best.one.label ?? ""} ${digits(best.px)}, ${digits(best.py)}`.trim() : "";
  }

  // The picture as it is shown, with its colours in it, as the text of an SVG file.
  file(madeFrom) {
    const copy = this.picture.cloneNode(true);
    const [, , width, height] = copy.getAttribute("viewBox").split(" ");
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    const colours = ["paper", "plot", "ink", "line", "faint"].map((name) => `--${name}: ${themeColour(name)};`).join(" ");
    copy.querySelector("style").prepend(`svg { ${colours} }`);
    const said = svg("metadata", { id: "made_from" }, JSON.stringify(madeFrom));
    copy.querySelector("title").after(said);
    return new XMLSerializer().serializeToString(copy);
  }
}
