// The rig as it moved: the cart, the hammer in it and the impact surface, the last half second, ten times slower. The surface
// stands where the hammer came nearest to it; displacements are as large as the picture has room for.
import { element, svg } from "../common/dom.js";

const SECONDS = 0.5;
const SLOWER = 10;
const COLUMNS = 1000;
// A blow is shown for so many columns: a tenth of a second as it is played, longer than a screen needs to show it.
const FLASH = 20;
// A motion is drawn no larger than one of so many mm.
const SMALLEST = 1;
const [WIDTH, HEIGHT, HALF] = [600, 110, 120];
// The inner side of the cart's wall, from the cart's middle.
const WALL = 138;

export class Picture {
  // `trace(seconds, columns)` is the board's scope; `seen` tells whether anybody looks.
  constructor(trace, seen) {
    this.trace = trace;
    this.seen = seen;
    this.cart = svg("path", { d: `M-150 40 H150 V-40 H${WALL} V28 H-150 Z`, class: "cart" });
    this.hammer = svg("rect", { x: -60, y: -20, width: 60, height: 40, class: "hammer" });
    this.said = element("figcaption", { class: "note" });
    this.drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": "cart and hammer, ten times slower", class: "rig" },
      svg("line", { x1: WIDTH / 2, x2: WIDTH / 2, y1: 0, y2: HEIGHT }), this.cart, this.hammer);
    this.figure = element("figure", {}, this.drawing, this.said);
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
  }

  // Begins to play if it does not yet.
  play() {
    if (this.playing) return;
    this.playing = true;
    this.values = null;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    if (!this.seen()) {
      this.playing = false;
      return;
    }
    const passed = this.values ? (now - this.began) / 1000 / SLOWER : SECONDS;
    if (passed >= SECONDS) this.load(now);
    this.show(this.still.matches ? COLUMNS - 1 : Math.floor((Math.max(0, passed % SECONDS) / SECONDS) * COLUMNS));
    requestAnimationFrame((next) => this.frame(next));
  }

  // Takes the last half second, and the scale and the surface that suit it.
  load(now) {
    this.began = now;
    this.values = this.trace(SECONDS, COLUMNS);
    let [far, gap, largest, sum] = [SMALLEST, 0, 0, 0];
    for (let column = 0; column < this.columns(); column += 1) {
      const { force, hammer, cart } = this.at(column);
      if (Number.isNaN(hammer + cart)) continue;
      far = Math.max(far, Math.abs(hammer), Math.abs(cart));
      gap = Math.max(gap, hammer - cart);
      largest = Math.max(largest, force);
      sum += Math.abs(force);
    }
    // A blow stands out of the noise.
    this.strikes = largest > 8 * (sum / this.columns());
    this.scale = HALF / far;
    this.gap = gap;
  }

  columns() {
    return (this.values.length - 2) / 6;
  }

  at(column) {
    const [, force, hammer0, hammer1, cart0, cart1] = this.values.subarray(2 + 6 * column, 8 + 6 * column);
    return { force, hammer: (hammer0 + hammer1) / 2, cart: (cart0 + cart1) / 2 };
  }

  // Whether the hammer is at the surface, or was just now.
  touched(column) {
    for (let one = Math.max(0, column - FLASH); one <= column && one < this.columns(); one += 1) {
      const { hammer, cart } = this.at(one);
      if (hammer - cart > 0.98 * this.gap - 0.02) return true;
    }
    return false;
  }

  show(column) {
    const { hammer, cart } = this.at(Math.min(column, this.columns() - 1));
    if (Number.isNaN(hammer + cart)) return;
    const x = (mm) => WIDTH / 2 + mm * this.scale;
    this.cart.setAttribute("transform", `translate(${x(cart + this.gap) - WALL} ${HEIGHT / 2})`);
    this.hammer.setAttribute("transform", `translate(${x(hammer)} ${HEIGHT / 2})`);
    this.hammer.classList.toggle("touches", this.strikes && this.touched(column));
    const [from] = this.values;
    const time = from + (column / COLUMNS) * SECONDS;
    const said = `${time.toFixed(3)} s, ten times slower: hammer ${hammer.toFixed(2)} mm, cart ${cart.toFixed(2)} mm`;
    this.said.textContent = said.replaceAll("-", "\u2212");
  }
}
