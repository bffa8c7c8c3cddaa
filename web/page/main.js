// The frame: tabs, each a part of the page with `start(container)`, run when it is first shown.
import { element } from "./common/dom.js";
import { startTheme } from "./common/theme.js";
import { parts } from "./parts.js";

const tabs = document.getElementById("tabs");
const panels = document.getElementById("panels");

let shown = null;

function show(wanted) {
  shown = wanted;
  tellDrives();
  for (const part of parts) {
    const chosen = part === wanted;
    part.tab.setAttribute("aria-selected", String(chosen));
    part.tab.tabIndex = chosen ? 0 : -1;
    part.panel.hidden = !chosen;
  }
  if (!wanted.started) {
    wanted.started = true;
    wanted.start(wanted.panel);
  }
}

for (const part of parts) {
  part.tab = element("button", {
    type: "button", role: "tab", id: `tab-${part.id}`, "aria-controls": `part-${part.id}`,
    onclick: () => {
      if (part === shown) return;
      // Each part finds its own address again.
      shown.address = location.hash;
      history.pushState(null, "", part.address ?? `#${part.id}`);
      show(part);
    },
  }, part.title);
  part.panel = element("section", { role: "tabpanel", id: `part-${part.id}`, "aria-labelledby": `tab-${part.id}`, class: `part ${part.id}` });
  tabs.append(part.tab);
  panels.append(part.panel);
}

// Arrow keys go from tab to tab, as in every tab list.
tabs.addEventListener("keydown", (event) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  const at = parts.findIndex((part) => part.tab === document.activeElement);
  const next = parts[(at + step + parts.length) % parts.length];
  next.tab.focus();
  next.tab.click();
  event.preventDefault();
});

// A drive that runs is seen, and stopped, on every part of the page.
const stop = element("button", { type: "button", class: "stop everywhere", hidden: true, title: "Escape does the same" });
tabs.after(stop);

function tellDrives() {
  for (const part of parts) part.tab.classList.toggle("drives", Boolean(part.drive));
  const away = parts.filter((part) => part.drive && part !== shown);
  stop.hidden = away.length === 0;
  stop.textContent = `Stop the drive: ${away.map((part) => part.title).join(", ")}`;
  stop.onclick = () => away.forEach((part) => part.drive.stop());
}

panels.addEventListener("drive", ({ target, detail }) => {
  parts.find((part) => part.panel.contains(target)).drive = detail.drives ? detail : null;
  tellDrives();
});

// Back and forward go from part to part; who leaves the page with a drive on is asked.
const asked = () => parts.find((part) => part.id === location.hash.slice(1).split("?")[0]) ?? parts[0];
addEventListener("popstate", () => asked() !== shown && show(asked()));
addEventListener("beforeunload", (event) => {
  if (parts.some((part) => part.drive)) event.preventDefault();
});

startTheme(document.getElementById("theme"));
tabs.hidden = parts.length < 2;
show(asked());
