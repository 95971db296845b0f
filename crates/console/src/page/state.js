// The supervisor's states in words, and what the page may ask for in each of them.

// By state: its colour, and what may move.
const STATES = {
  off: ["quiet", "Torque is off. Not every servo was read yet."],
  limp: ["quiet", "Torque is off. It moves only by hand."],
  calibrating: ["quiet", "Torque is off. You move it by hand."],
  teaching: ["quiet", "Torque is off. You move it by hand."],
  arming: ["moves", "Torque comes on. It stays where it is."],
  holding: ["holds", "Torque is on. It stands still, and moves when asked."],
  playing: ["moves", "It moves."],
  floating: ["moves", "It carries its own weight. You lead it by hand."],
  maintenance: ["moves", "One operator jogs it slowly."],
  stopping: ["sinks", "It moves to its rest pose, then sinks."],
  lowering: ["sinks", "It sinks. Torque fades."],
  faulted: ["fault", "Torque is off. A fault is latched."],
};
const UNKNOWN = ["quiet", ""];

export const nameOf = (head, frame) => (head.states[frame.state] ?? "unknown").toLowerCase();
export const colorOf = (name) => (STATES[name] ?? UNKNOWN)[0];

// Returns what may move.
export const movesOf = (name, frame) => {
  if (name !== "playing") return (STATES[name] ?? UNKNOWN)[1];
  if (frame.isShow) return "A show moves it.";
  return frame.isJog ? "It follows a slider." : "It follows a stream, or goes to a pose.";
};

const isOn = (name) => !["off", "limp", "calibrating", "teaching", "faulted", "unknown"].includes(name);

// Returns which commands make sense now. A page without a connection, or of a recording, may ask for nothing.
export const permissions = ({ head, frame, isConnected, isDriver, isStale, name }) => {
  const isLive = isConnected && frame !== null && head !== null && head.commands;
  const may = isLive && isDriver && !isStale && !frame.isLinkLost;
  const isFree = name === "holding" || (name === "playing" && frame?.isJog && !frame.isShow);
  return {
    hold: isLive,
    stop: isLive,
    estop: isLive,
    arm: may && name === "limp",
    lower: may && isOn(name) && name !== "lowering",
    home: may && isFree,
    clear: may && frame?.fault !== null,
    play: may && isFree,
    jog: may && isFree,
    follow: may && isFree,
    seek: isConnected && head !== null && frame !== null,
    upload: may && !isOn(name),
  };
};
