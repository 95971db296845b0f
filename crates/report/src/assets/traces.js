// ---- Packed traces over time ----
const SHOW = JSON.parse(document.getElementById("show-data").textContent);
const END = (SHOW.count - 1) * SHOW.dt_s;

// An unknown value becomes NaN.
const UNKNOWN_STEPS = -32768;
const unpack = ({ middle, unit, data }) => {
  const course = new Float32Array(SHOW.count).fill(middle);
  if (data === "") return course;
  const packed = new Int16Array(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer);
  return course.map((_, sample) => packed[sample] === UNKNOWN_STEPS ? NaN : middle + unit * packed[sample]);
};
const COURSES = Object.fromEntries(Object.entries(SHOW.courses).map(([kind, all]) => [kind, all.map(unpack)]));

// Returns the sample before a time, and the share of the time to the next sample.
const placeOf = (time) => {
  const sample = Math.min(Math.floor(time / SHOW.dt_s), Math.max(SHOW.count - 2, 0));
  return [sample, SHOW.count > 1 ? Math.min(time / SHOW.dt_s - sample, 1) : 0];
};
const between = (course, [sample, share]) =>
  course[sample] * (1 - share) + course[Math.min(sample + 1, SHOW.count - 1)] * share;

// Returns the horizontal position of a driven base; zero for a fixed base.
const wayOf = (poses) => RIG.bodies[0].kind === "free" ? [poses[0].p[0], 0, poses[0].p[2]] : [0, 0, 0];

// Returns all visible points over the whole time, relative to the base. `takePose` sets the rig to its pose at a time.
const everywhere = () => {
  const LOOKS = 60;
  return Array.from({ length: LOOKS + 1 }, (_, look) => {
    takePose(END * look / LOOKS);
    const poses = solve();
    return pointsOf(poses).map((point) => sub(point, wayOf(poses)));
  }).flat();
};
