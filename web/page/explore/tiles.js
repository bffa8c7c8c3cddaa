// Tiles of the plane: which a view needs, at which fineness, and what is known of them. A tile has SIDE × SIDE cells whose
// middles stand on a fixed lattice, so that moving and zooming find what was computed before.

export const SIDE = 8;
const CELL_BYTES = 16;

// Cells this wide on the screen, in pixels: first coarse, so that the whole is seen at once, then finer.
const PASSES = [16, 4, 2];

// What the passes are called.
export const DETAILS = ["coarse", "fine", "finest"];

// The cells of a tile that cannot be computed: all of them failed.
export const NOTHING = new Uint8Array(SIDE * SIDE * CELL_BYTES).map((_, at) => (at % CELL_BYTES === 0 ? 4 : 0));

// Tiles begin at this frequency ratio, just below the first view: a cell at a much lower one takes many times as long, and would not be seen.
const EDGE = 0.75;

// Tiles kept at most.
const KEPT = 20_000;

const NAMES = ["none", null, "aperiodic", "chatter", "failed", "unsettled"];

// The power of two whose cells over `span` are nearest to `pixels` wide on `size` pixels of screen.
function level(span, size, pixels) {
  return Math.round(Math.log2(size / span / pixels));
}

// The tiles that a view needs up to a detail, by passes, those in the middle first: { key, pass, x, y: edges of the first cell,
// dx, dy }.
export function wanted(view, width, height, detail) {
  const list = [];
  for (const [pass, pixels] of PASSES.slice(0, DETAILS.indexOf(detail) + 1).entries()) {
    const levels = [level(view.x[1] - view.x[0], width, pixels), level(view.y[1] - view.y[0], height, pixels)];
    const [dx, dy] = levels.map((one) => 2 ** -one);
    const tiles = [];
    for (let i = Math.floor((view.x[0] - EDGE) / dx / SIDE); EDGE + i * SIDE * dx < view.x[1]; i += 1) {
      for (let j = Math.floor(view.y[0] / dy / SIDE); j * SIDE * dy < view.y[1]; j += 1) {
        const [x, y] = [EDGE + i * SIDE * dx, j * SIDE * dy];
        const middle = [(x + SIDE * dx / 2 - (view.x[0] + view.x[1]) / 2) / (view.x[1] - view.x[0]), (y + SIDE * dy / 2 - (view.y[0] + view.y[1]) / 2) / (view.y[1] - view.y[0])];
        tiles.push({ key: `${levels.join(":")}:${i}:${j}`, pass, x, y, dx, dy, far: Math.hypot(...middle) });
      }
    }
    tiles.sort((a, b) => a.far - b.far);
    list.push(...tiles);
  }
  return list;
}

// The middles of a tile's cells: Ω/ω and gap/A0.
export function middles(tile) {
  const along = (from, step) => Array.from({ length: SIDE }, (_, i) => from + (i + 0.5) * step);
  return { frequency_ratios: along(tile.x, tile.dx), gap_ratios: along(tile.y, tile.dy) };
}

// A cell of packed bytes (web/src/bytes.rs).
export function cell(bytes, index) {
  const view = new DataView(bytes.buffer, bytes.byteOffset + index * CELL_BYTES, CELL_BYTES);
  const what = view.getUint8(0);
  const settled = view.getUint32(4, true);
  const regime = NAMES[what] ?? `${view.getUint16(2, true)}/${view.getUint8(1)}`;
  return { regime, force_n: view.getFloat64(8, true), settled_after: settled === 0xffffffff ? null : settled };
}

// What is known, tile by tile.
export class Tiles {
  constructor() {
    this.known = new Map();
  }

  has(key) {
    return this.known.has(key);
  }

  put(tile, bytes) {
    this.known.set(tile.key, { ...tile, bytes, picture: null });
    while (this.known.size > KEPT) this.known.delete(this.known.keys().next().value);
  }

  clear() {
    this.known.clear();
  }

  // Those within a view, the coarse ones first.
  within(view) {
    const inside = [...this.known.values()].filter((t) => t.x < view.x[1] && t.x + SIDE * t.dx > view.x[0] && t.y < view.y[1] && t.y + SIDE * t.dy > view.y[0]);
    return inside.sort((a, b) => b.dx * b.dy - a.dx * a.dy);
  }

  // The finest cell that is known at a point, with its middle.
  at(x, y) {
    let best = null;
    for (const tile of this.known.values()) {
      const [column, row] = [Math.floor((x - tile.x) / tile.dx), Math.floor((y - tile.y) / tile.dy)];
      if (column < 0 || row < 0 || column >= SIDE || row >= SIDE) continue;
      if (!best || tile.dx * tile.dy < best.tile.dx * best.tile.dy) best = { tile, column, row };
    }
    if (!best) return null;
    const { tile, column, row } = best;
    return { ...cell(tile.bytes, row * SIDE + column), frequency_ratio: tile.x + (column + 0.5) * tile.dx, gap_ratio: tile.y + (row + 0.5) * tile.dy };
  }

  // Every cell of the finest pass that covers the view whole, by rising gap and frequency.
  rows(view, width, height) {
    const list = wanted(view, width, height, DETAILS.at(-1));
    for (let pass = PASSES.length - 1; pass >= 0; pass -= 1) {
      const tiles = list.filter((tile) => tile.pass === pass);
      if (!tiles.every((tile) => this.known.has(tile.key))) continue;
      const rows = [];
      for (const { key } of tiles) {
        const tile = this.known.get(key);
        const { frequency_ratios, gap_ratios } = middles(tile);
        gap_ratios.forEach((gap_ratio, row) => frequency_ratios.forEach((frequency_ratio, column) => {
          if (gap_ratio < view.y[0] || gap_ratio > view.y[1] || frequency_ratio < view.x[0] || frequency_ratio > view.x[1]) return;
          rows.push({ gap_ratio, frequency_ratio, ...cell(tile.bytes, row * SIDE + column) });
        }));
      }
      return rows.sort((a, b) => a.gap_ratio - b.gap_ratio || a.frequency_ratio - b.frequency_ratio);
    }
    return [];
  }
}
