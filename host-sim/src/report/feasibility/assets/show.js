
// ---- The show: its courses over time, and the rig's pose at a time ----
const SHOW = JSON.parse(document.getElementById("show-data").textContent);
const END = (SHOW.count - 1) * SHOW.dt_s;

const unpack = ({ middle, unit, data }) => {
  const course = new Float32Array(SHOW.count).fill(middle);
  if (data === "") return course;
  const packed = new Int16Array(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer);
  return course.map((_, sample) => middle + unit * packed[sample]);
};
const COORDINATES = SHOW.coordinates.map(unpack);
const COURSES = Object.fromEntries(
  ["speed", "acceleration", "effort"].map((kind) => [kind, SHOW[kind].map(unpack)]));

// Positions of a joint: of a ball joint its turn as a whole.
COURSES.position = RIG.freedoms.map(({ body, axis }) => {
  const first = FIRST[body];
  if (RIG.bodies[body].kind !== "spherical") return COORDINATES[first + axis];
  const [x, y, z, w] = COORDINATES.slice(first, first + 4);
  return x.map((_, sample) => 2 * Math.atan2(Math.hypot(x[sample], y[sample], z[sample]), Math.abs(w[sample])));
});

// Between which samples a time is: the first, and the share of the way to the next.
const placeOf = (time) => {
  const sample = Math.min(Math.floor(time / SHOW.dt_s), Math.max(SHOW.count - 2, 0));
  return [sample, SHOW.count > 1 ? Math.min(time / SHOW.dt_s - sample, 1) : 0];
};
const between = (course, [sample, share]) =>
  course[sample] * (1 - share) + course[Math.min(sample + 1, SHOW.count - 1)] * share;

// Puts the rig where it is at a time.
const takePose = (time) => {
  const place = placeOf(time);
  RIG.bodies.forEach((body, index) => {
    const count = COUNT[body.kind];
    const courses = COORDINATES.slice(FIRST[index], FIRST[index] + count);
    if (count <= 2) {
      courses.forEach((course, axis) => { values[OF_BODY[index][axis]] = between(course, place); });
      return;
    }
    // A quaternion and its opposite are one rotation: the way between two is the short one.
    const [from, to] = [0, 1].map((share) => courses.map((course) => between(course, [place[0], share])));
    const sign = from.slice(0, 4).reduce((sum, x, i) => sum + x * to[i], 0) < 0 ? -1 : 1;
    const mixed = from.map((x, i) => x * (1 - place[1]) + to[i] * place[1] * (i < 4 ? sign : 1));
    const length = norm(mixed.slice(0, 4));
    given[index] = mixed.map((x, i) => i < 4 ? x / length : x);
  });
};

// How far a driven base has gone over the ground.
const wayOf = (poses) => RIG.bodies[0].kind === "free" ? [poses[0].p[0], 0, poses[0].p[2]] : [0, 0, 0];

// All that is in view in the course of the show, as if the base stayed.
const everywhere = () => {
  const LOOKS = 60;
  return Array.from({ length: LOOKS + 1 }, (_, look) => {
    takePose(END * look / LOOKS);
    const poses = solve();
    return pointsOf(poses).map((point) => sub(point, wayOf(poses)));
  }).flat();
};
