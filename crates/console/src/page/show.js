// The time line of the show: its cues, the ghost that the user moves on it, and uploads of shows.

import { byId, make, seconds, setDisabled, setHidden, write } from "./dom.js";
import { sound } from "./sound.js";

const SEEK_EVERY_MS = 50;

export const show = ({ send, ask, report }) => {
  const [slots, scrub, play, follow, clear, loop] = ["slots", "scrub", "play", "follow", "no-ghost", "loop"].map(byId);
  const idle = byId("idle");
  const voice = sound();
  let shows = [], isRecording = false, ghost = null, isScrubbing = false, isPlaying = false, uploading = false, isIdle = false;

  const chosen = () => shows.find(({ slot }) => String(slot) === slots.value);
  // The hub has no cues and no duration of a show that it did not upload.
  const shown = () => ({ cues: chosen()?.cues ?? [], duration: chosen()?.duration_s ?? 0 });

  // ---- Scrubbing: at most one message in 50 ms, and always the last one ----
  let sentAt = 0, later = 0;
  const seek = (t) => {
    clearTimeout(later);
    const wait = SEEK_EVERY_MS - (performance.now() - sentAt);
    if (wait > 0 && t !== null) { later = setTimeout(seek, wait, t); return; }
    sentAt = performance.now();
    send(t === null ? { type: "seek", t: null } : { type: "seek", slot: chosen()?.slot ?? 0, t });
  };
  const goTo = (t) => {
    if (scrub.disabled) return;
    ghost = isRecording ? null : t;
    scrub.value = t;
    seek(t);
    voice.scrub(t);
  };
  const clearGhost = () => {
    if (ghost === null) return;
    ghost = null;
    seek(null);
  };
  scrub.addEventListener("pointerdown", () => { isScrubbing = true; });
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => { isScrubbing = false; });
  scrub.addEventListener("input", () => goTo(Number(scrub.value)));
  scrub.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (!way || scrub.disabled) return;
    event.preventDefault();
    goTo(Math.min(Math.max(Number(scrub.value) + way * (event.shiftKey ? 1 : 0.1), 0), Number(scrub.max)));
  });
  clear.addEventListener("click", clearGhost);

  // ---- The show that is chosen ----
  const lay = () => {
    const { cues, duration } = shown();
    voice.choose(chosen()?.sound ?? null);
    scrub.max = Math.max(duration, 0.001);
    byId("cues").replaceChildren(...cues.map((cue) => {
      const button = make("button", { type: "button", className: "cue", title: `${cue.name}, ${seconds(cue.t)}` },
        make("span", {}, cue.name));
      button.style.setProperty("--at", String(duration > 0 ? cue.t / duration : 0));
      button.addEventListener("click", () => goTo(cue.t));
      return button;
    }));
    write(byId("duration"), duration > 0 ? seconds(duration) : "");
  };
  slots.addEventListener("change", () => { clearGhost(); scrub.value = 0; lay(); });
  const name = ({ slot, name: text, duration_s: duration }) =>
    isRecording ? text : `${slot}: ${text}${duration > 0 ? ` (${seconds(duration)})` : ""}`;

  play.addEventListener("click", async () => {
    if (isRecording && isPlaying) { send({ type: "hold" }); return; }
    clearGhost();
    report("play", await ask({ type: "play", slot: chosen().slot, loop: loop.checked }));
  });
  idle.addEventListener("change", async () => {
    report("idle life", await ask({ type: "idle", on: idle.checked }));
    // The hub decides: its message sets the box again.
    idle.checked = isIdle;
  });
  follow.addEventListener("click", async () => {
    report("go there", await ask({ type: "follow", slot: chosen().slot, t: ghost }));
  });

  // ---- Upload ----
  const progress = byId("progress");
  byId("upload").addEventListener("submit", async (event) => {
    event.preventDefault();
    const [file] = byId("file").files;
    if (!file || uploading) return;
    uploading = true;
    progress.value = 0;
    setHidden(progress, false);
    const command = { type: "upload", name: file.name.replace(/\.[^.]*$/, ""), slot: Number(byId("slot").value) };
    report(`upload of ${file.name}`, await ask(command, await file.arrayBuffer()));
    uploading = false;
    setHidden(progress, true);
  });

  return {
    setHead: (head) => {
      isRecording = head.source === "recording";
      for (const element of [follow, clear, byId("play-moves"), byId("uploads")]) setHidden(element, isRecording);
      scrub.setAttribute("aria-label", isRecording ? "Time in the recording" : "Time in the show: moves the ghost, not the rig");
    },
    setShows: (message) => {
      const before = slots.value;
      shows = message.slots;
      isIdle = message.idle?.on ?? false;
      setHidden(byId("idle-box"), !message.idle);
      byId("idle-box").title = message.idle ? `The loop ${message.idle.name}, between shows` : "";
      idle.checked = isIdle;
      slots.replaceChildren(...shows.map((one) => make("option", { value: String(one.slot) }, name(one))));
      if (shows.length === 0) slots.append(make("option", { value: "" }, "no show on the board"));
      const wanted = [before, String(message.loaded ?? "")].find((value) => shows.some(({ slot }) => String(slot) === value));
      if (wanted !== undefined) slots.value = wanted;
      const free = Math.max(-1, ...shows.map(({ slot }) => slot)) + 1;
      const numbers = [...shows.map(({ slot }) => slot), free].sort((a, b) => a - b);
      byId("slot").replaceChildren(...numbers.map((slot) =>
        make("option", { value: String(slot) }, slot === free ? `${slot} (free)` : String(slot))));
      byId("slot").value = String(free);
      lay();
    },
    setProgress: (done) => { progress.value = done; },
    allow: (may) => {
      const has = chosen() !== undefined;
      // A show may interrupt idle life.
      setDisabled(play, !has || !(isRecording ? may.seek : may.play || isIdle && may.idle));
      setDisabled(idle, !may.idle);
      setDisabled(follow, !may.follow || ghost === null);
      setDisabled(clear, ghost === null || !may.seek);
      setDisabled(scrub, shown().duration <= 0 || !may.seek);
      for (const element of byId("upload").querySelectorAll("input, select, button")) setDisabled(element, !may.upload || uploading);
    },
    take: (frame) => {
      isPlaying = frame.isShow;
      const { place } = frame;
      voice.take(isPlaying && !isRecording, place);
      const { cues, duration } = shown();
      const at = ghost ?? (Number.isFinite(place) ? Math.max(place, 0) : Number(scrub.value));
      if (!isScrubbing && document.activeElement !== scrub || ghost === null && !isScrubbing) scrub.value = at;
      scrub.setAttribute("aria-valuetext", seconds(at));
      byId("done").style.setProperty("--at", Number.isFinite(place) && duration > 0 ? String(Math.min(Math.max(place / duration, 0), 1)) : "0");
      write(byId("place"), ghost === null
        ? (place < 0 ? `begins in ${seconds(-place)}` : Number.isFinite(place) ? seconds(place) : "not playing")
        : `ghost at ${seconds(ghost)}${Number.isFinite(place) ? `, rig at ${seconds(place)}` : ""}`);
      const cue = cues.filter(({ t }) => t <= at + 1e-6).at(-1);
      write(byId("near"), cue ? cue.name : "");
      write(byId("play-text"), !isPlaying ? "Play" : isRecording ? "Pause" : "Playing");
      play.classList.toggle("on", isPlaying);
    },
  };
};
