// The settings of a board as a form. The module writes them as the text of a settings file, each line with its meaning; the form is
// made of that text, so it has every setting that there is. What differs goes to the board as such a text, too.
import { element, fresh } from "../common/dom.js";
import { markField, title } from "../common/fields.js";

const SECTIONS = {
  limits: "Limits that are held", trips: "What switches the drive off", aim: "What is aimed at", rig: "Rig", detection: "What counts as a contact", drive: "Drive",
  force: "Force sensor", hammer: "Hammer sensor", cart: "Cart sensor", operator: "Who must be there", interlock: "Inputs of the power stage",
};
const OPEN = ["limits", "trips", "aim"];

// [{ section, key, value: as the file has it, meaning }, …]
function parsed(toml) {
  const entries = [];
  let section = "";
  for (const line of toml.split("\n")) {
    section = line.match(/^\[(\w+)\]$/)?.[1] ?? section;
    const [, key, value, meaning] = line.match(/^(\w+) = ("[^"]*"|\S+)(?: +# (.*))?$/) ?? [];
    if (key) entries.push({ section, key, value, meaning: meaning ?? "" });
  }
  return entries;
}

export class SettingsForm {
  constructor() {
    const id = fresh("settings");
    const button = (text, act) => element("button", { type: "button", onclick: () => this.attempt(act) }, text);
    this.fields = [];
    this.groups = element("div", { class: "settings-groups" });
    this.said = element("p", { class: "note", role: "status" }, "A board that is connected shows its settings here.");
    this.wrong = element("p", { class: "wrong", role: "alert" });
    this.read = button("Read again", () => this.again("Read."));
    this.write = button("Write what differs", async () => {
      await this.board.ask({ kind: "set-settings", toml: this.changes() });
      return this.again("The settings are in use and stored.");
    });
    this.text = element("textarea", { id, rows: 12, spellcheck: "false" });
    this.take = button("Put the text into the form", () => {
      this.fill(this.board.checkSettings(this.text.value));
      return "The text is in the form; it has not been written.";
    });
    this.asText = element("details", { ontoggle: () => this.showText() }, element("summary", {}, "As the text of a settings file"),
      element("label", { for: id, class: "note" }, "What is left out stays as it is on the board"), this.text, this.take);
    this.node = element("section", { class: "panel settings", "aria-label": "settings" }, element("h2", {}, "Settings"),
      element("div", { class: "row" }, this.read, this.write), this.said, this.wrong, this.groups, this.asText);
  }

  // Does something that may be refused, and says what came of it.
  async attempt(act) {
    this.wrong.textContent = "";
    try {
      const done = await act();
      this.said.textContent = `${done} ${this.said.textContent}`;
    } catch (error) {
      this.wrong.textContent = error.message;
    }
  }

  enable(board, writes) {
    this.read.disabled = this.take.disabled = !board;
    this.write.disabled = !writes;
  }

  // Shows the settings that a board said it has.
  show(board) {
    this.board = board;
    const toml = board.settings.toml;
    const choices = { ...board.engine.json("explore.choices", null), kind: ["shaker", "motor"] };
    this.fields = parsed(toml).map((entry) => this.field(entry, choices[entry.key]));
    const open = new Set([...this.groups.querySelectorAll("details[open]")].map((one) => one.dataset.section));
    const named = Object.keys(SECTIONS).map((section) => {
      const opened = this.groups.children.length ? open.has(section) : OPEN.includes(section);
      return element("details", { open: opened, "data-section": section }, element("summary", {}, SECTIONS[section]),
        ...this.fields.filter((one) => one.section === section).map((one) => one.row));
    });
    this.groups.replaceChildren(...named);
    this.check();
  }

  async again(said) {
    await this.board.ask({ kind: "settings" });
    this.show(this.board);
    return said;
  }

  field({ section, key, value, meaning }, choices) {
    const id = fresh(key);
    const common = { id, "data-setting": `${section}.${key}`, "aria-describedby": `${id}-meaning`, onchange: () => this.check() };
    const bare = value.replaceAll('"', "");
    const input = choices ? element("select", common, ...choices.map((one) => element("option", { value: one }, one)))
      : value === "true" || value === "false" ? element("input", { type: "checkbox", ...common })
        : element("input", { type: value.startsWith('"') ? "text" : "number", step: "any", ...common });
    const set = (text) => {
      if (input.type === "checkbox") input.checked = text === "true";
      else input.value = text;
    };
    set(bare);
    const row = element("div", { class: "setting" }, element("label", { for: id }, title(key)), input, element("span", { class: "note", id: `${id}-meaning` }, meaning));
    const now = () => (input.type === "checkbox" ? String(input.checked) : input.value);
    const differs = () => (input.type === "number" && now() !== "" ? Number(now()) !== Number(bare) : now() !== bare);
    // A word stands in quotes, a number or a switch as it is; an empty field is refused like a word.
    const isWord = () => input.type !== "checkbox" && (now().trim() === "" || Number.isNaN(Number(now())));
    const line = () => `${key} = ${isWord() ? JSON.stringify(now()) : now()}`;
    return { section, key, input, row, set, differs, line };
  }

  fill(toml) {
    for (const { section, key, value } of parsed(toml)) this.fields.find((one) => one.section === section && one.key === key)?.set(value.replaceAll('"', ""));
    this.check();
  }

  // What differs from the board's, as the text of a settings file.
  changes() {
    const differ = this.fields.filter((one) => one.differs());
    const sections = [...new Set(differ.map((one) => one.section))];
    return sections.map((section) => `[${section}]\n${differ.filter((one) => one.section === section).map((one) => `${one.line()}\n`).join("")}`).join("");
  }

  // Marks what differs, and the field that cannot be so.
  check() {
    this.wrong.textContent = "";
    for (const { input, row, differs } of this.fields) {
      markField(input, null);
      row.classList.toggle("changed", differs());
    }
    const count = this.fields.filter((one) => one.differs()).length;
    this.said.textContent = `${count === 0 ? "As on the board." : `${count} of them ${count === 1 ? "differs" : "differ"} from the board's.`} They can be written in idle or fault, and are checked as a whole.`;
    try {
      this.board.checkSettings(this.changes());
    } catch (error) {
      this.wrong.textContent = error.message;
      const named = ({ section, key }) => error.message.includes(`${section}.${key} `) || (section === "rig" && new RegExp(`\\b${key}\\b`).test(error.message));
      const found = this.fields.find(named);
      if (found) {
        markField(found.input, error.message);
        found.row.closest("details").open = true;
      }
    }
    this.showText();
  }

  showText() {
    if (!this.asText.open || !this.board) return;
    try {
      this.text.value = this.board.checkSettings(this.changes());
    } catch {
      this.text.value = this.changes();
    }
  }
}
