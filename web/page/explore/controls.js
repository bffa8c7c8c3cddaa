// The rig: preset or file, a slider for every parameter, how the cart is moved.
import { element, fresh } from "../common/dom.js";
import { title } from "../common/fields.js";

// Sliders reach from the rig's own value down and up by this factor.
const REACH = 4;

// Where a slider is not a matter of a factor: from, to, step.
const STRAIGHT = {
  gap_mm: [-1, 6, 0.01],
  damping_ratio: [0, 0.2, 0.001],
  contact_restitution: [0, 1, 0.01],
  shaker_feed_forward: [0, 1, 0.01],
};

// What decides for another: the one that is set last counts.
export const DECIDES = ["natural_frequency_hz", "wire_length_mm", "gravity_m_per_s2"];
const EITHER = { natural_frequency_hz: ["wire_length_mm"], wire_length_mm: ["natural_frequency_hz"] };

// The parameters in groups: those that most people move stand open, the rest is folded under a name of its own.
const GROUPS = [
  { name: "Hammer", more: "More of the hammer", has: (key) => !/^(cart|shaker|amplitude|contact|gap)_/.test(key) },
  { name: "Cart and shaker", more: "More of cart and shaker", has: (key) => /^(cart|shaker|amplitude)_/.test(key) },
  { name: "Surface", more: "Contact law, stiffness, damping", has: (key) => key.startsWith("contact_") },
  { name: "Gap", has: (key) => key === "gap_mm" },
];
const USUAL = ["mass_kg", "natural_frequency_hz", "amplitude_mm", "gap_mm"];

// A mistake in the page's words: parameters by their names here, and no options of the command line.
function inWords(message, keys) {
  message = message.replace(/: narrow it \(--amplitude-percent and the like\) or use --nominal$/, ": no frequency is safe for all of them").replace(/,? and with the switch engine (use )?a shorter tick$/, "");
  const longest = [...keys].sort((a, b) => b.length - a.length);
  return longest.reduce((said, key) => said.replaceAll(new RegExp(`\\b${key}\\b`, "g"), title(key).replace(/, (.*)$/, " ($1)")), message);
}

export class Controls {
  // `choices` has the words that can be chosen, by their key. `hear` is called with what has changed: { source, text } or { key, value } or { cart }.
  constructor(choices, hear) {
    this.choices = choices;
    this.hear = hear;
    this.preset = element("select", { id: "preset", onchange: () => hear({ source: this.preset.value, text: null }) }, ...choices.preset.map((name) => element("option", { value: name }, name)));
    this.cart = element("select", { id: "cart", onchange: () => hear({ cart: this.cart.value }) },
      element("option", { value: "machine" }, "as the machine's, if known"),
      element("option", { value: "prescribed" }, "as prescribed (the chapter's model)"),
      element("option", { value: "recoil" }, "recoils under its shaker"));
    this.file = element("input", { type: "file", id: "rigfile", accept: ".toml,text/plain", onchange: () => this.read(this.file.files[0]) });
    this.groups = GROUPS.map(({ name, more }) => {
      const id = fresh("group");
      const [usual, rest] = [element("div"), element("div")];
      const folded = more && element("details", {}, element("summary", {}, more), rest);
      return { usual, rest, folded, node: element("div", { role: "group", "aria-labelledby": id }, element("h3", { id }, name), usual, folded) };
    });
    // How the cart moves is no parameter of the rig, but stands with the cart's.
    this.groups[1].rest.before(element("div", { class: "pair" }, element("label", { for: "cart" }, "Cart"), this.cart));
    this.notes = element("div", { class: "note", id: "rig-notes" });
    this.reset = element("button", { type: "button", onclick: () => hear({ reset: true }) }, "Back to the rig's own values");
    const drop = element("div", { class: "drop" }, element("label", { for: "rigfile" }, "Own rig file (TOML): choose it, or drop it here"), this.file);
    this.panel = element("section", { class: "panel controls", "aria-label": "Rig" },
      element("h2", {}, "Rig"),
      element("div", { class: "pair" }, element("label", { for: "preset" }, "Preset"), this.preset),
      drop,
      ...this.groups.map((one) => one.node), this.reset, this.notes);
    // Wherever a file is dropped: a browser would leave the page for it. It is read where this part is seen.
    const carries = (event) => event.dataTransfer.types.includes("Files");
    for (const kind of ["dragenter", "dragover"]) {
      addEventListener(kind, (event) => {
        if (!carries(event)) return;
        event.preventDefault();
        this.panel.classList.add("dropping");
      });
    }
    for (const kind of ["dragleave", "drop"]) addEventListener(kind, () => this.panel.classList.remove("dropping"));
    addEventListener("drop", (event) => {
      if (!carries(event)) return;
      event.preventDefault();
      if (this.panel.offsetParent) this.read(event.dataTransfer.files[0]);
    });
  }

  async read(file) {
    if (!file) return;
    const most = 64 * 1024;
    if (file.size > most) return this.hear({ wrong: `${file.name} has ${file.size} bytes; a rig file has at most ${most}` });
    this.hear({ source: file.name, text: await file.text() });
  }

  // Shows a rig: `own` are the parameters of its preset or file, `now` those with the settings.
  show(state, own, now, meanings, shakerKnown) {
    const names = [...this.preset.options].map((option) => option.value);
    for (const option of [...this.preset.options]) if (option.dataset.file) option.remove();
    if (!names.includes(state.source) || state.text !== null) {
      this.preset.append(element("option", { value: state.source, "data-file": "yes" }, `${state.source} (file)`));
    }
    this.preset.value = state.source;
    this.cart.value = state.cart;
    this.cart.options[2].disabled = !shakerKnown;
    const keys = Object.keys(now);
    if (keys.join() !== this.shown) {
      this.shown = keys.join();
      this.rows = new Map();
      const order = Object.keys(meanings).filter((key) => keys.includes(key) && key !== "support");
      for (const { usual, rest } of this.groups) for (const part of [usual, rest]) part.replaceChildren();
      for (const key of order) {
        const group = this.groups[GROUPS.findIndex(({ has }) => has(key))];
        (USUAL.includes(key) ? group.usual : group.rest).append(this.row(key, meanings[key]));
      }
    }
    for (const [key, row] of this.rows) row.set(now[key], own[key] ?? now[key], key in state.settings);
    // What is folded does not hide that it was changed.
    for (const { rest, folded } of this.groups) folded?.classList.toggle("changed", rest.querySelector(".changed") !== null);
  }

  // A line of the program in the page's words.
  inWords(message) {
    return inWords(message, [...(this.rows?.keys() ?? [])]);
  }

  // Marks the parameter that a mistake is about, else the one changed last, and returns the mistake in the page's words.
  refuse(message, changed) {
    this.accept();
    const keys = [...(this.rows?.keys() ?? [])];
    const key = keys.find((one) => new RegExp(`\\b${one}\\b`).test(message)) ?? changed;
    const said = inWords(message, keys);
    this.rows?.get(key)?.refuse(said);
    return said;
  }

  // Takes the marks away.
  accept() {
    for (const row of this.rows?.values() ?? []) row.refuse(null);
  }

  row(key, meaning) {
    const id = fresh(key);
    const name = element("label", { for: id, title: meaning }, title(key));
    const change = (value) => this.hear({ key, value, without: EITHER[key] ?? [] });
    if (this.choices[key]) {
      const select = element("select", { id, "data-key": key, onchange: () => change(select.value) }, ...this.choices[key].map((one) => element("option", { value: one }, one)));
      const pair = element("div", { class: "pair" }, name, select);
      this.rows.set(key, {
        set: (value, own, changed) => {
          select.value = value;
          pair.classList.toggle("changed", changed);
        },
        refuse: refusal(pair, [select]),
      });
      return pair;
    }
    const straight = STRAIGHT[key];
    const slider = element("input", { type: "range", id, "data-key": key, "aria-description": meaning, ...(straight ? { min: straight[0], max: straight[1], step: straight[2] } : { min: -1, max: 1, step: 0.005 }) });
    const number = element("input", { type: "number", step: "any", "aria-label": `${title(key)}: number`, "data-number": key, onchange: () => number.value !== "" && change(Number(number.value)) });
    let middle = 1;
    const valueOf = () => (straight ? Number(slider.value) : Number((middle * REACH ** Number(slider.value)).toPrecision(4)));
    slider.addEventListener("input", () => {
      number.value = valueOf();
      slider.setAttribute("aria-valuetext", `${number.value} ${title(key).split(", ")[1] ?? ""}`);
      change(valueOf());
    });
    const row = element("div", { class: "parameter" }, name, slider, number);
    this.rows.set(key, {
      set: (value, own, changed) => {
        middle = own || 1;
        // A key that moved it knows where it stands.
        if (document.activeElement !== slider) slider.value = straight ? value : Math.max(-1, Math.min(1, Math.log(value / middle) / Math.log(REACH)));
        if (document.activeElement !== number) number.value = Number(value.toPrecision(10));
        slider.setAttribute("aria-valuetext", `${number.value} ${title(key).split(", ")[1] ?? ""}`);
        row.classList.toggle("changed", changed);
      },
      refuse: refusal(row, [slider, number]),
    });
    return row;
  }
}

// Marks the fields of a row and says why below them; null takes both away.
function refusal(row, fields) {
  const why = element("p", { class: "wrong why", id: fresh("why"), hidden: true });
  row.append(why);
  return (message) => {
    const folded = message !== null && row.closest("details");
    if (folded) folded.open = true;
    why.hidden = message === null;
    why.textContent = message ?? "";
    for (const field of fields) {
      if (message === null) {
        field.removeAttribute("aria-invalid");
        field.removeAttribute("aria-errormessage");
      } else {
        field.setAttribute("aria-invalid", "true");
        field.setAttribute("aria-errormessage", why.id);
      }
    }
  };
}
