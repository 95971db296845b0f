// Small helpers for elements and numbers. Data goes into the page as text only.

export const byId = (id) => document.getElementById(id);

// Creates an element and sets its `properties`, also `dataset` and names with `aria-`.
export const make = (tag, properties = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "dataset") Object.assign(element.dataset, value);
    else if (name.startsWith("aria-") || name === "role" || name === "scope") element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children);
  return element;
};

// Sets a text only if it differs, so that the browser does not lay out an unchanged page again.
export const write = (element, text) => { if (element.textContent !== text) element.textContent = text; };
export const setHidden = (element, hidden) => { if (element.hidden !== hidden) element.hidden = hidden; };
export const setDisabled = (element, disabled) => { if (element.disabled !== disabled) element.disabled = disabled; };

const DEGREES = 180 / Math.PI;

// Avoids "-0".
const fixed = (x, digits) => {
  const text = x.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
};
export const number = (x, digits) => Number.isFinite(x) ? fixed(x, digits) : "–";

// A joint's angle or distance: degrees or millimetres on the page, radians or metres in messages.
export const scaleOf = (dof) => dof.slides ? 1000 : DEGREES;
export const unitOf = (dof) => dof.slides ? " mm" : "°";
export const position = (dof, x) => Number.isFinite(x) ? fixed(x * scaleOf(dof), 1) + unitOf(dof) : "–";
export const effort = (dof, x) => {
  if (!Number.isFinite(x)) return "–";
  const digits = Math.abs(x) >= 100 ? 0 : Math.abs(x) >= 10 ? 1 : Math.abs(x) >= 1 ? 2 : 3;
  return `${fixed(x, digits)} ${dof.slides ? "N" : "N m"}`;
};
export const seconds = (t) => {
  if (!Number.isFinite(t)) return "–";
  const minutes = Math.floor(t / 60);
  return minutes > 0 ? `${minutes}:${(t - 60 * minutes).toFixed(1).padStart(4, "0")}` : `${t.toFixed(1)} s`;
};
