// A slider for each joint. A joint is jogged while its slider is held, and holds when it is released.

import { byId, make, position, scaleOf, setDisabled, write } from "./dom.js";

const JOG_EVERY_MS = 50;
// A tap on an arrow key moves the joint by STEP. The joint is released when it arrives, or after TAP_MS.
const STEP = { turn: Math.PI / 180, slide: 0.001 };
const LARGE = 5;
const TAP_MS = 1500;

const KEYS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };

// `send` sends a message; `choose` is called with the joint whose slider is used.
export const joints = (head, { send, choose }) => {
  let held = null, timer = 0, later = 0, isAllowed = false, isPressed = false;

  const jog = () => { if (held) send({ type: "jog", dof: held.dof, goal: held.goal }); };
  const release = () => {
    clearTimeout(later);
    if (!held) return;
    clearInterval(timer);
    send({ type: "release", dof: held.dof });
    rows[held.dof].item.classList.remove("held");
    held = null;
  };
  const begin = (dof) => {
    clearTimeout(later);
    if (held?.dof === dof) return;
    release();
    held = { dof, goal: shown[dof], isTap: false };
    rows[dof].item.classList.add("held");
    timer = setInterval(jog, JOG_EVERY_MS);
  };
  // Lets the step be made, then releases the joint.
  const tap = () => {
    held.isTap = true;
    later = setTimeout(release, TAP_MS);
  };
  const within = (dof, x) => Math.min(Math.max(x, head.dofs[dof].range[0]), head.dofs[dof].range[1]);
  // Values of the sliders that nobody holds.
  const shown = head.dofs.map((dof) => dof.home);

  const rows = head.dofs.map((dof, index) => {
    const id = `joint-${index}`;
    const value = make("output", { className: "value", htmlFor: id }, "–");
    const goal = make("span", { className: "goal" });
    const label = make("label", { htmlFor: id }, make("span", { className: "name" }, dof.name), goal, value);
    const slider = make("input", {
      type: "range", id, min: dof.range[0], max: dof.range[1], step: "any", value: dof.home, disabled: true,
    });
    const mark = make("div", { className: "mark" });
    const ends = make("div", { className: "ends" }, ...dof.range.map((x) =>
      make("span", {}, dof.limited ? position(dof, x) : "no limit")));
    const item = make("li", {}, label, make("div", { className: "track" }, slider, mark), ends);
    if (dof.coordinate === null) ends.replaceChildren("A ball joint: shown, but not moved by a slider.");
    if (dof.leader !== null) ends.replaceChildren(`Follows ${head.dofs[dof.leader].name}.`);
    item.addEventListener("pointerdown", () => choose(index));
    slider.addEventListener("focus", () => choose(index));
    slider.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || slider.disabled) return;
      isPressed = true;
      begin(index);
    });
    slider.addEventListener("input", () => {
      if (held?.dof !== index) {
        // After the command Hold, a pointer that is still pressed moves nothing.
        if (isPressed) return;
        // A new value without a pointer is a step of a screen reader.
        begin(index);
        tap();
      }
      held.goal = Number(slider.value);
      jog();
    });
    slider.addEventListener("keydown", (event) => {
      const way = KEYS[event.key];
      if (!way || slider.disabled) return;
      event.preventDefault();
      // After the command Hold, a key that is still pressed moves nothing.
      if (event.repeat && held?.dof !== index) return;
      begin(index);
      held.isTap = false;
      const step = (dof.slides ? STEP.slide : STEP.turn) * (event.shiftKey ? LARGE : 1);
      held.goal = within(index, held.goal + way * step);
      slider.value = held.goal;
      jog();
    });
    slider.addEventListener("keyup", (event) => {
      if (KEYS[event.key] && held?.dof === index) tap();
    });
    slider.addEventListener("blur", () => { if (held?.dof === index) release(); });
    return { item, slider, value, goal, mark };
  });
  byId("sliders").replaceChildren(...rows.map(({ item }) => item));

  const letGo = () => {
    isPressed = false;
    release();
  };
  for (const end of ["pointerup", "pointercancel", "blur"]) addEventListener(end, letGo);
  document.addEventListener("visibilitychange", release);

  return {
    release,
    dispose: () => {
      release();
      for (const end of ["pointerup", "pointercancel", "blur"]) removeEventListener(end, letGo);
      document.removeEventListener("visibilitychange", release);
    },
    focus: (joint) => {
      rows.forEach(({ item }, index) => item.classList.toggle("chosen", index === joint));
      rows[joint]?.item.scrollIntoView({ block: "nearest" });
    },
    allow: (mayJog) => {
      isAllowed = mayJog;
      if (!mayJog) release();
    },
    take: (frame) => {
      rows.forEach((row, index) => {
        const dof = head.dofs[index];
        const at = dof.coordinate;
        setDisabled(row.slider, !isAllowed || at === null || dof.leader !== null);
        if (at === null) return;
        const [measured, wanted] = [frame.measured[at], frame.wanted[at]];
        if (Number.isFinite(wanted)) shown[index] = wanted;
        else if (Number.isFinite(measured)) shown[index] = measured;
        const near = (dof.slides ? STEP.slide : STEP.turn) / 5;
        if (held?.dof === index && held.isTap && Math.abs(shown[index] - held.goal) < near) release();
        const goal = held?.dof === index ? held.goal : shown[index];
        if (held?.dof !== index) row.slider.value = goal;
        const spoken = position(dof, goal);
        if (row.slider.getAttribute("aria-valuetext") !== spoken) row.slider.setAttribute("aria-valuetext", spoken);
        write(row.value, position(dof, Number.isFinite(measured) ? measured : wanted));
        write(row.goal, held?.dof === index ? `to ${position(dof, goal)}` : "");
        const [least, most] = dof.range;
        const part = (measured - least) / (most - least || 1);
        row.mark.hidden = !Number.isFinite(part);
        row.mark.style.setProperty("--at", String(Math.min(Math.max(part, 0), 1)));
        const left = Math.min(measured - least, most - measured);
        row.item.classList.toggle("edge", dof.limited && left * scaleOf(dof) < 2);
      });
    },
  };
};
