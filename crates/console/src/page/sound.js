// Plays the sound of a show, and corrects its speed so that it follows the board's time in the show.

import { byId, setDisabled, setHidden, write } from "./dom.js";

// Time by which the start is planned ahead, so that the first sample is not late, s.
const AHEAD_S = 0.03;
// Largest change of the speed; and drift from which the sound jumps instead, s.
const RATE_MOST = 0.005;
const JUMP_S = 0.08;
// Share of the drift that is corrected in a second; and interval of corrections, s.
const GAIN = 0.4;
const STEER_EVERY_S = 0.25;
// The board's times arrive late, never early. The one with the least delay within this window counts, s. If all are
// late, the clock falls behind by no more than this share of the time, because the board's clock is even, unless they
// are later by this time: then the board's clock has changed, s.
const WINDOW_S = 2;
const FALL = 0.005;
const SHIFT_S = 0.03;
// The start of a show is expected. The sound is planned at most this long before it, s.
const BEFORE_S = 0.2;
const FADE_S = 0.005;
const GRAIN_S = 0.08;
const GRAIN_EVERY_MS = 60;
// If no frame arrives for this time, the state of the rig is unknown, and the sound stops, ms.
const SILENT_MS = 500;
// Time from the start of the show to the measurement of the sound's first drift, s.
const START_AFTER_S = 0.5;

const now = () => performance.now() / 1000;

// Estimates the board's time in the show from the times in the frames.
export const placeClock = () => {
  let seen = [], lead = NaN, since = 0;
  return {
    reset: () => { seen = []; lead = NaN; },
    take: (place, at) => {
      const last = seen.at(-1);
      // A loop or the show has started again.
      const isNew = !last || Math.abs(place - at - last.lead) > 0.5;
      if (isNew) [seen, since] = [[], at];
      seen.push({ lead: place - at, at });
      while (seen[0].at < at - WINDOW_S) seen.shift();
      const best = Math.max(...seen.map((one) => one.lead));
      const isChanged = isNew || at - since > WINDOW_S && lead - best > SHIFT_S;
      lead = isChanged ? best : Math.max(best, lead - FALL * (at - last.at));
    },
    place: (at) => at + lead,
  };
};

export const sound = () => {
  const [box, toggle, text] = ["sound", "sound-on", "sound-text"].map(byId);
  const clock = placeClock();
  const buffers = new Map();
  let context = null, gain = null, source = null, base = null, chosen = null, isOn = true, steeredAt = 0, grainAt = 0, tookAt = 0;
  let drifts = { begun: 0, start: NaN, now: NaN, most: 0 };

  // Browsers permit sound only after a gesture on the page.
  const wake = () => {
    if (!chosen) return;
    if (!context) {
      context = new AudioContext({ latencyHint: "interactive" });
      gain = new GainNode(context);
      gain.connect(context.destination);
    }
    if (context.state === "suspended") context.resume().catch(() => {});
  };
  addEventListener("pointerdown", wake);
  addEventListener("keydown", wake);

  const load = async ({ hash }) => {
    if (buffers.has(hash)) return;
    buffers.set(hash, null);
    try {
      const answer = await fetch(`/sound/${hash}`);
      if (!answer.ok) throw new Error(`the console has no such sound (${answer.status})`);
      // Decoding needs no gesture.
      const bytes = await answer.arrayBuffer();
      buffers.set(hash, await new OfflineAudioContext(1, 1, 48000).decodeAudioData(bytes));
      show();
    } catch (error) {
      buffers.delete(hash);
      write(text, `no sound: ${error.message}`);
    }
  };
  const buffer = () => chosen ? buffers.get(chosen.hash) ?? null : null;

  // Returns the time of the audio context that is heard at a time of the page.
  const heardAt = (at) => {
    const { contextTime, performanceTime } = context.getOutputTimestamp();
    if (performanceTime > 0) return contextTime + at - performanceTime / 1000;
    return context.currentTime - (context.outputLatency || 0) + at - now();
  };
  const placeOfSound = (at) => base.place + (heardAt(at) - base.at) * base.rate;

  const quiet = () => {
    if (!source) return;
    const { node, level } = source;
    level.gain.setTargetAtTime(0, context.currentTime, FADE_S / 3);
    node.stop(context.currentTime + FADE_S);
    source = base = null;
  };
  const play = (place, at, length) => {
    const level = new GainNode(context, { gain: 0 });
    const node = new AudioBufferSourceNode(context, { buffer: buffer() });
    node.connect(level).connect(gain);
    level.gain.setTargetAtTime(1, at, FADE_S / 3);
    if (length) {
      level.gain.setTargetAtTime(0, at + length - FADE_S, FADE_S / 3);
      node.start(at, place, length);
    } else {
      node.start(at, place);
    }
    return { node, level };
  };
  // Starts the sound at the time that the show will have when the first sample is heard.
  const start = () => {
    const ahead = now() + AHEAD_S;
    let at = Math.max(heardAt(ahead), context.currentTime + 0.003);
    let place = clock.place(ahead) + at - heardAt(ahead);
    if (place < -BEFORE_S) return;
    if (place < 0) { at -= place; place = 0; }
    place += chosen.offset_s;
    if (place < 0) { at -= place; place = 0; }
    if (place >= buffer().duration) return;
    source = play(place, at);
    base = { at, place, rate: 1 };
    steeredAt = now();
  };
  const steer = () => {
    const at = now();
    if (heardAt(at) < base.at) return;
    const drift = placeOfSound(at) - (clock.place(at) + chosen.offset_s);
    drifts.now = drift;
    if (at - drifts.begun > START_AFTER_S) {
      if (Number.isNaN(drifts.start)) drifts.start = drift;
      drifts.most = Math.max(drifts.most, Math.abs(drift));
    }
    if (Math.abs(drift) > JUMP_S) { quiet(); start(); return; }
    if (at - steeredAt < STEER_EVERY_S) return;
    steeredAt = at;
    const change = context.currentTime;
    base = { at: change, place: base.place + (change - base.at) * base.rate,
      rate: 1 - Math.min(Math.max(GAIN * drift, -RATE_MOST), RATE_MOST) };
    source.node.playbackRate.setValueAtTime(base.rate, change);
  };

  const milliseconds = (s) => `${(1000 * s).toFixed(0)} ms`;
  const show = () => {
    setHidden(box, !chosen);
    if (!chosen) return;
    toggle.textContent = isOn ? "Sound off" : "Sound on";
    setDisabled(toggle, !buffer());
    const measured = Number.isNaN(drifts.start) ? ""
      : `, start off by ${milliseconds(drifts.start)}, drift ${milliseconds(drifts.now)}, at most ${milliseconds(drifts.most)}`;
    write(text, `${chosen.name}${buffer() ? measured : " is loading"}`);
    Object.assign(box.dataset, { start: drifts.start, drift: drifts.now, most: drifts.most, plays: source !== null });
  };
  setInterval(() => {
    if (!source || performance.now() - tookAt < SILENT_MS) return;
    quiet();
    clock.reset();
    show();
  }, SILENT_MS / 2);
  toggle.addEventListener("click", () => { isOn = !isOn; wake(); if (!isOn) quiet(); show(); });

  return {
    // Selects the sound of the chosen show; null for none.
    choose: (of) => {
      if (chosen?.hash !== of?.hash || chosen?.offset_s !== of?.offset_s) quiet();
      chosen = of ?? null;
      if (chosen) load(chosen);
      show();
    },
    // Receives a frame: whether a show plays, and its time in the show.
    take: (isShow, place) => {
      tookAt = performance.now();
      // It is negative before the show starts, and 0 if the start is not known or is late.
      const runs = isShow && Number.isFinite(place) && place !== 0;
      if (!(runs && place > 0)) drifts = { begun: now(), start: NaN, now: NaN, most: 0 };
      if (!runs) {
        quiet();
        clock.reset();
        if (chosen) box.dataset.plays = "false";
        return;
      }
      clock.take(place, now());
      if (!chosen || !isOn || !buffer() || context?.state !== "running") return;
      if (source) {
        steer();
      } else {
        start();
      }
      show();
    },
    // Plays a short piece of the sound at a time of the show, while the user moves the time line.
    scrub: (place) => {
      if (!chosen || !isOn || !buffer() || source || context?.state !== "running") return;
      const at = place + chosen.offset_s;
      if (performance.now() - grainAt < GRAIN_EVERY_MS || at < 0 || at >= buffer().duration) return;
      grainAt = performance.now();
      play(at, context.currentTime + 0.003, GRAIN_S);
    },
  };
};
