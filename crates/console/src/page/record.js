// The button that begins and ends a recording of the session, and the name of its file.

import { byId, setDisabled, setHidden, write } from "./dom.js";

// `ask` sends a command, `report` shows its result.
export const record = (ask, report) => {
  const button = byId("record");
  let file = null;
  button.addEventListener("click", async () => report("record", await ask({ type: "record", on: file === null })));
  const show = () => {
    write(button, file === null ? "Record" : "End recording");
    button.classList.toggle("on", file !== null);
    setHidden(byId("recording"), file === null);
    setHidden(byId("record-file"), file === null);
    write(byId("record-file"), file === null ? "" : `Recording into ${file}`);
  };
  show();
  return {
    set: (message) => { file = message.file; show(); },
    allow: (mayRecord) => setDisabled(button, !mayRecord),
  };
};
