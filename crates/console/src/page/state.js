// The supervisor's states in words, and the commands that the page may send in each of them.

// For each state: its colour, and a text that says what may move.
const STATES = {
  off: ["quiet", "Torque is off. Not every servo has answered yet."],
  limp: ["quiet", "Torque is off. The rig moves only by hand."],
  calibrating: ["quiet", "Torque is off. You move the rig by hand."],
  teaching: ["quiet", "Torque is off. You move the rig by hand."],
  arming: ["moves", "Torque is switched on. The rig stays where it is."],
  holding: ["holds", "Torque is on. The rig stands still, and moves on command."],
  playing: ["moves", "The rig moves."],
  floating: ["moves", "The rig carries its own weight. You lead it by hand."],
  maintenance: ["moves", "One operator moves the rig slowly."],
  stopping: ["sinks", "The rig moves to its rest pose, then sinks."],
  lowering: ["sinks", "The rig sinks. Torque fades."],
  faulted: ["fault", "Torque is off. A fault is latched."],
};
const UNKNOWN = ["quiet", ""];

export const nameOf = (head, frame) => (head.states[frame.state] ?? "unknown").toLowerCase();
export const colorOf = (name) => (STATES[name] ?? UNKNOWN)[0];

// Returns the word for a state. The supervisor has one state for shows and other motions, and a recording does not tell
// which of them it was.
export const wordOf = (head, frame, name) => name === "playing" && head.commands && !frame.isShow ? "moving" : name;

// Returns the text that says what may move.
export const movesOf = (head, frame, name) => {
  if (name !== "playing" || !head.commands) return (STATES[name] ?? UNKNOWN)[1];
  if (frame.isShow) return "A show moves the rig.";
  return frame.isJog ? "The rig follows a slider." : "The rig follows a stream, or goes to a pose.";
};

const isOn = (name) => !["off", "limp", "calibrating", "teaching", "faulted", "unknown"].includes(name);

// Returns which commands the page may send now. Without a connection, or for a recording, it may send none.
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
    idle: may && (name === "holding" || name === "playing") && !frame.isShow,
    jog: may && isFree,
    follow: may && isFree,
    seek: isConnected && head !== null && frame !== null,
    record: isLive && isDriver,
    upload: may && !isOn(name),
  };
};
