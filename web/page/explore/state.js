// What is shown, kept in the address: rig, settings over it, cart, gap, frequency, the part of the plane in view.
// Everything else follows from it.

import { DETAILS } from "./tiles.js";

// The chapter's plane, in ratios; what a map shows at first.
export const HOME = { x: [0.78, 4.0], y: [0, 4] };

// The plane ends somewhere: drives slower or faster, and gaps wider, are no hammering. The narrowest view is one of rounding.
const REACH = { x: [0.2, 60], y: [-4, 40] };
const NARROWEST = 1e-4;

// The nearest view that is within the plane.
export function within({ x, y }) {
  const inside = ([low, high], [least, most]) => {
    const width = Math.min(Math.max(NARROWEST, high - low), most - least);
    const from = Math.max(least, Math.min(low, most - width));
    return [from, from + width];
  };
  return { x: inside(x, REACH.x), y: inside(y, REACH.y) };
}

export function initial() {
  return {
    source: "wires", text: null, settings: {}, cart: "machine", gap_mm: null, ratio: null, start: null,
    view: { x: [...HOME.x], y: [...HOME.y] }, units: "ratios", colour: "regime", detail: "finest", limits: {},
  };
}

// The rig as the module is asked for it. The map's own gap stands on its axis, so the gap is not among its settings.
export function rigOf(state) {
  const settings = Object.entries(state.settings).filter(([key]) => key !== "gap_mm").map(([key, value]) => `${key}=${value}`);
  return { source: state.source, text: state.text, settings, recoil: { machine: null, prescribed: false, recoil: true }[state.cart] };
}

// The fragment of the address that opens this state again.
export function toFragment(state) {
  const parts = new URLSearchParams();
  parts.set("rig", state.source);
  if (state.text !== null) parts.set("file", state.text);
  for (const [key, value] of Object.entries(state.settings)) parts.append("set", `${key}=${value}`);
  if (state.cart !== "machine") parts.set("cart", state.cart);
  // A file has a gap of its own, so 0 must be said.
  if (state.gap_mm || (state.gap_mm === 0 && state.text !== null)) parts.set("gap_mm", state.gap_mm);
  if (state.ratio !== null) parts.set("ratio", state.ratio);
  if (state.start) parts.set("start", state.start.join(","));
  const home = HOME.x.concat(HOME.y).join(",");
  const view = state.view.x.concat(state.view.y).map((value) => Number(value.toPrecision(7))).join(",");
  if (view !== home) parts.set("view", view);
  if (state.units !== "ratios") parts.set("units", state.units);
  if (state.colour !== "regime") parts.set("colour", state.colour);
  if (state.detail !== "finest") parts.set("detail", state.detail);
  for (const [key, value] of Object.entries(state.limits)) parts.append("limit", `${key}=${value}`);
  return `#explore?${parts}`;
}

// The state in a fragment; what cannot be read is left as it is at first.
export function fromFragment(fragment) {
  const state = initial();
  const [part, query] = fragment.replace(/^#/, "").split("?");
  if (part !== "explore" || !query) return state;
  const parts = new URLSearchParams(query);
  const number = (name, least, most) => {
    const value = Number(parts.get(name));
    return parts.has(name) && Number.isFinite(value) && value >= least && value <= most ? value : null;
  };
  const pairs = (name) => Object.fromEntries(parts.getAll(name).map((pair) => pair.split("=")).filter((pair) => pair.length === 2 && /^\w+$/.test(pair[0])));
  state.source = parts.get("rig") ?? state.source;
  state.text = parts.get("file");
  state.settings = pairs("set");
  if (["prescribed", "recoil"].includes(parts.get("cart"))) state.cart = parts.get("cart");
  state.gap_mm = number("gap_mm", -1e3, 1e3);
  state.ratio = number("ratio", 1e-3, 1e3);
  const list = (name, count) => {
    const values = (parts.get(name) ?? "").split(",").map(Number);
    return parts.has(name) && values.length === count && values.every(Number.isFinite) ? values : null;
  };
  state.start = list("start", 2);
  const view = list("view", 4);
  if (view && view[0] < view[1] && view[2] < view[3]) state.view = within({ x: view.slice(0, 2), y: view.slice(2) });
  if (parts.get("units") === "absolute") state.units = "absolute";
  if (parts.get("colour") === "force") state.colour = "force";
  if (DETAILS.includes(parts.get("detail"))) state.detail = parts.get("detail");
  for (const [key, value] of Object.entries(pairs("limit"))) {
    if (Number(value) > 0) state.limits[key] = Number(value);
  }
  return state;
}
