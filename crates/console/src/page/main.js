// The console's page: messages of the hub go to the parts of the page, commands go to the hub.

import { charts } from "./charts.js";
import { byId, make, number, seconds, setDisabled, setHidden, write } from "./dom.js";
import { history } from "./history.js";
import { joints } from "./joints.js";
import { log } from "./log.js";
import { record } from "./record.js";
import { safety } from "./safety.js";
import { servos } from "./servos.js";
import { show } from "./show.js";
import { connect } from "./socket.js";
import { colorOf, movesOf, nameOf, permissions, wordOf } from "./state.js";
import { tabs } from "./tabs.js";
import { view } from "./view.js";

const SOURCES = { simulated: "simulated rig", board: "real board", recording: "recording" };
// An older frame does not show where the rig is now.
const STALE_MS = 1500;
const RATE_OVER_MS = 2000;
const FRAMES_BETWEEN_TEXTS_MS = 100;

let head = null, headText = "", frame = null, frameAt = 0, isConnected = false, role = { driver: false, other: null };
let parts = null, chosen = 0, textsAt = 0, refused = null;
const arrivals = [];

const socket = connect({
  head: (message) => {
    isConnected = true;
    // The view, the camera and the charts stay while only the line's rate changes.
    const text = JSON.stringify({ ...message, line_rate_hz: null });
    if (text === headText) Object.assign(head, message);
    else { headText = text; setHead(message); }
    refresh();
  },
  shows: (message) => shows.setShows(message),
  role: (message) => { role = message; refresh(); },
  event: (message) => events.add(message),
  record: (message) => recording.set(message),
  progress: ({ done }) => shows.setProgress(done),
  frame: (now) => takeFrame(now),
  closed: ({ isRefused, reason }) => {
    isConnected = false;
    refused = isRefused ? `${reason || "The token in the address is wrong, or belongs to an earlier console"}.` : null;
    frame = null;
    parts?.joints.release();
    refresh();
  },
});

const report = (what, { ok, text }) => {
  const answer = byId("answer");
  answer.className = ok ? "ok" : "refused";
  write(answer, `${what}: ${text || (ok ? "done" : "refused")}`);
};
const shows = show({ send: socket.send, ask: socket.ask, report });
const events = log(socket.ask, report);
const recording = record(socket.ask, report);
const guard = safety(socket.ask, report);
guard.onHold(() => parts?.joints.release());
tabs(["joints", "servos", "log"], (name) => { if (name === "log") events.read(); });

const choose = (joint) => {
  if (!parts || joint < 0) return;
  chosen = joint;
  parts.view.choose(joint);
  parts.joints.focus(joint);
  parts.charts.choose(joint);
};

const setHead = (message) => {
  head = message;
  parts?.joints.dispose();
  document.title = `${head.rig} · Sinew console`;
  write(byId("rig-name"), head.rig);
  write(byId("source"), SOURCES[head.source] ?? head.source);
  byId("source").className = head.source;
  for (const id of ["commands", "hold", "wheel-box", "record"]) setHidden(byId(id), !head.commands);
  document.body.classList.toggle("watching", !head.commands);
  const past = history(head);
  parts = {
    view: view(head, choose), joints: joints(head, { send: socket.send, choose }), servos: servos(head, choose),
    history: past, charts: charts(head, past),
  };
  events.setHead(head);
  shows.setHead(head);
  choose(Math.min(chosen, head.dofs.length - 1));
};

byId("wheel").addEventListener("click", async () => {
  const take = !role.driver;
  report(take ? "take the wheel" : "give the wheel back", await socket.ask({ type: "wheel", take }));
});

const takeFrame = (now) => {
  if (!parts) return;
  frame = now;
  frameAt = performance.now();
  arrivals.push(frameAt);
  while (arrivals.length > 0 && frameAt - arrivals[0] > RATE_OVER_MS) arrivals.shift();
  const swings = events.swinging();
  parts.history.take(frame, frameAt);
  parts.view.take(frame, swings);
  refresh(swings);
};

const rate = () => arrivals.length < 2 ? NaN : (arrivals.length - 1) * 1000 / (arrivals.at(-1) - arrivals[0]);

const isStale = () => frame !== null && performance.now() - frameAt > STALE_MS;

// ---- Lost: the page disables its controls ----
const lost = () => {
  if (refused) return ["Not let in", `${refused} Open the address that the console printed.`];
  if (!isConnected) {
    return headText === "" ? ["Connecting", "to the console"]
      : ["Connection lost", "This page controls nothing now. A joint that followed a slider holds. The page tries to connect again …"];
  }
  if (isStale()) {
    return ["No news", `from the rig for ${seconds((performance.now() - frameAt) / 1000)}. The picture is old.`];
  }
  if (frame?.isLinkLost) return ["Board silent", "The console receives nothing from the board. On its own, the board holds the rig, then lowers it."];
  return null;
};

const vitals = () => {
  const line = Number.isFinite(head.line_rate_hz) && head.line_rate_hz !== null ? ` (line: ${number(head.line_rate_hz, 0)})` : "";
  return [
    ["", "poses", `${number(rate(), 0)} Hz${line}`],
    ["", "supply", frame.supply > 0 ? `${number(frame.supply, 1)} V` : "–"],
    ["more", "tick", `${frame.tick} us`],
    ["more", "time", seconds(frame.t)],
  ];
};

// Updates the page from the newest messages. Texts change at most ten times a second, so that people can read them.
const refresh = (swings = new Set()) => {
  const name = head && frame ? nameOf(head, frame) : "unknown";
  const loss = lost();
  const may = permissions({ head, frame, isConnected, isDriver: role.driver, isStale: isStale(), name });
  document.body.classList.toggle("lost-now", loss !== null);
  document.body.classList.toggle("waiting", headText === "" && !refused);
  setHidden(byId("lost"), loss === null);
  if (loss) { write(byId("lost-title"), loss[0]); write(byId("lost-text"), loss[1]); }
  guard.allow(may);
  shows.allow(may);
  recording.allow(may.record);
  parts?.joints.allow(may.jog);
  events.show(frame?.fault ?? null, may.clear);
  setDisabled(byId("wheel"), !isConnected);
  setHidden(byId("wheel"), false);
  const isOther = role.other && role.other !== "null";
  write(byId("wheel"), role.driver ? (role.asked ? "Give the wheel" : "Give it back") : isOther ? "Ask for the wheel" : "Take the wheel");
  byId("wheel").classList.toggle("go", !role.driver || role.asked === true);
  write(byId("role"), role.driver ? (role.asked ? "Another page asks for the wheel" : "This page drives")
    : isOther ? `Viewing: a ${role.other} drives` : "Viewing: nobody drives");
  if (!frame || !parts) {
    write(byId("state"), isConnected ? "waiting" : "not connected");
    write(byId("moves"), "");
    byId("state-box").className = "state quiet";
    return;
  }
  parts.joints.take(frame);
  parts.charts.take(performance.now());
  shows.take(frame);
  write(byId("state"), wordOf(head, frame, name));
  write(byId("moves"), movesOf(head, frame, name));
  byId("state-box").className = `state ${colorOf(name)}`;
  if (performance.now() - textsAt < FRAMES_BETWEEN_TEXTS_MS) return;
  textsAt = performance.now();
  parts.servos.take(frame, swings);
  byId("vitals").replaceChildren(...vitals().map(([className, key, value]) => make("div", { className }, make("dt", {}, key), make("dd", {}, value))));
  write(byId("joints-hint"), !head.commands ? "Measured and commanded positions of the recording."
    : may.jog ? "Move a slider: the joint follows while you hold the slider, and stops when you release it. Arrow keys: 1°, with Shift 5°."
    : role.driver ? `Sliders move the rig only while it holds; now it is ${name}.` : "Only the page that drives can move sliders: take the wheel first.");
};
// On a phone, the rig stays visible below the head, whose height depends on its text.
new ResizeObserver(([{ target }]) => document.documentElement.style.setProperty("--head", `${target.offsetHeight}px`))
  .observe(document.querySelector("header"));
setInterval(() => { if (isStale()) refresh(); }, 500);
refresh();
