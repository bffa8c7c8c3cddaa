// What is seen of a board and what steers it: state, limits, faults, scope, force and phase per blow, spectrum; start, stop, set-points,
// settings, recording. The same for a board on a port and for the emulated one.
import { Chart } from "../common/chart.js";
import { element } from "../common/dom.js";
import { digits } from "../common/numbers.js";
import { SERIES } from "../common/colours.js";
import { Picture } from "./picture.js";
import { Scope } from "./scope.js";
import { SettingsForm } from "./settings.js";

// How many events are kept.
const MARKS = 60;

// How often the pictures are drawn, ms.
const DRAW = 120;
const SPECTRUM = 700;

const SIGNALS = [["force", "N", 2000], ["hammer", "mm", 60], ["cart", "mm", 60]];

// What is measured of a drive: once it is off, it is from before.
const OF_A_DRIVE = new Set(["limited by", "drive frequency", "cart amplitude", "regime", "peak force", "impulse per blow", "basin"]);

// The number in a field; an empty one is none.
function number(input, name) {
  if (input.value.trim() === "") throw new Error(`${name}: write a number`);
  return Number(input.value);
}

// A number field with its unit.
function field(label, unit, attributes) {
  const input = element("input", { type: "number", step: "any", size: 8, ...attributes });
  return { input, node: element("label", { class: "field" }, `${label}, ${unit} `, input) };
}

export class View {
  // `name` is what recordings are called; `tells`: changes of state are marked here, as nobody else tells what happens.
  constructor(container, { name, tells = false }) {
    Object.assign(this, { name, tells, marks: [] });
    this.board = null;
    this.status = null;
    this.heard = {};
    this.build(container);
    setInterval(() => this.drawScope(), DRAW);
    setInterval(() => this.drawSpectrum(), SPECTRUM);
    // Escape stops, wherever the focus is: on every part of the page while the drive runs, and here in any state.
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.board && (this.drives || container.offsetParent !== null)) this.stop();
    });
    this.enable();
  }

  build(container) {
    this.buildControls();
    this.facts = element("table", { class: "facts" });
    this.said = element("p", { role: "status", class: "said" });
    this.wrong = element("p", { role: "alert", class: "wrong" });
    this.gaps = element("p", { class: "note gaps" });
    this.scope = new Scope();
    this.lines = element("ol", { class: "timeline", "aria-label": "what happened", tabindex: "0" });
    this.settings = new SettingsForm();
    this.picture = new Picture((seconds, columns) => this.board.trace(seconds, columns), () => this.board && this.panel.offsetParent !== null);
    this.seconds = element("select", { onchange: () => this.drawScope() },
      ...[0.5, 1, 2, 5, 10].map((s) => element("option", { value: s, selected: s === 2 }, `${s} s`)));
    this.force = new Chart({ height: 200, label: "force per blow" });
    this.phase = new Chart({ height: 200, label: "phase of the blow" });
    this.spectrum = new Chart({ height: 220, label: "spectrum" });
    this.signal = element("select", { onchange: () => this.drawSpectrum() },
      ...SIGNALS.map(([label], at) => element("option", { value: at }, label)));
    this.panel = element("div", { class: "live" },
      this.controls, this.said, this.wrong,
      element("div", { class: "live-grid" },
        element("section", { class: "panel", "aria-label": "state" }, element("h2", {}, "State"), element("div", { class: "scroll" }, this.facts), this.gaps),
        element("section", { class: "panel wide", "aria-label": "scope" },
          element("div", { class: "row" }, element("h2", {}, "Scope"), element("label", {}, "shows ", this.seconds)), this.picture.figure, this.scope.figure, this.lines),
        element("section", { class: "panel", "aria-label": "blows" }, element("h2", {}, "Blow by blow"), this.force.figure, this.phase.figure),
        element("section", { class: "panel", "aria-label": "spectrum" },
          element("div", { class: "row" }, element("h2", {}, "Spectrum"), element("label", {}, "of ", this.signal)), this.spectrum.figure),
        this.buildRecording(),
        this.settings.node,
      ));
    container.append(this.panel);
  }

  buildControls() {
    const button = (text, act, extra) => element("button", { type: "button", onclick: () => this.attempt(act), ...extra }, text);
    this.stopButton = element("button", { type: "button", class: "stop", onclick: () => this.stop(), title: "Escape does the same" }, "Stop");
    this.start = button("Start", () => this.board.ask({ kind: "start", manual: false }));
    this.manual = button("Start by hand", () => this.board.ask({ kind: "start", manual: true }));
    this.clear = button("Clear the fault", () => this.board.ask({ kind: "clear-fault" }));
    this.hz = field("Frequency", "Hz", { min: 0.1, value: 3 });
    this.mm = field("Amplitude", "mm", { min: 0, value: 0.5 });
    this.set = button("Set", () => this.board.ask({
      kind: "set-point", frequency_hz: number(this.hz.input, "Frequency"), amplitude_mm: number(this.mm.input, "Amplitude"),
    }).then(() => `asked for ${this.hz.input.value} Hz and ${this.mm.input.value} mm; what a limit holds back stands under "limited by"`));
    this.controls = element("div", { class: "controls row" }, this.stopButton, this.start, this.manual, this.hz.node, this.mm.node, this.set, this.clear);
  }

  buildRecording() {
    this.record = element("button", { type: "button", onclick: () => this.attempt(() => this.beginRecording()) }, "Record");
    this.save = element("button", { type: "button", onclick: () => this.attempt(() => this.endRecording()) }, "End and save");
    this.recorded = element("p", { class: "note" });
    return element("section", { class: "panel", "aria-label": "recording" }, element("h2", {}, "Recording"),
      element("div", { class: "row" }, this.record, this.save), this.recorded,
      element("p", { class: "note" }, "Begins in idle: the controller is restarted with its own settings, so that ",
        element("code", {}, "host-sim replay"), " can begin there. ", element("code", {}, "host-sim compare"), " reads it, too."));
  }

  // Shows `board` from now on; null: none, and what is still seen is no longer so. Nor is it once nothing has been heard for
  // `silent` ms.
  show(board, silent = Infinity) {
    this.board = board;
    this.silent = silent;
    this.heardAt = performance.now();
    this.status = null;
    this.heard = {};
    this.tellAge();
    if (board) {
      board.onheard = (heard) => this.take(heard);
      this.settings.show(board);
    }
    this.tellDrive();
    this.enable();
  }

  // Greys what is no longer known.
  tellAge() {
    this.panel.dataset.stale = String(!this.board || performance.now() - this.heardAt > this.silent);
  }

  // Something happened at a time of the board's: it is on the scope and in the list below.
  mark(time_s, text) {
    const said = text.replaceAll("->", "→");
    this.marks = [...this.marks.slice(1 - MARKS), { time_s, text: said }];
    this.lines.prepend(element("li", {}, `${digits(time_s, 5)} s: ${said}`));
    while (this.lines.children.length > MARKS) this.lines.lastChild.remove();
  }

  // Another board or run: nothing has happened yet.
  forget() {
    this.marks = [];
    this.lines.replaceChildren();
  }

  take(heard) {
    this.heardAt = performance.now();
    if (heard.status) {
      const { state, fault, time_s } = heard.status;
      if (this.tells && this.status && state !== this.status.state) this.mark(time_s, `${this.status.state} -> ${state}${fault ? `: ${fault.name}` : ""}`);
      this.status = heard.status;
      this.tellDrive();
    }
    this.heard = heard;
    this.dirty = true;
  }

  // Tells the frame of the page when a drive begins or ends.
  tellDrive() {
    const drives = Boolean(this.status) && !["idle", "fault"].includes(this.status.state);
    if (drives === this.drives) return;
    this.drives = drives;
    this.panel.dispatchEvent(new CustomEvent("drive", { bubbles: true, detail: { drives, stop: () => this.stop() } }));
  }

  // Does something that may be refused, and says what came of it.
  async attempt(act) {
    this.wrong.textContent = "";
    try {
      const done = await act();
      this.said.textContent = typeof done === "string" ? done : "";
    } catch (error) {
      this.wrong.textContent = error.message;
    }
    this.enable();
  }

  stop() {
    this.attempt(async () => {
      await this.board.stop();
      return "stop: the drive ramps down";
    });
  }

  async beginRecording() {
    if (this.status?.state !== "idle") throw new Error("a recording begins in idle, so that it can be replayed: stop first");
    this.board.record({ command: `the page, ${this.name}`, at: new Date().toISOString() });
    await this.board.ask({ kind: "set-settings", toml: "" });
    this.recording = true;
    return "recording";
  }

  async endRecording() {
    this.recording = false;
    const bytes = this.board.recording();
    const link = element("a", {
      href: URL.createObjectURL(new Blob([bytes], { type: "application/vnd.apache.parquet" })), download: `${this.name}.parquet`,
    });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    return `saved ${this.name}.parquet: host-sim replay ${this.name}.parquet`;
  }

  // What can be done now.
  enable() {
    const commands = Boolean(this.board?.commands);
    const state = this.status?.state;
    this.stopButton.disabled = !this.board;
    this.start.disabled = !(commands && state === "idle");
    this.manual.disabled = !(commands && state === "idle");
    this.set.disabled = !(commands && ["manual", "prove", "ramp", "self-test"].includes(state));
    this.clear.disabled = !(commands && state === "fault");
    this.settings.enable(this.board, commands && ["idle", "fault"].includes(state));
    this.record.disabled = !(commands && state === "idle" && !this.recording);
    this.save.disabled = !(this.board && this.recording);
  }

  drawScope() {
    this.tellAge();
    if (!this.board || !this.dirty || this.panel.offsetParent === null) return;
    this.dirty = false;
    this.enable();
    this.drawFacts();
    this.scope.draw(this.board.trace(Number(this.seconds.value), this.scope.columns()), this.marks);
    this.picture.play();
    const blows = this.board.blows().slice(-60);
    const draw = (chart, title, y, value, colour) => chart.draw({
      title, x: "board's time, s", y, description: `${blows.length} blows`,
      series: [{ points: blows.filter((blow) => value(blow) !== null).map((blow) => [blow.time_s, value(blow)]), colour, kind: "points" }],
    });
    draw(this.force, "Peak force per blow, as the sensor reads it", "force, N", (blow) => blow.peak_n, SERIES[0]);
    draw(this.phase, "Phase of the cart's motion at the blow", "phase, degrees", (blow) => blow.phase_deg, SERIES[1]);
  }

  drawSpectrum() {
    if (!this.board || this.panel.offsetParent === null) return;
    const [label, unit, highest] = SIGNALS[Number(this.signal.value)];
    const [step, ...values] = this.board.spectrum(Number(this.signal.value), highest);
    const points = values.map((value, at) => [at * step, value]);
    this.spectrum.draw({
      title: values.length ? `Spectrum of the ${label}, last 3.3 s` : "Spectrum: 3.3 s without a gap are needed",
      x: "frequency, Hz", y: `amplitude, ${unit}`,
      series: [{ points: thinned(points, 800), colour: SERIES[2], kind: "line" }],
    });
  }

  drawFacts() {
    const s = this.status;
    if (!s) return;
    const fault = s.fault ? `${s.fault.code} ${s.fault.name}` : "none";
    const rows = [
      ["state", s.state],
      ["fault", fault],
      ["limited by", s.limits.join(", ") || "nothing"],
      ["drive frequency", `${digits(s.frequency_hz, 5)} Hz`],
      ["cart amplitude", `${digits(s.measured_amplitude_mm)} mm of ${digits(s.amplitude_mm)} mm`],
      ["regime", s.regime],
      ["peak force", `${digits(s.peak_n)} N`],
      ["impulse per blow", `${digits(s.impulse_n_s)} N·s`],
      ["target", s.target_hz > 0 ? `${digits(s.target_hz, 5)} Hz, ${digits(s.target_n)} N` : "none yet"],
      ["basin", s.basin],
      ["overruns", String(s.overruns)],
      ["board's time", `${digits(s.time_s, 6)} s`],
    ];
    this.facts.dataset.state = s.state;
    const look = (name) => (name === "fault" && s.fault ? "wrong" : !this.drives && OF_A_DRIVE.has(name) ? "old" : null);
    const title = (name) => (look(name) === "old" ? "from when the drive was last on" : null);
    this.facts.replaceChildren(...rows.map(([name, value]) => element("tr", { class: look(name), title: title(name) },
      element("th", { scope: "row" }, name), element("td", {}, value))));
    const h = this.heard;
    this.gaps.textContent = h.lost || h.gaps
      ? `lost: ${h.lost} messages; ${h.gaps} gaps with ${h.lost_ticks} ticks (${digits(h.lost_ticks / 20000)} s) on the scope`
      : "nothing lost";
    this.recorded.textContent = h.recording_broke ?? (h.recorded_s === null || h.recorded_s === undefined ? "" : `${digits(h.recorded_s)} s recorded`);
  }
}

// The largest of each few points: a peak is not lost.
function thinned(points, most) {
  const every = Math.ceil(points.length / most);
  if (every < 2) return points;
  const kept = [];
  for (let at = 0; at < points.length; at += every) {
    kept.push(points.slice(at, at + every).reduce((a, b) => (b[1] > a[1] ? b : a)));
  }
  return kept;
}
