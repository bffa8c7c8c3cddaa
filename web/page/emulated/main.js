// The emulated rig: the board of a rig that is not there, on the same scope as a real one.
import { element } from "../common/dom.js";
import { compileModule } from "../common/engine.js";
import { digits } from "../common/numbers.js";
import { Board } from "../live/board.js";
import { View } from "../live/view.js";

// What a person can do to the rig: a button's words, and the event of a scenario file.
const DEEDS = [
  ["Push the hammer", 'kind = "push"\nspeed_m_per_s = 0.1'],
  ["Let the ground give way", 'kind = "recede"\nmm_per_s = 0.02\nup_to_mm = 1.2\nfor_s = 60.0'],
  ["Soften the support by 5 %", 'kind = "drift"\nnatural_frequency_percent = -5.0\nover_s = 10.0'],
  ["Harden the contact by 50 %", 'kind = "drift"\ncontact_stiffness_percent = 50.0\nover_s = 10.0'],
  ["Tilt by 0.1°", 'kind = "tilt"\ndegrees = 0.1\nover_s = 5.0'],
  ["Open the emergency stop for 1 s", 'kind = "emergency-stop"\nfor_s = 1.0'],
  ["Lose 20 blocks", 'kind = "lost-block"\nblocks = 20'],
];

const SENSORS = ["force", "hammer", "cart"];

// Kinds of defects, each with the keys it needs.
const DEFECTS = [
  ["open wire", 'fault = "open"'],
  ["at its upper rail", 'fault = "saturated"'],
  ["at its lower rail", 'fault = "saturated-low"'],
  ["frozen", 'fault = "frozen"'],
  ["gain 0.5", 'fault = "gain"\ntimes = 0.5'],
  ["reversed", 'fault = "reversed"'],
  ["dead", 'fault = "dead"'],
  ["one tick of ten open", 'fault = "intermittent"\nticks = 1\nof = 10'],
];

const SPEEDS = [0.1, 0.5, 1, 2, 5, 10];

export async function start(container) {
  const rig = new EmulatedRig(container);
  await rig.begin();
}

class EmulatedRig {
  constructor(container) {
    this.choice = element("select", { "aria-label": "scenario" });
    this.events = element("input", { type: "checkbox", checked: true });
    this.speed = element("select", { onchange: () => this.hurry() },
      ...SPEEDS.map((factor) => element("option", { value: factor, selected: factor === 1 }, `${factor}×`)));
    this.factor = element("output", { class: "factor" });
    this.run = element("button", { type: "button", onclick: () => this.restart() }, "Begin");
    this.about = element("p", { class: "note" });
    this.truth = element("p", { class: "note truth" });
    this.wrong = element("p", { role: "alert", class: "wrong" });
    this.sensor = element("select", { "aria-label": "sensor" }, ...SENSORS.map((name) => element("option", {}, name)));
    this.defect = element("select", { "aria-label": "defect" }, ...DEFECTS.map(([label], at) => element("option", { value: at }, label)));
    const deed = (text, event) => element("button", { type: "button", class: "deed", onclick: () => this.worker.postMessage({ event }) }, text);
    const breaking = (seconds) => {
      const length = seconds ? `\nfor_s = ${seconds}.0` : "";
      this.worker.postMessage({ event: `kind = "sensor-fault"\nsensor = "${this.sensor.value}"\n${DEFECTS[Number(this.defect.value)][1]}${length}` });
    };
    container.append(
      element("h2", {}, "Emulated rig"),
      element("div", { class: "row" },
        element("label", {}, "Scenario ", this.choice), element("label", {}, this.events, " with its events"), this.run,
        element("label", {}, "Speed ", this.speed), this.factor),
      this.about, this.wrong,
      // On a phone the rig itself comes first.
      element("details", { class: "panel", open: innerWidth > 760 },
        element("summary", {}, "Do something to the rig"),
        element("div", { class: "row" }, ...DEEDS.map(([text, event]) => deed(text, event))),
        element("div", { class: "row" }, "Break a sensor: ", this.sensor, this.defect,
          element("button", { type: "button", class: "deed", onclick: () => breaking(0) }, "for good"),
          element("button", { type: "button", class: "deed", onclick: () => breaking(2) }, "for 2 s"))),
      this.truth,
    );
    this.view = new View(container, { name: "emulated" });
    this.choice.onchange = this.events.onchange = () => this.describe();
  }

  async begin() {
    const code = document.getElementById("emulated-worker").textContent;
    this.worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }) => this.heard(data);
    this.worker.onerror = (event) => this.failed(event.message || "the worker failed; reload the page");
    this.worker.postMessage({ module: await compileModule() });
  }

  heard(data) {
    if (data.bytes) this.transport?.onbytes(data.bytes);
    if (data.factor !== undefined) {
      this.factor.textContent = `measured ${digits(data.factor, 3)}×`;
      this.factor.dataset.factor = data.factor;
      this.tell(data.truth);
    }
    if (data.error) this.failed(data.error, data.fatal);
    if (data.started) this.connect();
    if (data.scenarios) {
      this.scenarios = data.scenarios;
      this.choice.replaceChildren(...data.scenarios.map(({ name }) => element("option", { value: name, selected: name === "field" }, name)));
      this.describe();
      this.restart();
    }
  }

  // Where that has ended the rig, nothing that is shown is true any more.
  failed(why, fatal = true) {
    this.wrong.textContent = why;
    this.run.disabled = false;
    if (!fatal) return;
    this.running = null;
    this.board?.close();
    this.view.show(null);
    this.truth.textContent = "";
  }

  describe() {
    const chosen = this.scenarios.find(({ name }) => name === this.choice.value)?.description ?? "";
    const { name, events } = this.running ?? { name: this.choice.value, events: this.events.checked };
    const waits = name !== this.choice.value || events !== this.events.checked;
    this.about.textContent = waits ? `Not begun yet (${name} ${events ? "with" : "without"} its events runs on until Begin): ${chosen}` : chosen;
  }

  // One begin at a time: a second press before the rig answers is the same begin.
  restart() {
    this.run.disabled = true;
    this.running = { name: this.choice.value, events: this.events.checked };
    this.describe();
    this.wrong.textContent = "";
    this.board?.close();
    this.view.show(null);
    this.view.forget();
    this.worker.postMessage({ scenario: { name: this.choice.value, events: this.events.checked }, speed: Number(this.speed.value) });
  }

  // At another speed the board's watch over the link runs as much faster.
  hurry() {
    const speed = Number(this.speed.value);
    this.worker.postMessage({ speed });
    if (this.board) this.board.pace = 200 / Math.max(1, speed);
  }

  // The page is the rig's only program: it watches and commands at once.
  async connect() {
    this.transport = {
      onbytes: () => {}, onclose: () => {}, close: () => {},
      send: (bytes) => this.worker.postMessage({ bytes: bytes.slice() }),
    };
    try {
      this.board = await Board.over(this.transport);
      await this.board.begin();
      this.hurry();
      await this.board.openSession(true);
      this.view.show(this.board);
      this.runs = (this.runs ?? 0) + 1;
      this.truth.dataset.run = this.runs;
    } catch (error) {
      this.wrong.textContent = error.message;
    }
    this.run.disabled = false;
  }

  // What is true, which only an emulated rig tells.
  tell(truth) {
    this.truth.textContent = `In truth: ${digits(truth.time_s, 5)} s of rig time, drive ${truth.powered ? "on" : "off"}, ${truth.contacts} contacts, the last with ${digits(truth.peak_n)} N and ${digits(truth.impulse_n_s)} N·s.`;
    this.truth.dataset.powered = String(truth.powered);
    for (const { time_s, text } of truth.events) this.view.mark(time_s, text);
  }
}
