// ---- Pose of the rig at a time of the show ----
const COORDINATES = SHOW.coordinates.map(unpack);

// Positions of each dof; for a ball joint, the angle of its whole rotation.
COURSES.position = RIG.dofs.map(({ body, axis }) => {
  const first = FIRST[body];
  if (RIG.bodies[body].kind !== "spherical") return COORDINATES[first + axis];
  const [x, y, z, w] = COORDINATES.slice(first, first + 4);
  return x.map((_, sample) => 2 * Math.atan2(Math.hypot(x[sample], y[sample], z[sample]), Math.abs(w[sample])));
});

// Sets the rig to its pose at a time.
const takePose = (time) => {
  const place = placeOf(time);
  RIG.bodies.forEach((body, index) => {
    const count = COUNT[body.kind];
    const courses = COORDINATES.slice(FIRST[index], FIRST[index] + count);
    if (count <= 2) {
      courses.forEach((course, axis) => { values[OF_BODY[index][axis]] = between(course, place); });
      return;
    }
    // A quaternion and its negative are the same rotation: the shorter way is used.
    const [from, to] = [0, 1].map((share) => courses.map((course) => between(course, [place[0], share])));
    const sign = from.slice(0, 4).reduce((sum, x, i) => sum + x * to[i], 0) < 0 ? -1 : 1;
    const mixed = from.map((x, i) => x * (1 - place[1]) + to[i] * place[1] * (i < 4 ? sign : 1));
    const length = norm(mixed.slice(0, 4));
    given[index] = mixed.map((x, i) => i < 4 ? x / length : x);
  });
};
