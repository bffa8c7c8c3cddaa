// Keys of rigs and settings as people read them, and the marks of fields.

// The longer endings first.
const UNITS = [
  ["_m_per_s2", "m/s²"], ["_n_per_m3", "N/m³"], ["_n_s_per_m", "N·s/m"], ["_s_per_m", "s/m"], ["_n_per_m", "N/m"], ["_hz_per_s", "Hz/s"], ["_m_per_s", "m/s"],
  ["n_per_code", "N/code"], ["m_per_code", "m/code"], ["_percent", "%"], ["_kg", "kg"], ["_mm", "mm"], ["_hz", "Hz"], ["_n", "N"], ["_m", "m"], ["_s", "s"],
];

// The name and unit of a key: "mass, kg".
export function title(key) {
  const [ending, unit] = UNITS.find(([one]) => key.endsWith(one)) ?? ["", ""];
  const name = key.slice(0, key.length - ending.length).replaceAll("_", " ") || "scale";
  return unit ? `${name}, ${unit}` : name;
}

// Marks a field that has no room for a line below it; null takes the mark away.
export function markField(field, why) {
  field.title = why ?? "";
  if (why === null) field.removeAttribute("aria-invalid");
  else field.setAttribute("aria-invalid", "true");
}
