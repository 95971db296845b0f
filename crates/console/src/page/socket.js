// The connection to the hub. If it is lost, the page shows this and connects again. Without it, the page sends nothing.

import { decode } from "./frame.js";

const WRONG_TOKEN = 4001;
const AGAIN_MS = [500, 1000, 2000, 3000];

// `on`: functions by type of message, and the functions `frame`, `open` and `closed`.
export const connect = (on) => {
  const token = location.hash.slice(1);
  const answers = new Map();
  let socket = null, tries = 0, commands = 0;

  const isOpen = () => socket?.readyState === WebSocket.OPEN;
  // Sends a message, and returns whether it was sent.
  const send = (message) => {
    if (!isOpen()) return false;
    socket.send(JSON.stringify(message));
    return true;
  };
  // Sends a command, and returns its answer. `after`: bytes that follow it.
  const ask = (message, after = null) => new Promise((resolve) => {
    const id = ++commands;
    if (!send({ ...message, id })) { resolve({ ok: false, text: "no connection" }); return; }
    answers.set(id, resolve);
    if (after) socket.send(after);
  });
  const forget = () => {
    for (const resolve of answers.values()) resolve({ ok: false, text: "the connection was lost before the answer arrived" });
    answers.clear();
  };

  const take = (message) => {
    if (message.type === "answer") {
      answers.get(message.id)?.(message);
      answers.delete(message.id);
    } else {
      on[message.type]?.(message);
    }
  };
  const open = () => {
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => send({ type: "hello", token }));
    socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") {
        tries = 0;
        take(JSON.parse(data));
      } else {
        const frame = decode(data);
        if (frame) on.frame(frame);
      }
    });
    socket.addEventListener("close", ({ code, reason }) => {
      forget();
      const isRefused = code === WRONG_TOKEN;
      on.closed({ isRefused, reason });
      if (isRefused) return;
      setTimeout(open, AGAIN_MS[Math.min(tries, AGAIN_MS.length - 1)]);
      tries += 1;
    });
  };
  // The hub holds the rig if the page that drives sends nothing for 2 s.
  new Worker("/ping.js").addEventListener("message", () => send({ type: "ping", t: Math.round(performance.now()) }));
  open();
  return { send, ask, isOpen };
};
