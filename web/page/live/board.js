// A conversation with a board: requests one after the other, each with its answer; what the board streams; a sign of life while
// this page commands. Bytes go over any transport: { send(bytes), close(), onbytes, onclose }. The protocol itself is in the
// module (web/src/wire), in an instance of its own.
import { Engine, compileModule, fromJson } from "../common/engine.js";

// How long an answer may take, ms, and how often a request is sent. Settings are stored in flash before the answer.
const PATIENCE = 700;
const FLASH = 3000;
const ATTEMPTS = 3;

// Sent twice, the second would be refused though the first was obeyed.
const ONCE = new Set(["open", "start", "clear-fault", "release"]);

// Time between two signs of life, ms.
const ALIVE = 200;

export class Board {
  static async over(transport) {
    return new Board(await Engine.of(await compileModule()), transport);
  }

  constructor(engine, transport) {
    this.engine = engine;
    this.transport = transport;
    this.waiting = new Map();
    this.turn = Promise.resolve();
    this.commands = false;
    this.signed = 0;
    // Between two signs of life; shorter where the board's time runs faster than the page's.
    this.pace = ALIVE;
    this.settings = null;
    this.onheard = () => {};
    engine.call("wire.open", { sequence: crypto.getRandomValues(new Uint16Array(1))[0] });
    transport.onbytes = (bytes) => this.hear(bytes);
    this.timer = setInterval(() => this.sign(), ALIVE / 2);
  }

  hear(bytes) {
    const heard = fromJson(this.engine.call("wire.hear", bytes));
    for (const answer of heard.answers) {
      if (answer.kind === "settings") this.settings = answer;
      this.waiting.get(answer.request)?.(answer);
      this.waiting.delete(answer.request);
    }
    this.onheard(heard);
    this.sign();
  }

  // Sends a request; its number.
  send(request) {
    const bytes = this.engine.call("wire.request", request);
    this.transport.send(bytes.subarray(2));
    return bytes[0] | (bytes[1] << 8);
  }

  // A sign of life, if this page commands and the last is long ago. It comes from the script that also serves the Stop
  // button: where that hangs, the signs end and the drive goes off.
  sign() {
    const now = performance.now();
    if (!this.commands || now - this.signed < this.pace) return;
    this.signed = now;
    this.send({ kind: "alive" });
  }

  attempt(request, patience) {
    return new Promise((resolve) => {
      const number = this.send(request);
      const timer = setTimeout(() => {
        this.waiting.delete(number);
        resolve(null);
      }, patience);
      this.waiting.set(number, (answer) => {
        clearTimeout(timer);
        resolve(answer);
      });
    });
  }

  async asked(request) {
    const once = ONCE.has(request.kind);
    const flash = request.kind === "set-settings" || request.kind === "confirm";
    const patience = flash ? FLASH : once ? PATIENCE * ATTEMPTS : PATIENCE;
    for (let k = 0; k < (once ? 1 : ATTEMPTS); k += 1) {
      const answer = await this.attempt(request, patience);
      if (answer?.kind === "refused") throw new Error(answer.why);
      if (answer) return answer;
    }
    throw new Error("the board does not answer; is it powered and flashed, and is this its port?");
  }

  // Sends a request when those before it are answered; its answer.
  ask(request) {
    const answer = this.turn.then(() => this.asked(request));
    this.turn = answer.catch(() => {});
    return answer;
  }

  // Stops the drive: waits for nothing, needs no session.
  stop() {
    return this.asked({ kind: "stop" });
  }

  // Asks who is there and has it stream.
  async begin() {
    const hello = await this.ask({ kind: "hello" });
    if (!hello.fits) {
      throw new Error(`the board speaks protocol ${hello.protocol}, which is not this page's: use the program of its firmware (${hello.firmware})`);
    }
    await this.ask({ kind: "settings" });
    await this.ask({ kind: "telemetry", decimation: 200 });
    await this.ask({ kind: "frames", on: true }).catch(() => {});
    return hello;
  }

  // Opens the session, which steering needs.
  async openSession(takeOver) {
    const { boot, granted } = await this.ask({ kind: "board" });
    await this.ask({ kind: "open", boot, granted, take_over: takeOver });
    this.commands = true;
  }

  // Gives the session back.
  async release() {
    this.commands = false;
    await this.ask({ kind: "release" }).catch(() => {});
  }

  // The last seconds in columns: see web/src/scope.
  trace(seconds, columns) {
    return floats(this.engine.call("wire.trace", { seconds, columns }));
  }

  spectrum(signal, highest) {
    return floats(this.engine.call("wire.spectrum", { signal, max_hz: highest }));
  }

  blows() {
    return this.engine.json("wire.blows", null);
  }

  checkSettings(toml) {
    return this.engine.json("wire.check-settings", { toml });
  }

  record(madeFrom) {
    this.engine.call("wire.record", { made_from: madeFrom });
  }

  // The bytes of the file that was recorded.
  recording() {
    return this.engine.call("wire.recording", null);
  }

  close() {
    clearInterval(this.timer);
    this.commands = false;
    this.transport.onclose = () => {};
    this.transport.close();
  }
}

function floats(bytes) {
  return new Float32Array(bytes.buffer, 0, bytes.length / 4);
}
