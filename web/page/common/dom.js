// Elements in one expression.

const SVG = "http://www.w3.org/2000/svg";

function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (typeof value === "function") made[name.toLowerCase()] = value;
    else if (name !== "value") made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  // A select knows its values only now.
  if (attributes?.value !== undefined) made.value = attributes.value;
  return made;
}

// An element of the page: attributes by name, functions as handlers (`onclick`), then its children.
export function element(name, attributes, ...children) {
  return fill(document.createElement(name), attributes, children);
}

// The same for a picture.
export function svg(name, attributes, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

// A label with its control inside; `id` joins what describes it.
export function labelled(text, control) {
  return element("label", {}, element("span", {}, text), control);
}

let numbers = 0;

// An id that nothing else has.
export function fresh(stem) {
  numbers += 1;
  return `${stem}-${numbers}`;
}
