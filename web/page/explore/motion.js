// The motion at a point of the plane: over time, in the phase plane, on the section, its force and its multipliers, and the
// motions that exist beside it.
import { Chart } from "../common/chart.js";
import { SERIES, regimeColour } from "../common/colours.js";
import { element } from "../common/dom.js";
import { around, digits } from "../common/numbers.js";
import { saveButtons } from "../common/save.js";

const STABILITY = { stable: "stable: a small disturbance dies away", neutral: "neutral: nothing takes energy", unstable: "unstable" };

function complex([re, im]) {
  return im === 0 ? digits(re, 4) : `${digits(re, 4)} ${im < 0 ? "\u2212" : "+"} ${digits(Math.abs(im), 4)} i`;
}

export class MotionPanel {
  constructor(pool, hear) {
    this.pool = pool;
    this.hear = hear;
    this.said = element("div", { role: "status", "aria-live": "polite", id: "motion" }, element("p", {}, "Choose a point of the map, or take the recommended one."));
    this.table = element("div", { class: "scroll" });
    this.others = element("div", { class: "scroll", id: "others" });
    const charts = { time: 250, force: 250, phase: 300, section: 300, multipliers: 300 };
    this.charts = Object.fromEntries(Object.entries(charts).map(([name, height]) => [name, new Chart({ height, label: name })]));
    this.saves = element("div", { class: "row" });
    this.panel = element("section", { class: "panel motion", "aria-label": "Motion at a point" },
      element("h2", {}, "The motion at a point"), this.said, this.table, this.saves,
      element("div", { class: "charts", hidden: true }, ...Object.values(this.charts).map((chart) => chart.figure)),
      element("h3", {}, "Motions from other starts"), this.others);
    this.leave = new AbortController();
  }

  // Shows the motion at a point; `start` is a point of the section (A0, A0 Ω), null for rest.
  ask(rig, gap_mm, frequency_hz, start, madeFrom, again = false) {
    this.leave.abort(new Error("another point is asked for"));
    this.leave = new AbortController();
    this.madeFrom = madeFrom;
    this.panel.dataset.state = "asked";
    this.panel.setAttribute("aria-busy", "true");
    const point = { rig, gap_mm, frequency_hz };
    this.orbit({ ...point, start });
    const key = JSON.stringify(point);
    if (again || key !== this.around) {
      this.around = key;
      this.neighbours(point);
    } else this.list();
  }

  // What is under way is no longer wanted.
  drop() {
    this.leave.abort(new Error("the rig is refused"));
    this.panel.setAttribute("aria-busy", "false");
  }

  async orbit(argument) {
    const { leave } = this;
    try {
      const { value, ms } = await this.pool.json("explore.orbit", argument, { order: 0, signal: leave.signal });
      if (!leave.signal.aborted) this.show(argument, value, ms);
    } catch (error) {
      if (leave.signal.aborted) return;
      this.panel.dataset.state = "wrong";
      this.panel.setAttribute("aria-busy", "false");
      this.said.replaceChildren(element("p", { class: "wrong" }, this.hear.inWords(error)));
      this.table.replaceChildren();
      this.panel.querySelector(".charts").hidden = true;
    }
  }

  show(argument, value, ms) {
    this.panel.dataset.state = "shown";
    this.panel.setAttribute("aria-busy", "false");
    this.panel.querySelector(".charts").hidden = false;
    const { orbit } = value;
    const from = argument.start ? "from a point of the section" : "from rest";
    this.said.replaceChildren(element("p", { class: "headline" },
      element("strong", {}, value.regime), ` at ${digits(value.frequency_hz)} Hz (Ω/ω ${digits(value.frequency_ratio)}), gap ${digits(value.gap_mm, 3)} mm, ${from}`));
    const rows = [
      ["Largest force", value.force_n > 0 ? `${digits(value.force_ratio)} times the weight (${digits(value.force_n)} N)` : "no contact"],
      ["Approach speed", value.approach_speed_m_per_s === null ? "–" : `${digits(value.approach_speed_m_per_s)} m/s`],
      ["Contact time", value.contact_time_ms === null ? "–" : `${digits(value.contact_time_ms)} ms`],
      ["Energy per blow, impulse", value.impulse_n_s === null ? "–" : `${digits(value.energy_per_blow_j, 3)} J, ${digits(value.impulse_n_s, 3)} N·s`],
      ["Multipliers", orbit ? `${orbit.multipliers.map(complex).join(" and ")}; modulus ${digits(orbit.modulus, 4)}` : "the motion does not repeat, or touches nothing"],
      orbit ? ["Stability", STABILITY[orbit.stability]] : null,
    ];
    this.table.replaceChildren(element("table", {}, element("tbody", {}, ...rows.filter(Boolean).map(([name, said]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, said))))),
      element("p", { class: "note" }, `600 drive periods from the start, the last 120 judged; ${Math.round(ms)} ms.`));
    this.draw(value);
    const { history, section, contacts, ...plain } = value;
    const tables = { "time-history": history, section, contacts };
    const pictures = { "time-history": "time", force: "force", "phase-plane": "phase", section: "section", multipliers: "multipliers" };
    this.saves.replaceChildren(
      ...Object.entries(pictures).map(([name, chart]) => element("span", {}, `${name} `, saveButtons({ name, madeFrom: this.madeFrom, picture: () => this.charts[chart].file(this.madeFrom()), rows: tables[name] && (() => tables[name]) }))),
      element("span", {}, "contacts ", saveButtons({ name: "contacts", madeFrom: this.madeFrom, rows: () => contacts })),
      element("span", {}, "numbers ", saveButtons({ name: "motion", madeFrom: this.madeFrom, value: () => plain })));
  }

  draw({ history, section, orbit, frequency_hz, regime, gap_mm }) {
    const began = history[0].time_s;
    const periods = (row) => (row.time_s - began) * frequency_hz;
    const colour = regimeColour(regime === "none" ? "aperiodic" : regime);
    const [time, force, phase] = [this.charts.time, this.charts.force, this.charts.phase];
    time.draw({
      title: "Displacement", x: "time, drive periods", y: "displacement, mm", tight: true,
      description: "Hammer relative to the cart and in the fixed frame; the dashed line is the impact surface",
      series: [{ label: "hammer relative to the cart", colour: SERIES[0], kind: "line", points: history.map((row) => [periods(row), row.relative_displacement_mm]) },
        { label: "hammer in the fixed frame", colour: SERIES[4], kind: "line", dash: "5 3", points: history.map((row) => [periods(row), row.displacement_mm]) }],
      lines: [{ at: gap_mm }],
    });
    force.draw({ title: "Contact force", x: "time, drive periods", y: "force, N", tight: true, series: [{ colour: SERIES[1], kind: "line", points: history.map((row) => [periods(row), row.force_n]) }] });
    phase.draw({
      title: "Phase plane", x: "relative displacement, mm", y: "relative velocity, m/s",
      series: [{ colour, kind: "line", points: history.map((row) => [row.relative_displacement_mm, row.relative_velocity_m_per_s]) },
        { label: "drive phase 0", colour: SERIES[1], kind: "points", shape: "square", points: section.slice(-16).map((row) => [row.relative_displacement_mm, row.relative_velocity_m_per_s]) }],
    });
    const [phaseX, phaseY] = ["relative_displacement_mm", "relative_velocity_m_per_s"].map((name) => around(history.map((row) => row[name])));
    this.charts.section.draw({
      title: "Section at drive phase 0", x: "relative displacement, mm", y: "relative velocity, m/s", description: "The last 120 drive periods",
      // A motion that repeats is a point: the digits in which it still settles are not shown at large.
      least: [0.02 * (phaseX[1] - phaseX[0]), 0.02 * (phaseY[1] - phaseY[0])],
      series: [{ label: "last 120 periods", colour, kind: "points", points: section.map((row) => [row.relative_displacement_mm, row.relative_velocity_m_per_s]) }],
    });
    const far = Math.max(1.25, ...(orbit?.multipliers ?? []).map(([re, im]) => 1.1 * Math.hypot(re, im)));
    this.charts.multipliers.figure.hidden = !orbit;
    this.charts.multipliers.draw({
      title: "Multipliers", x: "real part", y: "imaginary part", rangeX: [-far, far], rangeY: [-far, far], equal: true,
      description: orbit ? `Modulus ${digits(orbit.modulus)}; inside the dashed circle the motion is stable` : "",
      series: [{ label: "multiplier; stable inside the circle", colour: SERIES[0], kind: "points", shape: "ring", points: orbit?.multipliers ?? [] }],
      circles: [{ radius: 1 }],
    });
  }

  async neighbours(argument) {
    const { leave } = this;
    this.others.replaceChildren(element("p", { class: "note" }, "computing …"));
    this.others.dataset.state = "asked";
    this.found = null;
    try {
      const { value, ms } = await this.pool.json("explore.neighbours", argument, { order: 3, signal: leave.signal });
      if (leave.signal.aborted) return;
      this.found = { value, ms };
      this.list();
    } catch (error) {
      if (!leave.signal.aborted) this.others.replaceChildren(element("p", { class: "wrong" }, this.hear.inWords(error)));
      if (this.around === JSON.stringify(argument)) this.around = null;
    }
  }

  list() {
    if (!this.found) return;
    const { value, ms } = this.found;
    const heads = ["Motion", "Share of starts", "Force over m g", "Largest multiplier", ""];
    const row = (one) => element("tr", {},
      element("th", { scope: "row" }, element("span", { class: "chip", style: `background: ${regimeColour(one.name.split(" ")[0])}` }), one.name),
      element("td", {}, `${digits(100 * one.share, 3)} %`), element("td", {}, digits(one.force_ratio)), element("td", {}, one.orbit ? digits(one.orbit.modulus, 3) : "–"),
      element("td", {}, one.section_middle ? element("button", { type: "button", "aria-label": `show the motion ${one.name}`, onclick: () => this.hear.start(one.section_middle) }, "show") : ""));
    const [columns, rows] = value.starts;
    this.others.dataset.state = "shown";
    this.others.replaceChildren(
      element("table", {}, element("thead", {}, element("tr", {}, ...heads.map((head) => element("th", { scope: "col" }, head)))), element("tbody", {}, ...value.motions.map(row))),
      element("p", { class: "note" }, `${columns} × ${rows} starts over ${value.displacement_mm.map((x) => digits(x, 3)).join(" to ")} mm and ${value.velocity_m_per_s.map((x) => digits(x, 3)).join(" to ")} m/s, ${value.cycles} periods each; ${Math.round(ms)} ms. `,
        element("button", { type: "button", onclick: () => this.hear.start(null) }, "from rest again")));
  }
}
