// Charts of the last minute on canvases. Each column of pixels shows the minimum and the maximum of its time, so that
// no peak is lost.

import { byId, make, number, scaleOf } from "./dom.js";
import { MINUTE_MS } from "./history.js";

const DRAW_EVERY_MS = 100;
const CHOSEN = "chosen";

const angle = (dof) => dof.slides ? "mm" : "deg";
const force = (dof) => dof.slides ? "N" : "N m";
const one = () => 1;

// Each signal by name: its numbers, their owner (dof or servo) and unit. `lines`: kind in the history, label, colour.
const SIGNALS = {
  position: { text: "Position", of: "dof", unit: angle, scale: scaleOf, lines: [["wanted", "commanded", "world"], ["measured", "measured", "focus"]] },
  error: { text: "Error", of: "dof", unit: angle, scale: scaleOf, lines: [["error", "commanded − measured", "alert"]] },
  effort: { text: "Load", of: "dof", unit: force, scale: one, lines: [["effort", "load", "recommended"]] },
  celsius: { text: "Temperature", of: "servo", unit: () => "°C", scale: one, lines: [["celsius", "temperature", "alert"]] },
  heat: { text: "Heat of the winding", of: "servo", unit: () => "%", scale: one, lines: [["heat", "heat", "alert"]] },
  volts: { text: "Voltage of a servo", of: "servo", unit: () => "V", scale: one, lines: [["volts", "voltage", "focus"]] },
  errors: { text: "Bus errors", of: "servo", unit: () => "", scale: one, lines: [["errors", "errors", "alert"]] },
  supply: { text: "Supply", of: null, unit: () => "V", scale: one, lines: [["supply", "supply", "focus"]] },
  tick: { text: "Duration of a tick", of: null, unit: () => "us", scale: one, lines: [["tick", "tick", "focus"]] },
};

export const charts = (head, history) => {
  const list = byId("charts"), signal = byId("signal"), of = byId("of");
  let all = [], joint = 0, drawnAt = 0;

  const fill = () => {
    const kind = SIGNALS[signal.value].of;
    const names = kind === "dof" ? head.dofs : kind === "servo" ? head.servos : [];
    of.replaceChildren(...(kind === null ? [make("option", { value: "" }, "the rig")] : [
      make("option", { value: CHOSEN }, "chosen joint"),
      ...names.map(({ name }, index) => make("option", { value: String(index) }, name))]));
    of.disabled = kind === null;
  };
  signal.replaceChildren(...Object.entries(SIGNALS).map(([name, { text }]) => make("option", { value: name }, text)));
  signal.onchange = fill;
  fill();

  // Index of the dof or the servo that a chart shows now; -1 if a joint has no servo.
  const indexOf = ({ kind, of: which }) => {
    if (SIGNALS[kind].of === null) return 0;
    if (which !== CHOSEN) return Number(which);
    return SIGNALS[kind].of === "dof" ? joint : head.servos.findIndex(({ dof }) => dof === joint);
  };
  const visit = (line, index, now, take) => {
    if (line !== "error") { history.each(line, index, now, take); return; }
    const wanted = [];
    history.each("wanted", index, now, (_, x) => wanted.push(x));
    let i = 0;
    history.each("measured", index, now, (age, x) => { take(age, wanted[i] - x); i += 1; });
  };

  const draw = (chart, now) => {
    const { canvas, title, extremes } = chart;
    const { text, of: kind, unit, scale, lines } = SIGNALS[chart.kind];
    const index = indexOf(chart);
    const named = kind === "dof" ? head.dofs[index] : kind === "servo" ? head.servos[index] : { name: "" };
    title.textContent = named ? `${text}${named.name ? ` · ${named.name}` : ""}` : `${text} · no servo`;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.round(x * ratio));
    if (!named || width === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    context.clearRect(0, 0, width, height);
    const factor = scale(named);
    const columns = lines.map(([line]) => {
      const [least, most] = [new Float32Array(width).fill(Infinity), new Float32Array(width).fill(-Infinity)];
      visit(line, index, now, (age, x) => {
        if (!Number.isFinite(x)) return;
        const at = Math.min(Math.floor((1 - age / MINUTE_MS) * width), width - 1);
        least[at] = Math.min(least[at], x * factor);
        most[at] = Math.max(most[at], x * factor);
      });
      return { least, most };
    });
    let low = Infinity, high = -Infinity;
    for (const { least, most } of columns) {
      for (let i = 0; i < width; i += 1) { low = Math.min(low, least[i]); high = Math.max(high, most[i]); }
    }
    const digits = Math.abs(high) >= 100 ? 0 : Math.abs(high) >= 1 ? 1 : 3;
    extremes.textContent = low <= high ? `min ${number(low, digits)}, max ${number(high, digits)} ${unit(named)}` : "no value";
    const room = Math.max((high - low) * 0.1, Math.abs(high) * 0.02, 1e-3);
    const y = (x) => height - (x - low + room) / (high - low + 2 * room) * height;
    context.strokeStyle = color("line");
    context.lineWidth = ratio;
    context.beginPath();
    for (let part = 1; part < 6; part += 1) {
      const x = Math.round(part / 6 * width) + 0.5;
      context.moveTo(x, 0);
      context.lineTo(x, height);
    }
    if (low < 0 && high > 0) { context.moveTo(0, y(0)); context.lineTo(width, y(0)); }
    context.stroke();
    lines.forEach(([, , name], at) => {
      const { least, most } = columns[at];
      context.strokeStyle = color(name);
      context.lineWidth = 1.6 * ratio;
      context.lineJoin = "round";
      context.beginPath();
      let before = null;
      for (let i = 0; i < width; i += 1) {
        if (least[i] > most[i]) continue;
        // A gap of more than a second is not bridged.
        if (before === null || i - before > width / 60 + 2) context.moveTo(i, y(least[i]));
        else context.lineTo(i, y(least[i]));
        context.lineTo(i, y(most[i]));
        before = i;
      }
      context.stroke();
    });
  };

  const add = (kind, which) => {
    const title = make("strong"), extremes = make("span", { className: "extremes" });
    const canvas = make("canvas", { role: "img", "aria-label": `Chart: ${SIGNALS[kind].text}` });
    const close = make("button", { type: "button", className: "plain close", "aria-label": `Remove the chart ${SIGNALS[kind].text}` }, "×");
    const key = SIGNALS[kind].lines.length < 2 ? [] : SIGNALS[kind].lines.map(([, label, name]) => {
      const dash = make("i");
      dash.style.setProperty("--color", `var(--${name})`);
      return make("span", { className: "line-key" }, dash, label);
    });
    const figure = make("figure", {}, make("figcaption", {}, title, ...key, extremes, close), canvas);
    const chart = { kind, of: which, figure, canvas, title, extremes };
    close.addEventListener("click", () => {
      all = all.filter((other) => other !== chart);
      figure.remove();
    });
    all.push(chart);
    list.append(figure);
  };
  list.replaceChildren();
  add("position", CHOSEN);
  add("effort", CHOSEN);
  byId("add").onsubmit = (event) => {
    event.preventDefault();
    add(signal.value, of.value);
  };

  return {
    choose: (index) => { joint = index; },
    take: (now) => {
      if (now - drawnAt < DRAW_EVERY_MS) return;
      drawnAt = now;
      for (const chart of all) draw(chart, now);
    },
  };
};
