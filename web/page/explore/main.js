// Explore: what the hammer does over gap and frequency, the motion at a point, and where to run it.
import { element, labelled } from "../common/dom.js";
import { markField } from "../common/fields.js";
import { Pool } from "../common/pool.js";
import { saveButtons } from "../common/save.js";
import { AnswerPanel } from "./answer.js";
import { Controls, DECIDES } from "./controls.js";
import { PlaneMap, frequencyAxis } from "./map.js";
import { mapFile } from "./mapfile.js";
import { MotionPanel } from "./motion.js";
import { fromFragment, initial, rigOf, toFragment } from "./state.js";
import { DETAILS } from "./tiles.js";

export async function start(container) {
  const pool = new Pool();
  const status = element("p", { role: "status", class: "note", id: "explore-status" }, "loading the computing part …");
  container.append(status);
  let state = fromFragment(location.hash);
  let choices;
  try {
    choices = (await pool.json("explore.choices", null)).value;
  } catch (error) {
    status.textContent = `This browser cannot run the page's computing part (it needs WebAssembly with 128-bit vectors, as every browser since 2023 has): ${error.message}`;
    status.classList.add("wrong");
    return;
  }

  let facts = null;
  let own = null;
  let due = null;
  let follows = false;
  let question = 0;
  const times = {};

  const madeFrom = () => ({
    program: "vibro-impact hammer, page", version: facts.version, address: toFragment(state),
    rig: { name: facts.name, parameters: facts.parameters, cart: state.cart }, gap_mm: state.gap_mm, frequency_ratio: state.ratio, start_a0: state.start,
    options: { map: { cycles: 300, recorded: 100, start: "rest" }, pick: { samples: 256, seed: 1, ...state.limits }, orbit: { cycles: 600, transient: 480 } },
  });
  // Browsers refuse an address that changes too often.
  let keeping = 0;
  const write = () => history.replaceState(null, "", toFragment(state));
  const keep = () => {
    clearTimeout(keeping);
    keeping = setTimeout(write, 120);
  };

  const map = new PlaneMap(pool, {
    point(ratio, gap) {
      Object.assign(state, { ratio, gap_mm: Number((gap * facts.amplitude_mm).toPrecision(6)), start: null });
      refresh({ rig: false });
    },
    view(view) {
      state.view = view;
      keep();
      along();
    },
    measured(what, ms) {
      times[what] ??= ms;
      status.textContent = `Map: ${Object.entries(times).map(([pass, took]) => `${pass} after ${(took / 1e3).toFixed(1)} s`).join(", ")}, on ${pool.count} workers.`;
      container.dataset[what] = Math.round(times[what]);
    },
    failed(error) {
      problem.textContent = `The map has gaps: ${controls.inWords(error.message)}`;
    },
  });
  // The force curve has the map's axis of frequency.
  function along() {
    const { factor, name } = frequencyAxis(state.units, facts);
    answer.along({ name, factor: factor / facts.natural_frequency_hz, range: state.view.x.map((ratio) => ratio * factor), chosen: state.ratio * facts.natural_frequency_hz });
  }
  const answer = new AnswerPanel(pool, {
    frequency: (hz) => showAt(hz / facts.natural_frequency_hz),
    found(best) {
      container.dataset.best = best ? best.hz : "";
      const ratio = (hz) => hz / facts.natural_frequency_hz;
      map.setMarks({ ...map.marks, best: best ? ratio(best.hz) : undefined, band: best?.band_hz.map(ratio) });
      if (best) map.setForce(best.force_ratio);
      bestHz = best?.hz ?? null;
      take.disabled = bestHz === null;
    },
    inWords: (error) => controls.refuse(error.message, null),
    limit(key, value) {
      if (value === null) delete state.limits[key];
      else state.limits[key] = value;
      refresh({ rig: false, point: false });
    },
  });
  let bestHz = null;
  let refused = false;
  let changed = null;
  const motion = new MotionPanel(pool, {
    start(section) {
      state.start = section;
      refresh({ rig: false, pick: false });
    },
    inWords: (error) => controls.inWords(error.message),
  });
  const controls = new Controls(choices, async (change) => {
    if (change.text != null) {
      // A file that cannot be read takes nothing's place.
      const bare = { ...rigOf({ ...state, source: change.source, text: change.text }), settings: [] };
      change.wrong = await pool.json("explore.rig", bare).then(() => undefined, (error) => `${controls.inWords(error.message)}. The rig before stays`);
    }
    if (change.wrong) {
      problem.textContent = change.wrong;
      return;
    }
    if (change.source !== undefined) Object.assign(state, { source: change.source, text: change.text, settings: {}, gap_mm: null, start: null, ratio: null });
    if (change.cart) state.cart = change.cart;
    if (change.reset) Object.assign(state, { settings: {}, gap_mm: own.parameters.gap_mm });
    if (change.key === "gap_mm") state.gap_mm = change.value;
    else if (change.key) {
      for (const other of change.without) delete state.settings[other];
      if (change.key === "contact_law") for (const key of Object.keys(state.settings)) if (key.startsWith("contact_")) delete state.settings[key];
      // Its own value is no setting, unless another that is set would decide it.
      const decided = DECIDES.includes(change.key) && DECIDES.some((one) => one in state.settings && one !== change.key);
      if (own.parameters[change.key] === change.value && !decided) delete state.settings[change.key];
      else state.settings[change.key] = change.value;
    }
    if (change.key) [state.start, changed] = [null, change.key];
    due = { rig: due?.rig || change.key !== "gap_mm" };
    if (!follows) follow();
  });
  // A slider in motion is followed as fast as the first part of the answer is computed: one question at a time, then the newest.
  async function follow() {
    follows = true;
    while (due) {
      const what = due;
      due = null;
      await refresh(what);
      await answer.told;
    }
    follows = false;
  }
  const problem = element("p", { class: "wrong", role: "alert", id: "problem" });
  // What stands on the page belongs to the rig before: it is greyed until an answer takes its place.
  const wrong = (error) => {
    refused = true;
    answer.drop();
    motion.drop();
    const inFile = state.text !== null && error.message.startsWith(state.source);
    const said = facts && !inFile ? controls.refuse(error.message, changed) : error.message;
    problem.textContent = facts ? `${said}. What is shown in grey is for the values before.` : said;
    for (const panel of [plane, motion.panel]) panel.classList.add("stale");
    answer.stale();
    take.disabled = true;
  };

  const button = (name, said, act) => element("button", { type: "button", "aria-label": said, title: said, onclick: act }, name);
  const look = () => {
    map.setLook(state);
    along();
  };
  // The motion from rest at a frequency and the gap that is set.
  const showAt = (ratio) => {
    Object.assign(state, { ratio, start: null });
    refresh({ rig: false, pick: false });
  };
  const detail = element("select", { id: "detail", onchange: () => { state.detail = detail.value; keep(); look(); } }, ...DETAILS.map((one) => element("option", { value: one }, one)));
  const units = element("select", { id: "units", onchange: () => { state.units = units.value; keep(); look(); } }, element("option", { value: "ratios" }, "Ω/ω, gap/A0"), element("option", { value: "absolute" }, "Hz, mm"));
  const colour = element("select", { id: "colour", onchange: () => { state.colour = colour.value; keep(); look(); } }, element("option", { value: "regime" }, "regime z = p/n"), element("option", { value: "force" }, "force of 1/1"));
  const take = element("button", { type: "button", id: "take", disabled: true, onclick: () => showAt(bestHz / facts.natural_frequency_hz) }, "Show the motion there");
  const frequency = element("input", { type: "number", id: "frequency", min: 0, step: "any", onchange: () => {
    const asked = Number(frequency.value);
    markField(frequency, asked > 0 ? null : "must be above 0");
    if (asked > 0) showAt(asked / facts.natural_frequency_hz);
  } });
  const link = element("button", { type: "button", id: "share", onclick: async () => {
    write();
    // The address of the program's own server has the secret in it that lets one command a board.
    const ownServer = ["127.0.0.1", "localhost", "[::1]"].includes(location.hostname);
    try {
      await navigator.clipboard.writeText(ownServer ? location.hash : location.href);
      shared.textContent = ownServer ? "The address from # on is copied; put behind the address of any copy of the page, it opens what you see." : "The address is copied; it opens what you see.";
    } catch {
      shared.textContent = `Copy the address ${ownServer ? "from # on " : ""}from the browser's bar; it opens what you see.`;
    }
  } }, "Share by address");
  const shared = element("span", { role: "status", class: "note" });
  const mapSaves = saveButtons({ name: "map", madeFrom, picture: () => mapFile(map, madeFrom()), rows: () => mapRows() });
  const mapRows = () => {
    const { plot } = map.space();
    return map.tiles.rows(map.view, plot.width, plot.height).map((row) => ({
      gap_mm: row.gap_ratio * facts.amplitude_mm, gap_ratio: row.gap_ratio, frequency_hz: row.frequency_ratio * facts.natural_frequency_hz, frequency_ratio: row.frequency_ratio,
      regime: row.regime, force_ratio: row.regime === "failed" ? null : row.force_n / facts.weight_n, force_n: row.regime === "failed" ? null : row.force_n, settling_cycles: row.settled_after,
    }));
  };

  const plane = element("section", { class: "panel map", "aria-label": "Force curve and map" },
    answer.chart.figure,
    element("div", { class: "row" }, element("h2", {}, "What it does"), labelled("Axes ", units), labelled("Colour ", colour), labelled("Detail ", detail),
      element("span", { class: "row" }, button("+", "zoom in", () => map.zoom(0.7)), button("\u2212", "zoom out", () => map.zoom(1 / 0.7)), button("⌂", "show the whole plane", () => map.home()))),
    map.box, map.progress, map.said, map.legend,
    element("div", { class: "row" }, take, labelled("Drive frequency, Hz ", frequency), link, shared, mapSaves), status);
  const visit = element("p", { class: "note" }, "Choose a rig, move its parameters, or drop a rig file: the answer says at which frequency the hammer strikes hardest, how hard, and how far the frequency may be off. The curve shows the force over the frequency, the map below it what the hammer does at every frequency and gap. Click into either, and you see the motion there.");

  // Shows the state: the rig, its map, the recommendation and the motion at the point.
  async function refresh({ rig = true, pick = true, point = true } = {}) {
    // Behind a refusal nothing that stands there holds.
    if (refused) [rig, pick, point] = [true, true, true];
    question += 1;
    const mine = question;
    keep();
    if (rig) {
      let found;
      try {
        const bare = { ...rigOf(state), settings: [] };
        const [first, now] = await Promise.all([pool.json("explore.rig", bare), pool.json("explore.rig", rigOf(state))]);
        [own, found] = [first.value, now.value];
      } catch (error) {
        if (mine === question) wrong(error);
        return;
      }
      if (mine !== question) return;
      refused = false;
      state.gap_mm ??= own.parameters.gap_mm;
      keep();
      const fresh = JSON.stringify(rigOf(state)) !== map.shows;
      map.shows = JSON.stringify(rigOf(state));
      facts = found;
      if (fresh) {
        for (const name of Object.keys(times)) delete times[name];
        for (const name of DETAILS) delete container.dataset[name];
        map.setRig(rigOf(state), facts, state.view);
      }
    }
    problem.textContent = "";
    controls.accept();
    for (const panel of [plane, motion.panel]) panel.classList.remove("stale");
    // The recommendation that stands there is for the values before until the new one comes.
    if (rig || pick) answer.stale();
    take.disabled = bestHz === null;
    controls.show(state, own.parameters, { ...facts.parameters, gap_mm: state.gap_mm }, facts.meanings, facts.shaker_known);
    controls.notes.replaceChildren(...facts.notes.map((note) => element("p", { class: "wrong" }, controls.inWords(note))),
      element("p", {}, `Natural frequency ${facts.natural_frequency_hz.toPrecision(5)} Hz, weight ${facts.weight_n.toPrecision(4)} N. `, saveButtons({ name: "rig", madeFrom, value: () => ({ parameters: facts.parameters, toml: facts.toml }) })));
    const gap = state.gap_mm / facts.amplitude_mm;
    map.setMarks({ ...map.marks, gap, point: state.ratio === null ? undefined : [state.ratio, gap] });
    along();
    if (state.ratio !== null && document.activeElement !== frequency) frequency.value = Number((state.ratio * facts.natural_frequency_hz).toPrecision(7));
    if (pick) answer.ask(rigOf(state), state.gap_mm, state.limits, madeFrom);
    if (point && state.ratio !== null) motion.ask(rigOf(state), state.gap_mm, state.ratio * facts.natural_frequency_hz, state.start, madeFrom);
  }

  addEventListener("hashchange", () => {
    if (location.hash.startsWith("#explore?") && location.hash !== toFragment(state)) open(fromFragment(location.hash));
  });
  function open(wanted) {
    state = wanted;
    [units.value, colour.value, detail.value] = [state.units, state.colour, state.detail];
    if (map.view) map.view = state.view;
    map.setLook(state);
    refresh().then(() => map.redraw(true));
  }
  [units.value, colour.value, detail.value] = [state.units, state.colour, state.detail];
  Object.assign(map, { units: state.units, colour: state.colour, detail: state.detail });
  await refresh();
  if (!facts) {
    // The rig in the address cannot be read: say so, and show what there always is.
    const said = problem.textContent;
    state = initial();
    await refresh();
    problem.textContent = said;
  }
  // Only now, so that nothing is pushed about while the page fills.
  container.replaceChildren(visit, problem, element("div", { class: "explore-grid" }, answer.panel, plane, controls.panel, answer.beside, motion.panel));
}
