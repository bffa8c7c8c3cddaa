// Live: a real board, through the page's server or by Web Serial.
import { element } from "../common/dom.js";
import { Board } from "./board.js";
import { RATES, hasSerial, openSerial } from "./serial.js";
import { boardOfServer, openServer } from "./server.js";
import { View } from "./view.js";

// The state comes every 10 ms: a board that has not been heard for so long, ms, is silent.
const SILENT = 1500;

export async function start(container) {
  const said = element("p", { role: "status", class: "seat" }, "looking for a board …");
  const wrong = element("p", { role: "alert", class: "wrong" });
  const row = element("div", { class: "row" });
  container.append(element("h2", {}, "Live"), said, wrong, row);
  const view = new View(container, { name: "recording", tells: true });
  const live = new Live(view, said, wrong, row);
  live.server = await boardOfServer();
  live.choose();
}

class Live {
  constructor(view, said, wrong, row) {
    Object.assign(this, { view, said, wrong, row, board: null, page: null, commander: null });
  }

  button(text, act) {
    return element("button", { type: "button", onclick: () => this.attempt(act) }, text);
  }

  async attempt(act) {
    this.wrong.textContent = "";
    try {
      await act();
    } catch (error) {
      this.wrong.textContent = error.message;
    }
  }

  // Without a board: which ways there are.
  choose() {
    const ways = [];
    if (this.server) ways.push(this.button(`Connect to ${this.server}`, () => this.connectServer()));
    if (hasSerial()) ways.push(this.button("Connect by Web Serial", () => this.connectSerial()));
    this.row.replaceChildren(...ways);
    if (this.server) this.said.textContent = `The server has the board at ${this.server}.`;
    else if (hasSerial()) this.said.textContent = "No server with a board: choose its port, or run host-sim link PORT --page.";
    else this.said.textContent = "No board here. Run host-sim link PORT --page, which opens this page with the board, or use a browser with Web Serial.";
  }

  async begin(transport, what) {
    transport.onclose = (why) => this.ended(why);
    const board = await Board.over(transport);
    this.board = board;
    try {
      const hello = await board.begin();
      this.what = `${hello.board} (${hello.firmware}) at ${what}`;
    } catch (error) {
      board.close();
      this.board = null;
      throw error;
    }
    this.view.forget();
    this.view.show(board, SILENT);
  }

  async connectServer() {
    const transport = await openServer();
    transport.onwords = (words) => this.words(words);
    this.transport = transport;
    await this.begin(transport, this.server);
    this.seat();
  }

  async connectSerial() {
    const port = await navigator.serial.requestPort();
    const [usual, slower] = RATES;
    try {
      await this.begin(await openSerial(port, usual), "the serial port");
    } catch (why) {
      const transport = await openSerial(port, slower);
      await this.begin(transport, `the serial port at ${slower} Bd`).catch(() => { throw why; });
    }
    this.transport = null;
    this.alone();
  }

  ended(why) {
    this.board?.close();
    this.board = null;
    this.commander = null;
    this.view.show(null);
    this.choose();
    this.wrong.textContent = why;
  }

  // What the server says.
  words(words) {
    if (words.kind === "welcome") this.page = words.page;
    if (words.kind === "board") this.wrong.textContent = words.up ? "" : words.why;
    if (words.kind === "lost") this.lost = (this.lost ?? 0) + words.frames;
    if (words.kind === "seat") {
      this.commander = words.commander;
      this.pages = words.pages;
      this.why = words.why;
      if (this.commander !== this.page && this.board) this.board.commands = false;
      if (this.commander === this.page) this.taken?.();
    }
    if (this.board && this.transport) this.seat();
  }

  // Behind the server: one page commands, the others watch.
  seat() {
    const mine = this.commander !== null && this.commander === this.page;
    const who = mine ? "this page commands" : this.commander === null ? "nobody commands" : `page ${this.commander} commands, this page watches`;
    const lost = this.lost ? `; ${this.lost} messages lost on the way to this page` : "";
    this.said.textContent = `${this.what}: this is page no. ${this.page}, ${this.pages === 1 ? "the only one open" : `${this.pages} are open`}; ${who}${this.why ? ` (${this.why})` : ""}${lost}.`;
    const steer = mine
      ? this.button("Leave the command (stops the drive)", () => this.transport.say("leave"))
      : this.commander === null
        ? this.button("Take the command", () => this.take("take"))
        : this.button(`Take over from page ${this.commander}`, () => this.take("take-over"));
    this.row.replaceChildren(steer, this.button("Disconnect", () => this.ended("")));
    this.view.enable();
  }

  async take(act) {
    const taken = new Promise((resolve) => { this.taken = resolve; });
    this.transport.say(act);
    await taken;
    this.taken = null;
    await this.board.openSession(true);
    this.view.enable();
  }

  // On a port of its own: no other page is there, but another program may have had the session.
  alone() {
    const { board } = this;
    this.said.textContent = `${this.what}: ${board.commands ? "this page commands; when it goes, the drive is off after the board's link timeout" : "this page watches"}.`;
    const steer = board.commands
      ? this.button("Leave the command (stops the drive)", async () => {
        await board.stop();
        await board.release();
        this.alone();
      })
      : this.button("Take the command", async () => {
        await board.openSession(true);
        this.alone();
        this.view.enable();
      });
    this.row.replaceChildren(steer, this.button("Disconnect", async () => {
      if (board.commands) await board.stop().catch(() => {});
      this.ended("");
    }));
  }
}
