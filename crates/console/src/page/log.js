// Events in words, the newest first; and the latched fault with its remedy.

import { byId, make, seconds, setHidden, write } from "./dom.js";

const KEPT = 300;
const SWING = 64;
const SWINGS_MS = 3000;

export const log = (ask, report) => {
  const list = byId("events"), panel = byId("faults");
  // `shown` is undefined while the panel may differ from the fault, and null if no fault is shown.
  let head = null, unread = 0, shown;
  const jointOf = new Map();
  const swings = new Map();
  const clear = make("button", { type: "button", className: "clear" }, "Clear faults");
  clear.addEventListener("click", async () => report("clear", await ask({ type: "clear" })));

  const textOf = (fault) => head?.faults?.[fault] ?? { name: `fault ${fault}`, means: "", do: "" };
  const note = (event) => {
    const { level = "info", text, t, joint } = event;
    const known = event.fault === null || event.fault === undefined ? null : textOf(event.fault);
    const item = make("li", { className: level },
      make("time", {}, seconds(t)), make("b", {}, level),
      make("span", {}, joint && !text.includes(joint) ? `${joint}: ${text}` : text));
    if (known?.do) item.append(make("em", {}, `To do: ${known.do}.`));
    list.prepend(item);
    while (list.children.length > KEPT) list.lastChild.remove();
    if (byId("log").hidden && level !== "info") unread += 1;
    write(byId("unread"), String(unread));
    setHidden(byId("unread"), unread === 0);
  };

  return {
    setHead: (now) => { head = now; shown = undefined; },
    read: () => { unread = 0; setHidden(byId("unread"), true); },
    add: (event) => {
      if (event.fault !== null && event.fault !== undefined && event.joint) jointOf.set(event.fault, event.joint);
      const dof = head?.dofs.findIndex(({ name }) => name === event.joint) ?? -1;
      if (event.fault === SWING && dof >= 0) swings.set(dof, performance.now());
      shown = undefined;
      note(event);
    },
    // Joints for which the board reported in the last 3 s that they swing.
    swinging: () => {
      const now = performance.now();
      for (const [dof, since] of swings) if (now - since > SWINGS_MS) swings.delete(dof);
      return new Set(swings.keys());
    },
    show: (fault, mayClear) => {
      clear.disabled = !mayClear;
      if (fault === shown) return;
      shown = fault;
      setHidden(panel, fault === null);
      if (fault === null) { panel.replaceChildren(); return; }
      const { name, means, do: todo } = textOf(fault);
      const joint = jointOf.get(fault);
      const isWarning = fault >= SWING;
      panel.classList.toggle("warning", isWarning);
      panel.replaceChildren(
        make("p", {}, make("strong", {}, `${isWarning ? "Warning" : "Fault"} ${fault}: ${name}`),
          joint ? make("b", { className: "joint" }, joint) : ""),
        make("p", {}, means ? `${means[0].toUpperCase()}${means.slice(1)}.` : ""),
        make("p", {}, make("b", {}, "To do: "), todo ? `${todo}.` : "see docs/faults.md."),
        ...(isWarning || !head.commands ? [] : [clear]));
    },
  };
};
