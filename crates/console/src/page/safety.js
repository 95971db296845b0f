// The commands that switch torque, and the commands that end motion.

import { byId, setDisabled, write } from "./dom.js";

const ARM_MS = 1000;

const isTyping = (target) => target.matches?.("input:not([type=range]):not([type=checkbox]), textarea");

// `ask` sends a command, `report` shows its result.
export const safety = (ask, report) => {
  const buttons = Object.fromEntries(
    ["hold", "arm", "home", "stop", "lower", "estop"].map((name) => [name, byId(name)]));
  const holdListeners = [];

  const send = async (type) => report(type, await ask({ type }));
  const hold = () => {
    if (buttons.hold.disabled) return;
    for (const listener of holdListeners) listener();
    send("hold");
  };
  // A press is enough: the rig must hold even if the finger slips off the button.
  buttons.hold.addEventListener("pointerdown", (event) => { if (event.button === 0) hold(); });
  // A click without a pointer comes from a key or a screen reader.
  buttons.hold.addEventListener("click", (event) => { if (event.detail === 0) hold(); });
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !event.repeat) { event.preventDefault(); hold(); }
    // The space bar must not scroll the page, or press a button that has the focus by chance.
    if (event.key === " " && !isTyping(event.target) && event.target.type !== "checkbox"
      && !event.target.matches?.("button, select, summary")) event.preventDefault();
  }, true);
  for (const name of ["home", "stop", "lower", "estop"]) buttons[name].addEventListener("click", () => send(name));

  // ---- Arming: a gesture of a second ----
  const { arm } = buttons;
  let since = null, frame = 0;
  const cancel = () => {
    since = null;
    cancelAnimationFrame(frame);
    arm.style.setProperty("--done", "0");
    arm.classList.remove("held");
  };
  const tick = (now) => {
    if (since === null) return;
    if (arm.disabled) { cancel(); return; }
    const done = Math.min((now - since) / ARM_MS, 1);
    arm.style.setProperty("--done", String(done));
    if (done < 1) { frame = requestAnimationFrame(tick); return; }
    cancel();
    send("arm");
  };
  const begin = () => {
    if (since !== null || arm.disabled) return;
    since = performance.now();
    arm.classList.add("held");
    frame = requestAnimationFrame(tick);
  };
  arm.addEventListener("pointerdown", (event) => { if (event.button === 0) { arm.setPointerCapture(event.pointerId); begin(); } });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) arm.addEventListener(end, cancel);
  arm.addEventListener("pointermove", (event) => {
    const { left, right, top, bottom } = arm.getBoundingClientRect();
    const isInside = left <= event.clientX && event.clientX <= right && top <= event.clientY && event.clientY <= bottom;
    if (since !== null && !isInside) cancel();
  });
  arm.addEventListener("contextmenu", (event) => event.preventDefault());
  // Enter arms if it is held for the same time; the space bar never arms.
  arm.addEventListener("keydown", (event) => {
    if (event.key === "Enter") { event.preventDefault(); begin(); }
    if (event.key === " ") event.preventDefault();
  });
  arm.addEventListener("keyup", (event) => {
    if (event.key === " ") event.preventDefault();
    cancel();
  });
  addEventListener("blur", cancel);
  document.addEventListener("visibilitychange", cancel);
  holdListeners.push(cancel);

  return {
    onHold: (listener) => holdListeners.push(listener),
    allow: (may) => {
      for (const [name, button] of Object.entries(buttons)) setDisabled(button, !may[name]);
      write(byId("hold-text"), may.hold ? "stands still at once" : "no connection: does nothing");
    },
  };
};
