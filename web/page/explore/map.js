// The plane of gap and frequency: computed tile by tile, moved and zoomed by pointer, wheel, keys and buttons.
import { MARGIN as CHART, axes, scale } from "../common/chart.js";
import { REGIMES, regimeIndex, regimeWords } from "../common/colours.js";
import { element, svg } from "../common/dom.js";
import { digits } from "../common/numbers.js";
import { onTheme, themeColour } from "../common/theme.js";
import { HOME, within } from "./state.js";
import { DETAILS, NOTHING, SIDE, Tiles, cell, middles, wanted } from "./tiles.js";

// The map stands under the force curve: the same frequency is at the same place.
const MARGIN = { left: CHART.left, right: CHART.right, top: 8, bottom: CHART.bottom };

// The axis of frequency: what a frequency ratio is multiplied by to stand on it, and its name.
export function frequencyAxis(units, facts) {
  return units === "absolute" ? { factor: facts.natural_frequency_hz, name: "drive frequency, Hz" } : { factor: 1, name: "drive frequency over natural frequency, Ω/ω" };
}

// How a cell of the map is run: the chapter's cycles.
const PLAN = { cycles: 300, recorded: 100 };

// Dark to light for small to large (the colours of `viridis`, which rise in lightness for every reader).
const LADDER = ["#440154", "#472D7B", "#3B528B", "#2C728E", "#21918C", "#28AE80", "#5EC962", "#ADDC30", "#FDE725"];

function bytesOf(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

function between(share) {
  const place = Math.max(0, Math.min(1, share)) * (LADDER.length - 1);
  const [low, part] = [Math.min(LADDER.length - 2, Math.floor(place)), place % 1];
  const [a, b] = [bytesOf(LADDER[low]), bytesOf(LADDER[low + 1])];
  const at = place >= LADDER.length - 1 ? 1 : part;
  return a.map((one, i) => Math.round(one + at * (b[i] - one)));
}

const HELP = "Arrow keys move the cross; Enter shows the motion there; plus and minus zoom; Shift with arrows moves the view; Home shows all.";

export class PlaneMap {
  // `hear` has: point(ratio, gap ratio), view(view), measured(what, ms).
  constructor(pool, hear) {
    this.pool = pool;
    this.hear = hear;
    this.tiles = new Tiles();
    this.canvas = element("canvas", {});
    this.over = svg("svg", { "aria-hidden": "true" });
    this.box = element("div", { class: "plane", tabindex: "0", role: "application", "aria-label": `Map of regimes over frequency and gap. ${HELP}`, "aria-describedby": "plane-cell" }, this.canvas, this.over);
    this.said = element("output", { id: "plane-cell", class: "readout", "aria-live": "polite" });
    this.progress = element("progress", { max: 1, value: 0, "aria-label": "map computed" });
    this.legend = element("ul", { class: "regimes", "aria-label": "Colours of the map" });
    this.marks = {};
    this.most = 40;
    this.leave = new AbortController();
    new ResizeObserver(() => this.redraw(true)).observe(this.box);
    onTheme(() => this.redraw());
    this.listen();
  }

  // A rig to show: everything begins anew.
  setRig(rig, facts, view) {
    this.rig = rig;
    this.facts = facts;
    this.view = view;
    this.tiles.clear();
    this.began = performance.now();
    this.redraw(true);
  }

  setMarks(marks) {
    this.marks = marks;
    this.overlay();
  }

  setLook({ units, colour, detail }) {
    if (colour !== this.colour) for (const tile of this.tiles.known.values()) tile.picture = null;
    const other = detail !== this.detail;
    Object.assign(this, { units, colour, detail });
    this.redraw(other);
  }

  setView(view) {
    this.view = within(view);
    this.hear.view(this.view);
    this.redraw(true);
  }

  home() {
    this.setView({ x: [...HOME.x], y: [...HOME.y] });
  }

  // Zooms about a point of the plane.
  zoom(factor, about = [(this.view.x[0] + this.view.x[1]) / 2, (this.view.y[0] + this.view.y[1]) / 2]) {
    const to = (range, at) => range.map((value) => at + (value - at) * factor);
    this.setView({ x: to(this.view.x, about[0]), y: to(this.view.y, about[1]) });
  }

  // Moves by shares of the view.
  move(shareX, shareY) {
    const by = (range, share) => range.map((value) => value + share * (range[1] - range[0]));
    this.setView({ x: by(this.view.x, shareX), y: by(this.view.y, shareY) });
  }

  space() {
    const width = Math.max(200, this.box.clientWidth);
    const height = Math.max(220, this.box.clientHeight);
    const plot = { left: MARGIN.left, top: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
    const x = scale(this.view.x, [plot.left, plot.left + plot.width]);
    const y = scale(this.view.y, [plot.top + plot.height, plot.top]);
    return { width, height, plot, x, y };
  }

  redraw(ask = false) {
    if (!this.view || !this.box.clientWidth) return;
    this.overlay();
    this.paint();
    if (ask) this.ask();
  }

  // Asks for the tiles that are missing; those asked for before and not begun are given up.
  ask() {
    this.leave.abort(new Error("the view has changed"));
    this.leave = new AbortController();
    const [leave, rig] = [this.leave, this.rig];
    const { plot } = this.space();
    const all = wanted(this.view, plot.width, plot.height, this.detail);
    const missing = all.filter((tile) => !this.tiles.has(tile.key));
    const left = [0, 0, 0];
    for (const tile of missing) left[tile.pass] += 1;
    let done = all.length - missing.length;
    this.count(done, all.length);
    for (const tile of missing) {
      const argument = { rig, ...middles(tile), ...PLAN };
      // The finest pass waits for everything else.
      const order = [2, 4, 6][tile.pass];
      const asked = this.pool.run("explore.map", argument, { order, signal: leave.signal, finish: true });
      asked.catch((error) => {
        // A gap that this rig cannot have, say: such a tile stays empty.
        if (!leave.signal.aborted) this.hear.failed(error);
        return { answer: NOTHING };
      }).then(({ answer }) => {
        if (rig !== this.rig || (answer === NOTHING && leave.signal.aborted)) return;
        this.tiles.put(tile, answer);
        this.paint();
        if (leave.signal.aborted) return;
        done += 1;
        left[tile.pass] -= 1;
        this.count(done, all.length);
        if (left[tile.pass] === 0) this.hear.measured(DETAILS[tile.pass], performance.now() - this.began);
      });
    }
    if (!missing.length) this.hear.measured(this.detail, performance.now() - this.began);
  }

  count(done, all) {
    this.progress.max = all;
    this.progress.value = done;
    this.progress.hidden = done === all;
    this.box.dataset.done = String(done === all);
  }

  picture(tile) {
    const image = new ImageData(SIDE, SIDE);
    const colours = REGIMES.map(([, colour]) => bytesOf(colour));
    const ground = bytesOf(themeColour("plot").length === 7 ? themeColour("plot") : "#ffffff");
    for (let index = 0; index < SIDE * SIDE; index += 1) {
      const { regime, force_n } = cell(tile.bytes, index);
      let colour = regime === "failed" ? ground : colours[regimeIndex(regime)];
      if (this.colour === "force") colour = regime === "1/1" ? between(force_n / this.facts.weight_n / this.most) : ground;
      // The first row of the cells is the lowest gap, that of a picture the top.
      const [row, column] = [SIDE - 1 - Math.floor(index / SIDE), index % SIDE];
      image.data.set([...colour, 255], 4 * (row * SIDE + column));
    }
    const canvas = new OffscreenCanvas(SIDE, SIDE);
    canvas.getContext("2d").putImageData(image, 0, 0);
    return canvas;
  }

  // What the recommended 1/1 reaches, m g: the scale of forces ends at a round number above it, as other gaps have more.
  setForce(ratio) {
    const most = Math.max(5, Math.ceil((1.25 * ratio) / 5) * 5);
    if (most === this.most) return;
    this.most = most;
    if (this.colour !== "force") return;
    for (const tile of this.tiles.known.values()) tile.picture = null;
    this.redraw();
  }

  paint() {
    if (this.painting) return;
    this.painting = true;
    requestAnimationFrame(() => {
      this.painting = false;
      this.paintNow();
    });
  }

  paintNow() {
    const { width, height, plot, x, y } = this.space();
    const sharp = window.devicePixelRatio || 1;
    const { canvas } = this;
    [canvas.width, canvas.height] = [Math.round(width * sharp), Math.round(height * sharp)];
    const context = canvas.getContext("2d");
    context.scale(sharp, sharp);
    context.imageSmoothingEnabled = false;
    context.fillStyle = themeColour("plot");
    context.fillRect(plot.left, plot.top, plot.width, plot.height);
    context.save();
    context.beginPath();
    context.rect(plot.left, plot.top, plot.width, plot.height);
    context.clip();
    const seen = new Set();
    for (const tile of this.tiles.within(this.view)) {
      tile.picture ??= this.picture(tile);
      const [left, top] = [x(tile.x), y(tile.y + SIDE * tile.dy)];
      context.drawImage(tile.picture, left, top, x(tile.x + SIDE * tile.dx) - left, y(tile.y) - top);
      if (!tile.regimes) tile.regimes = new Set(Array.from({ length: SIDE * SIDE }, (_, i) => cell(tile.bytes, i).regime));
      for (const regime of tile.regimes) seen.add(regimeIndex(regime));
    }
    context.restore();
    this.explain(seen);
  }

  explain(seen) {
    if (this.colour === "force") {
      const bar = element("li", { class: "ladder" }, `force of 1/1 over m g: 0 `, element("span", { style: `background: linear-gradient(90deg, ${LADDER.join(", ")})` }), ` ${digits(this.most)}`);
      return this.legend.replaceChildren(bar);
    }
    const said = [...seen].sort((a, b) => a - b).join();
    if (said === this.explained && this.legend.children.length) return;
    this.explained = said;
    this.legend.replaceChildren(...REGIMES.filter((_, index) => seen.has(index)).map(([name, colour]) =>
      element("li", {}, element("span", { style: `background: ${colour}` }), regimeWords(name))));
  }

  overlay() {
    const { width, height, plot, x, y } = this.space();
    const absolute = this.units === "absolute";
    const { factor: fx, name } = frequencyAxis(this.units, this.facts);
    const fy = absolute ? this.facts.amplitude_mm : 1;
    const names = { x: name, y: absolute ? "gap at rest, mm" : "gap over cart amplitude, gap/A0" };
    const over = this.over;
    over.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const inside = svg("g", { "clip-path": "inset(0)" });
    over.replaceChildren(
      axes((v) => x(v / fx), (v) => y(v / fy), this.view.x.map((v) => v * fx), this.view.y.map((v) => v * fy), plot, names),
      svg("rect", { class: "frame", x: plot.left, y: plot.top, width: plot.width, height: plot.height }),
      inside,
    );
    const inView = (ratio, gap) => ratio >= this.view.x[0] && ratio <= this.view.x[1] && gap >= this.view.y[0] && gap <= this.view.y[1];
    const { gap, band, best, point } = this.marks;
    if (gap !== undefined && gap >= this.view.y[0] && gap <= this.view.y[1]) {
      inside.append(svg("line", { class: "halo", x1: plot.left, x2: plot.left + plot.width, y1: y(gap), y2: y(gap) }), svg("line", { class: "gapline", x1: plot.left, x2: plot.left + plot.width, y1: y(gap), y2: y(gap) }));
      if (band) {
        const [a, b] = band.map((ratio) => Math.max(plot.left, Math.min(plot.left + plot.width, x(ratio))));
        inside.append(svg("line", { class: "halo", x1: a, x2: b, y1: y(gap), y2: y(gap), "stroke-width": 8 }), svg("line", { class: "band", x1: a, x2: b, y1: y(gap), y2: y(gap) }));
      }
      if (best && inView(best, gap)) inside.append(svg("path", { class: "best", d: `M${x(best)} ${y(gap) - 9}l9 9l-9 9l-9 -9z` }));
    }
    if (point && inView(...point)) {
      const [px, py] = [x(point[0]), y(point[1])];
      for (const name of ["halo", "cross"]) inside.append(svg("path", { class: name, d: `M${px - 11} ${py}h22M${px} ${py - 11}v22` }));
    }
  }

  // Where on the plane a place of the screen is.
  at(event) {
    const box = this.box.getBoundingClientRect();
    const { plot, x, y } = this.space();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    if (px < plot.left || px > plot.left + plot.width || py < plot.top || py > plot.top + plot.height) return null;
    return [x.back(px), y.back(py)];
  }

  tell([ratio, gap]) {
    const { natural_frequency_hz, amplitude_mm, weight_n } = this.facts;
    const found = this.tiles.at(ratio, gap);
    const where = `Ω/ω ${digits(ratio)} (${digits(ratio * natural_frequency_hz)} Hz), gap/A0 ${digits(gap, 3)} (${digits(gap * amplitude_mm, 3)} mm)`;
    const what = !found ? "not yet computed" : found.regime === "none" ? "no contact" : found.regime === "failed" ? "cannot be followed"
      : `${found.regime}, force ${digits(found.force_n / weight_n, 3)} m g (${digits(found.force_n, 3)} N)${found.settled_after === null ? ", not settled" : ""}`;
    this.said.textContent = `${where}: ${what}`;
  }

  choose(at) {
    this.tell(at);
    this.hear.point(...at);
  }

  listen() {
    const { box } = this;
    const fingers = new Map();
    let moved = 0;
    let spread = null;
    box.addEventListener("pointerdown", (event) => {
      if (!this.at(event) || event.button > 0) return;
      box.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      moved = 0;
      spread = null;
    });
    box.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) {
        const at = this.at(event);
        if (at) this.tell(at);
        return;
      }
      const now = [event.clientX, event.clientY];
      fingers.set(event.pointerId, now);
      const { plot } = this.space();
      if (fingers.size === 2) {
        const [a, b] = [...fingers.values()];
        const far = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (spread) this.zoom(spread / far, this.at({ clientX: (a[0] + b[0]) / 2, clientY: (a[1] + b[1]) / 2 }) ?? undefined);
        spread = far;
        moved = 99;
      } else {
        moved += Math.hypot(now[0] - last[0], now[1] - last[1]);
        if (moved > 4) this.move((last[0] - now[0]) / plot.width, (now[1] - last[1]) / plot.height);
      }
    });
    const up = (event) => {
      const was = fingers.delete(event.pointerId);
      if (was && event.type === "pointerup" && moved <= 4) {
        const at = this.at(event);
        if (at) this.choose(at);
      }
    };
    box.addEventListener("pointerup", up);
    box.addEventListener("pointercancel", up);
    box.addEventListener("wheel", (event) => {
      const at = this.at(event);
      if (!at) return;
      event.preventDefault();
      this.zoom(1.0015 ** event.deltaY, at);
    }, { passive: false });
    box.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const middle = [(this.view.x[0] + this.view.x[1]) / 2, (this.view.y[0] + this.view.y[1]) / 2];
    if (step && event.shiftKey) this.move(step[0] * 0.2, step[1] * 0.2);
    else if (step) {
      const from = this.marks.point ?? middle;
      const share = 0.01;
      const point = [from[0] + step[0] * share * (this.view.x[1] - this.view.x[0]), from[1] + step[1] * share * (this.view.y[1] - this.view.y[0])];
      this.setMarks({ ...this.marks, point });
      this.tell(point);
    } else if (event.key === "Enter" || event.key === " ") this.choose(this.marks.point ?? middle);
    else if (event.key === "+" || event.key === "=") this.zoom(0.7, this.marks.point ?? undefined);
    else if (event.key === "-") this.zoom(1 / 0.7, this.marks.point ?? undefined);
    else if (event.key === "Home") this.home();
    else return;
    event.preventDefault();
  }
}
