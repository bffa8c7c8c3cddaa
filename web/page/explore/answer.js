// The recommendation: first where the rig as it stands is strongest, then the whole pick, and on request with the
// uncertainty of the parameters.
import { Chart, MARGIN } from "../common/chart.js";
import { regimeColour } from "../common/colours.js";
import { element } from "../common/dom.js";
import { markField } from "../common/fields.js";
import { digits } from "../common/numbers.js";
import { saveButtons } from "../common/save.js";

// The whole pick is begun when nothing else was asked for so long, ms.
const REST = 250;

// In words what ends the stable 1/1.
const ENDS = {
  period_doubling: "its period doubles", extra_contact: "a second contact appears", fold: "it folds, and the hammer jumps",
  search_limit: "the search stopped", contact_at_section: "a contact lasts over drive phase 0",
};

const LIMITS = [["max_force_n", "largest force, N"], ["max_frequency_hz", "highest frequency, Hz"], ["max_shaker_force_n", "largest shaker force, N"]];

const range = ([low, high]) => `${digits(low)} to ${digits(high)} Hz`;

export class AnswerPanel {
  constructor(pool, hear) {
    this.pool = pool;
    this.hear = hear;
    this.said = element("div", { role: "status", "aria-live": "polite", id: "answer" });
    this.problem = element("p", { class: "wrong", role: "alert", id: "no-answer" });
    this.table = element("div", { class: "scroll" });
    this.more = element("button", { type: "button", id: "uncertain", onclick: () => this.whole(false) }, "With the uncertainty of the parameters");
    this.took = element("p", { class: "note", id: "took" });
    // The curve stands above the map and has its axis of frequency: see `along`.
    this.chart = new Chart({ height: 230, label: "force of the stable 1/1 over frequency" });
    this.chart.picture.addEventListener("click", (event) => this.choose(event));
    this.drawn = { curve: [], best: [], bands: [] };
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
      element("h2", {}, "Where to run it"), this.problem, this.said);
    this.beside = element("section", { class: "panel beside", "aria-label": "About this answer" },
      element("h2", {}, "About this answer"), this.took, this.more, this.table,
      element("details", {}, element("summary", {}, "Limits of the machine"), ...this.limits.map((one) => one.label)), this.saves);
    this.tell({});
    this.leave = new AbortController();
  }

  // Greys what stands there, as it is for the values before; false takes the grey away.
  stale(is = true) {
    for (const part of [this.panel, this.beside, this.chart.figure]) part.classList.toggle("stale", is);
  }

  // Draws the curve along an axis: the range on it, the factor from Hz, its name; `chosen` is the frequency of the motion that is shown, Hz.
  along(axis) {
    this.axis = axis;
    const { curve, best, bands } = this.drawn;
    const x = (hz) => hz * axis.factor;
    const points = (list) => list.map(([hz, force]) => [x(hz), force]);
    this.chart.draw({
      title: "Force of the stable 1/1", x: axis.name, y: "force over m g", left: MARGIN.left,
      description: best.length ? `${digits(best[0][1])} times the weight at ${digits(best[0][0])} Hz; safe from ${range(bands[0])}` : "",
      rangeX: axis.range, rangeY: [0, 1.1 * Math.max(...curve.map(([, force]) => force), 0) || 1],
      series: [{ label: "stable 1/1", colour: regimeColour("1/1"), kind: "line", points: points(curve) },
        { label: "recommended", colour: "#D55E00", kind: "points", shape: "square", points: points(best) }],
      bands: bands.map(([from, to]) => ({ label: "safe band", from: x(from), to: x(to), colour: regimeColour("2/2") })),
      posts: axis.chosen ? [x(axis.chosen)] : [],
    });
  }

  // The frequency that was clicked on the curve.
  choose(event) {
    const { left } = this.chart.picture.getBoundingClientRect();
    const { x, plot } = this.chart.space;
    const at = event.clientX - left;
    if (at >= plot.left && at <= plot.left + plot.width) this.hear.frequency(x.back(at) / this.axis.factor);
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
    this.told = this.first();
    // The whole takes seconds: not for every step of a slider.
    this.told.then(() => setTimeout(() => !leave.signal.aborted && this.whole(true), REST));
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
      this.stale(false);
      this.panel.dataset.firstMs = Math.round(ms);
      this.saves.replaceChildren();
      this.headline(value.nominal_optimum_hz, value.nominal_optimum_force_ratio, value.force_n, value.band_hz,
        "There the hammer strikes once in each drive period, as hard as it can; looking for jumps, limits and settling …");
      this.tell({ ...value, safe_band_hz: value.band_hz });
      this.plot(value.curve, [value.nominal_optimum_hz, value.nominal_optimum_force_ratio], value.band_hz);
      this.took.textContent = `First part ${digits(ms / 1e3, 2)} s after the question.`;
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
    this.stale();
  }

  headline(hz, ratio, force_n, band_hz, why) {
    this.said.replaceChildren(
      element("p", { class: "headline" }, element("strong", {}, `${digits(hz)} Hz`), ` · force ${digits(ratio)} times the weight (${digits(force_n)} N) · safe band ${range(band_hz)}`),
      element("p", {}, why));
  }

  plot(curve, best, band_hz) {
    this.drawn = { curve, best: [best], bands: [band_hz] };
    this.along(this.axis);
  }

  // What is known of the answer as a table; what is not yet known keeps its line.
  tell(value, nominal = true) {
    const know = (key, say) => (value[key] === undefined ? "…" : say(value[key]));
    const [low, high] = value.stable_one_one_ends?.map((end) => ENDS[end]) ?? [];
    const binding = value.limits?.filter((one) => one.binds).map((one) => one.name) ?? [];
    const rows = [
      ["Safe band", know("safe_band_hz", range)],
      ["Frequency ratio Ω/ω", know("frequency_ratio", digits)],
      ["Stable 1/1", know("stable_one_one_hz", (hz) => `${range(hz)}: below, ${low}; above, ${high}`)],
      ["Jumps", know("jump_range_hz", (hz) => (hz ? `between ${range(hz)}` : "none found"))],
      ["From rest", know("regime_from_rest", String)],
      ["Approach speed, contact time", know("contact_time_ms", (ms) => `${digits(value.approach_speed_m_per_s, 3)} m/s, ${digits(ms, 3)} ms`)],
      ["Largest multiplier", know("multipliers", (modulus) => digits(modulus, 3))],
      ["Shaker", know("shaker", (shaker) => `${digits(shaker.force_n, 3)} N, stroke ${digits(shaker.stroke_mm, 3)} mm, ${digits(shaker.mean_power_w, 3)} W`)],
      nominal ? null : ["Over the uncertainty", `force ${digits(value.force_ratio_worst, 3)} to ${digits(value.force_ratio_largest, 3)} times the weight; stable 1/1 for every rig from ${range(value.robust_band_hz)}`],
      binding.length ? ["Decided by", binding.join(", ")] : null,
    ];
    this.table.replaceChildren(element("table", {}, element("tbody", {}, ...rows.filter(Boolean).map(([name, said]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, said))))));
  }

  show(value, nominal, ms, all) {
    this.stale(false);
    this.panel.dataset.state = nominal ? "nominal" : "whole";
    this.panel.setAttribute("aria-busy", "false");
    this.headline(value.operating_frequency_hz, value.force_ratio, value.force_n, value.safe_band_hz, value.why);
    this.tell(value, nominal);
    this.took.textContent = nominal ? `For the rig as it stands, ${digits(all / 1e3, 2)} s after the question (${digits(ms / 1e3, 2)} s of computing).` : `With its uncertainty, ${digits(ms / 1e3, 2)} s of computing.`;
    const { curve, ...plain } = value;
    this.plot(curve, [value.operating_frequency_hz, value.force_ratio], value.safe_band_hz);
    this.saves.replaceChildren(
      element("span", {}, "Save the answer"), saveButtons({ name: "pick", madeFrom: this.madeFrom, value: () => plain }),
      element("span", {}, "and its curve"), saveButtons({ name: "pick-curve", madeFrom: this.madeFrom, picture: () => this.chart.file(this.madeFrom()), rows: () => curve.map(([frequency_hz, force_ratio]) => ({ frequency_hz, force_ratio })) }));
    this.hear.found({ hz: value.operating_frequency_hz, band_hz: value.safe_band_hz, force_ratio: value.nominal_optimum_force_ratio });
  }
}
