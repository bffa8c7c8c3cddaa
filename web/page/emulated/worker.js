// The emulated rig in a worker: plant, controller and board run here, at a wanted multiple of real time, as far as the machine keeps up.
import { Engine } from "../common/engine.js";

// Time between two steps, ms, and the most that one may take.
const TURN = 10;
const MOST = 30;

// A block is ten ticks of 50 µs, ms.
const BLOCK = 0.5;

let engine = null;
let speed = 1;
let running = false;
let last = 0;
let owed = 0;
let done = 0;
let measured = 0;

// Rig time that has passed, in blocks, until the machine is late: then it is let go.
function turn() {
  setTimeout(turn, TURN);
  if (!running) return;
  const now = performance.now();
  owed = Math.min(owed + ((now - last) * speed) / BLOCK, (200 * speed) / BLOCK);
  last = now;
  while (owed >= 1 && performance.now() - now < MOST) {
    const blocks = Math.min(Math.floor(owed), 20);
    owed -= blocks;
    done += blocks;
    const bytes = engine.call("emulated.step", { blocks });
    if (bytes.length) self.postMessage({ bytes }, [bytes.buffer]);
  }
  if (now - measured > 250) {
    const factor = (done * BLOCK) / (now - measured);
    self.postMessage({ factor, truth: engine.json("emulated.truth", null) });
    [measured, done] = [now, 0];
  }
}

async function obey(data) {
  if (data.module) {
    engine = await Engine.of(data.module);
    self.postMessage({ scenarios: engine.json("emulated.scenarios", null) });
    turn();
  }
  if (data.bytes) engine.call("emulated.receive", data.bytes);
  if (data.speed) speed = data.speed;
  if (data.event) engine.call("emulated.event", { toml: data.event });
  if (data.scenario) {
    engine.call("emulated.start", data.scenario);
    running = true;
    [last, measured, owed, done] = [performance.now(), performance.now(), 0, 0];
    self.postMessage({ started: true });
  }
}

self.onmessage = ({ data }) => {
  obey(data).catch((error) => self.postMessage({ error: error.message, fatal: error.fatal === true }));
};
