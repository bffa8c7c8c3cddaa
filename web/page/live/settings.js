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

const named = ({ section, key }) => `${section}.${key}`;

const bare = (value) => value.replaceAll('"', "");

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
      this.build(this.board.checkSettings(this.text.value));
      return "The text is in the form; it has not been written.";
    });
    this.asText = element("details", { ontoggle: () => this.board && this.check() }, element("summary", {}, "As the text of a settings file"),
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
    this.build(board.settings.toml);
  }

  // Fields for all settings of a text. Which there are depends on the contact's law, for one.
  build(toml) {
    const choices = { ...this.board.engine.json("explore.choices", null), kind: ["shaker", "motor"] };
    const boards = new Map(parsed(this.board.settings.toml).map((entry) => [named(entry), bare(entry.value)]));
    this.fields = parsed(toml).map((entry) => this.field(entry, boards.get(named(entry)), choices[entry.key]));
    const open = new Set([...this.groups.querySelectorAll("details[open]")].map((one) => one.dataset.section));
    this.groups.replaceChildren(...Object.keys(SECTIONS).map((section) => {
      const opened = this.groups.children.length ? open.has(section) : OPEN.includes(section);
      return element("details", { open: opened, "data-section": section }, element("summary", {}, SECTIONS[section]),
        ...this.fields.filter((one) => one.section === section).map((one) => one.row));
    }));
    this.check();
  }

  async again(said) {
    await this.board.ask({ kind: "settings" });
    this.show(this.board);
    return said;
  }

  // `own` is the board's value, if it has this setting.
  field({ section, key, value, meaning }, own, choices) {
    const id = fresh(key);
    const common = { id, "data-setting": named({ section, key }), "aria-describedby": `${id}-meaning`, onchange: () => {
      // Another law of the contact has parameters of its own.
      if (key === "contact_law") this.fields = this.fields.filter((one) => !one.key.startsWith("contact_") || one.key === key);
      this.check();
    } };
    const input = choices ? element("select", { ...common, value: bare(value) }, ...choices.map((one) => element("option", { value: one }, one)))
      : value === "true" || value === "false" ? element("input", { type: "checkbox", checked: value === "true", ...common })
        : element("input", { type: value.startsWith('"') ? "text" : "number", step: "any", value: bare(value), ...common });
    const row = element("div", { class: "setting" }, element("label", { for: id }, title(key)), input, element("span", { class: "note", id: `${id}-meaning` }, meaning));
    const now = () => (input.type === "checkbox" ? String(input.checked) : input.value);
    const differs = () => (input.type === "number" && now() !== "" ? Number(now()) !== Number(own) : now() !== own);
    // A word stands in quotes, a number or a switch as it is; an empty field is refused like a word.
    const isWord = () => input.type !== "checkbox" && (now().trim() === "" || Number.isNaN(Number(now())));
    const line = () => `${key} = ${isWord() ? JSON.stringify(now()) : now()}`;
    return { section, key, input, row, differs, line };
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
    let whole = null;
    try {
      whole = this.board.checkSettings(this.changes());
    } catch (error) {
      this.wrong.textContent = error.message;
      const about = (one) => error.message.includes(`${named(one)} `) || (one.section === "rig" && new RegExp(`\\b${one.key}\\b`).test(error.message));
      const found = this.fields.find(about);
      if (found) {
        markField(found.input, error.message);
        found.row.closest("details").open = true;
      }
    }
    if (whole && parsed(whole).map(named).join() !== this.fields.map(named).join()) this.build(whole);
    else if (this.asText.open) this.text.value = whole ?? this.changes();
  }
}
