// The recommendation: first where the rig as it stands is strongest, then the whole pick, and on request with the
// uncertainty of the parameters.
import { Chart } from "../common/chart.js";
import { regimeColour } from "../common/colours.js";
import { element } from "../common/dom.js";
import { markField } from "../common/fields.js";
import { digits } from "../common/numbers.js";
import { saveButtons } from "../common/save.js";

// In words what ends the stable 1/1.
const ENDS = {
  period_doubling: "its period doubles", extra_contact: "a second contact appears", fold: "it folds, and the hammer jumps",
  search_limit: "the search stopped", contact_at_section: "a contact lasts over drive phase 0",
};

const LIMITS = [["max_force_n", "largest force, N"], ["max_frequency_hz", "highest frequency, Hz"], ["max_shaker_force_n", "largest shaker force, N"]];

const range = ([low, high], count = 4) => `${digits(low, count)} to ${digits(high, count)} Hz`;

export class AnswerPanel {
  constructor(pool, hear) {
    this.pool = pool;
    this.hear = hear;
    this.said = element("div", { role: "status", "aria-live": "polite", id: "answer" });
    this.problem = element("p", { class: "wrong", role: "alert", id: "no-answer" });
    this.table = element("div", { class: "scroll" });
    this.more = element("button", { type: "button", id: "uncertain", onclick: () => this.whole(false) }, "With the uncertainty of the parameters");
    this.took = element("p", { class: "note", id: "took" });
    this.chart = new Chart({ height: 240, label: "force of the stable 1/1 over frequency" });
    this.limits = LIMITS.map(([key, name]) => {
      const input = element("input", { type: "number", min: 0, step: "any", "data-limit": key, onchange: () => {
        const value = input.value === "" && !input.validity.badInput ? null : Number(input.value);
        const possible = value === null || value > 0;
        markField(input, possible ? null : "must be above 0");
        // A limit that cannot be leaves no answer to believe.
        if (possible) hear.limit(key, value);
        else {
          this.failed(new Error(`${name}: must be above 0; what is shown in grey is for the limits before`), this.leave);
          this.drop();
        }
      } });
      return { key, input, label: element("label", { class: "limit" }, element("span", {}, name), input) };
    });
    this.saves = element("div", { class: "row" });
    this.panel = element("section", { class: "panel answer", "aria-label": "Recommendation" },
      element("h2", {}, "Where to run it"), this.problem, this.said, this.table,
      element("details", {}, element("summary", {}, "Limits of the machine"), element("div", { class: "row" }, ...this.limits.map((one) => one.label))),
      element("div", { class: "row" }, this.more, this.saves), this.took, this.chart.figure);
    this.leave = new AbortController();
  }

  // Asks for the recommendation of a rig at a gap.
  ask(rig, gap_mm, limits, madeFrom) {
    this.leave.abort(new Error("another rig is asked for"));
    this.leave = new AbortController();
    Object.assign(this, { rig, gap_mm, limits_set: limits, madeFrom, began: performance.now() });
    for (const { key, input } of this.limits) if (document.activeElement !== input) input.value = limits[key] ?? "";
    this.panel.dataset.state = "asked";
    this.problem.textContent = "";
    this.took.textContent = "Computing …";
    this.panel.setAttribute("aria-busy", "true");
    const { leave } = this;
    this.first().then(() => !leave.signal.aborted && this.whole(true));
  }

  // What is under way is no longer wanted.
  drop() {
    this.leave.abort(new Error("a value is refused"));
    this.panel.setAttribute("aria-busy", "false");
  }

  async first() {
    const { leave } = this;
    try {
      const { value } = await this.pool.json("explore.pick_first", { rig: this.rig, gap_mm: this.gap_mm }, { order: 1, signal: leave.signal });
      if (leave.signal.aborted) return;
      const ms = performance.now() - this.began;
      this.panel.dataset.state = "first";
      this.panel.classList.remove("stale");
      this.panel.dataset.firstMs = Math.round(ms);
      const [low, high] = value.stable_one_one_ends.map((end) => ENDS[end]);
      // What was the former rig's is greyed until the second part has come.
      this.saves.replaceChildren();
      for (const part of [this.table, this.chart.figure]) part.classList.add("stale");
      this.said.replaceChildren(
        element("p", { class: "headline" }, element("strong", {}, `${digits(value.nominal_optimum_hz)} Hz`), ` · force ${digits(value.nominal_optimum_force_ratio)} times the weight (${digits(value.force_n)} N)`),
        element("p", {}, `There the hammer strikes once per drive period, most strongly (Ω/ω ${digits(value.frequency_ratio)}). This motion is stable from ${range(value.stable_one_one_hz)}: below, ${low}; above, ${high}.`));
      this.took.textContent = `First part after ${digits(ms / 1e3, 2)} s; looking for jumps, limits and settling …`;
      this.hear.found({ hz: value.nominal_optimum_hz, band_hz: value.band_hz, force_ratio: value.nominal_optimum_force_ratio });
    } catch (error) {
      this.failed(error, leave);
    }
  }

  async whole(nominal) {
    const { leave, limits_set: limits } = this;
    if (leave.signal.aborted) return;
    if (this.panel.dataset.state === "wrong" && nominal) return;
    if (!nominal) {
      this.took.textContent = "Computing the corners and 256 random rigs of the uncertainty; this may take a minute …";
      this.more.disabled = true;
      this.panel.setAttribute("aria-busy", "true");
    }
    const began = performance.now();
    try {
      const argument = { rig: this.rig, gap_mm: this.gap_mm, nominal, ...limits };
      const { value, ms } = await this.pool.json("explore.pick", argument, { order: 3, signal: leave.signal });
      if (leave.signal.aborted) return;
      this.show(value, nominal, ms, performance.now() - (nominal ? this.began : began));
    } catch (error) {
      this.failed(error, leave);
    } finally {
      this.more.disabled = false;
    }
  }

  failed(error, leave) {
    if (leave.signal.aborted) return;
    this.panel.dataset.state = "wrong";
    this.panel.setAttribute("aria-busy", "false");
    this.took.textContent = "";
    this.hear.found(null);
    this.problem.textContent = this.hear.inWords(error);
    this.panel.classList.add("stale");
  }

  show(value, nominal, ms, all) {
    this.chart.figure.hidden = false;
    for (const part of [this.table, this.chart.figure, this.panel]) part.classList.remove("stale");
    this.panel.dataset.state = nominal ? "nominal" : "whole";
    this.panel.setAttribute("aria-busy", "false");
    const [low, high] = value.stable_one_one_ends.map((end) => ENDS[end]);
    this.said.replaceChildren(
      element("p", { class: "headline" }, element("strong", {}, `${digits(value.operating_frequency_hz)} Hz`), ` · force ${digits(value.force_ratio)} times the weight (${digits(value.force_n)} N)`),
      element("p", {}, value.why));
    const binding = value.limits.filter((one) => one.binds).map((one) => one.name);
    const rows = [
      ["Safe band", range(value.safe_band_hz)],
      ["Frequency ratio Ω/ω", digits(value.frequency_ratio)],
      ["Stable 1/1", `${range(value.stable_one_one_hz)}: below, ${low}; above, ${high}`],
      ["Jumps", value.jump_range_hz ? `between ${range(value.jump_range_hz)}` : "none found"],
      ["From rest", value.regime_from_rest],
      ["Approach speed, contact time", `${digits(value.approach_speed_m_per_s, 3)} m/s, ${digits(value.contact_time_ms, 3)} ms`],
      ["Largest multiplier", digits(value.multipliers, 3)],
      ["Shaker", `${digits(value.shaker.force_n, 3)} N, stroke ${digits(value.shaker.stroke_mm, 3)} mm, ${digits(value.shaker.mean_power_w, 3)} W`],
      nominal ? null : ["Over the uncertainty", `force ${digits(value.force_ratio_worst, 3)} to ${digits(value.force_ratio_largest, 3)} times the weight; stable 1/1 for every rig from ${range(value.robust_band_hz)}`],
      binding.length ? ["Decided by", binding.join(", ")] : null,
    ];
    this.table.replaceChildren(element("table", {}, element("tbody", {}, ...rows.filter(Boolean).map(([name, said]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, said))))));
    this.took.textContent = nominal ? `For the rig as it stands, ${digits(all / 1e3, 2)} s after the question (${digits(ms / 1e3, 2)} s of computing).` : `With its uncertainty, ${digits(ms / 1e3, 2)} s of computing.`;
    const { curve, ...plain } = value;
    this.chart.draw({
      title: "Force of the stable 1/1", x: "drive frequency, Hz", y: "force over m g",
      description: `Largest at ${digits(value.nominal_optimum_hz)} Hz`,
      series: [{ label: "stable 1/1", colour: regimeColour("1/1"), kind: "line", points: curve },
        { label: "recommended", colour: "#D55E00", kind: "points", shape: "square", points: [[value.operating_frequency_hz, value.force_ratio]] }],
      bands: [{ from: value.safe_band_hz[0], to: value.safe_band_hz[1], colour: regimeColour("2/2") }],
    });
    this.saves.replaceChildren(
      element("span", {}, "Answer"), saveButtons({ name: "pick", madeFrom: this.madeFrom, value: () => plain }),
      element("span", {}, "Curve"), saveButtons({ name: "pick-curve", madeFrom: this.madeFrom, picture: () => this.chart.file(this.madeFrom()), rows: () => curve.map(([frequency_hz, force_ratio]) => ({ frequency_hz, force_ratio })) }));
    this.hear.found({ hz: value.operating_frequency_hz, band_hz: value.safe_band_hz, force_ratio: value.nominal_optimum_force_ratio });
  }
}
