// The scope: force, hammer and cart over the last seconds, one column per pixel with the least and the largest value in it, and what
// happened meanwhile. A gap is a column without a line.
import { element } from "../common/dom.js";
import { around, digits, ticks } from "../common/numbers.js";
import { SERIES } from "../common/colours.js";
import { onTheme, themeColour } from "../common/theme.js";

const SIGNALS = ["force, N", "hammer, mm", "cart, mm"];
const LEFT = 58;
const STRIP = 120;
const BELOW = 62;
// The names of events stand in so many rows above the axis of time.
const ROWS = 2;

export class Scope {
  constructor() {
    this.canvas = element("canvas", { role: "img", "aria-label": "contact force, hammer and cart over time", class: "scope" });
    this.figure = element("figure", {}, this.canvas);
    this.last = null;
    this.marks = [];
    new ResizeObserver(() => this.draw(this.last)).observe(this.figure);
    onTheme(() => this.draw(this.last));
  }

  // Columns to ask the board's scope for.
  columns() {
    return Math.max(50, Math.floor((this.figure.clientWidth || 600) - LEFT - 8));
  }

  // Draws [left edge, right edge, then (least, largest) of each signal per column]; `marks` is what happened: { time_s, text }.
  draw(values, marks = this.marks) {
    if (!values) return;
    [this.last, this.marks] = [values, marks];
    const ratio = window.devicePixelRatio || 1;
    const width = Math.max(200, this.figure.clientWidth || 600);
    const height = SIGNALS.length * STRIP + BELOW;
    const { canvas } = this;
    if (canvas.width !== Math.round(width * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      canvas.style.height = `${height}px`;
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = '12px system-ui, "DejaVu Sans", sans-serif';
    const columns = (values.length - 2) / (2 * SIGNALS.length);
    const step = (width - LEFT - 8) / columns;
    SIGNALS.forEach((name, signal) => this.strip(pen, values, { name, signal, columns, step, width }));
    this.times(pen, values, { columns, step, height });
  }

  strip(pen, values, { name, signal, columns, step, width }) {
    const top = signal * STRIP + 6;
    const bottom = top + STRIP - 18;
    const at = (column, edge) => values[2 + 2 * (SIGNALS.length * column + signal) + edge];
    const all = [];
    for (let column = 0; column < columns; column += 1) all.push(at(column, 0), at(column, 1));
    const [low, high] = around(all, 0.08);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top);
    pen.lineWidth = 1;
    pen.fillStyle = themeColour("ink");
    pen.strokeStyle = themeColour("faint");
    pen.textAlign = "right";
    for (const { value, text } of ticks(low, high, 3)) {
      pen.beginPath();
      pen.moveTo(LEFT, y(value));
      pen.lineTo(width - 8, y(value));
      pen.stroke();
      pen.fillText(text, LEFT - 5, y(value) + 4);
    }
    pen.fillText(name, width - 12, top + 4);
    pen.strokeStyle = SERIES[signal];
    pen.lineWidth = Math.max(1, step);
    pen.beginPath();
    for (let column = 0; column < columns; column += 1) {
      const [least, largest] = [at(column, 0), at(column, 1)];
      if (Number.isNaN(least)) continue;
      const x = LEFT + (column + 0.5) * step;
      // A column of one value is still seen.
      pen.moveTo(x, y(least) + 0.6);
      pen.lineTo(x, y(largest) - 0.6);
    }
    pen.stroke();
  }

  times(pen, values, { columns, step, height }) {
    const [from, to] = values;
    const x = (time) => LEFT + ((time - from) / (to - from)) * columns * step;
    pen.fillStyle = themeColour("ink");
    pen.textAlign = "center";
    for (const { value, text } of ticks(Math.max(0, from), to, 6)) pen.fillText(text, x(value), height - 14);
    pen.fillText("board's time, s", LEFT + (columns * step) / 2, height - 1);
    const seen = this.marks.filter(({ time_s }) => time_s >= from && time_s <= to);
    this.happened(pen, seen, x, { right: LEFT + columns * step, bottom: SIGNALS.length * STRIP });
    const said = seen.map(({ time_s, text }) => `${text} at ${digits(time_s)} s`).join("; ");
    this.canvas.setAttribute("aria-label", `contact force, hammer and cart from ${digits(Math.max(0, from))} to ${digits(to)} s${said ? `; ${said}` : ""}`);
  }

  // A line for each event, and its name where there is room for it.
  happened(pen, marks, x, { right, bottom }) {
    const ends = Array(ROWS).fill(0);
    pen.strokeStyle = pen.fillStyle = themeColour("warn");
    pen.lineWidth = 1;
    pen.setLineDash([3, 3]);
    pen.textAlign = "left";
    for (const { time_s, text } of marks) {
      const at = Math.round(x(time_s)) + 0.5;
      pen.beginPath();
      pen.moveTo(at, 0);
      pen.lineTo(at, bottom);
      pen.stroke();
      const name = text.length > 32 ? `${text.slice(0, 30)}…` : text;
      const wide = pen.measureText(name).width;
      const left = Math.min(at - 2, right - wide);
      const row = ends.findIndex((end) => end + 6 < left);
      if (row < 0) continue;
      ends[row] = left + wide;
      pen.fillText(name, left, bottom + 14 + 15 * row);
    }
    pen.setLineDash([]);
  }
}
