// Light, dark, or as the system says; kept from visit to visit where the browser allows it.

const KEY = "vibroimpact-theme";

function kept() {
  try {
    return localStorage.getItem(KEY) ?? "auto";
  } catch {
    return "auto";
  }
}

function keep(theme) {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // A page from a disk may keep nothing.
  }
}

function set(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  for (const hear of listeners) hear();
}

const listeners = [];

// `hear` is called when the colours have changed: a canvas must be drawn anew, an SVG follows its style.
export function onTheme(hear) {
  listeners.push(hear);
}

// Joins the theme to its select.
export function startTheme(select) {
  select.value = kept();
  set(select.value);
  select.addEventListener("change", () => {
    keep(select.value);
    set(select.value);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => set(select.value));
}

// A colour of the theme as the style has it: "ink", "paper", "line", "faint".
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
