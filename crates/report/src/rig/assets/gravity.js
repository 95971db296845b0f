// Torques of gravity on the joints.
const moves = (joint, body) => {
  for (let at = body; at !== null; at = RIG.bodies[at].parent) if (at === joint) return true;
  return false;
};
const MOVED = RIG.dofs.map((dof) =>
  RIG.bodies.map((_, body) => body).filter((body) => moves(dof.body, body)));

// Returns the effort with which each dof holds the pose, in N m, or in N for a slide.
const GRAVITY = [0, -9.81, 0];
const loads = (poses) => RIG.dofs.map((dof, index) => {
  const axis = axisOf(dof, poses);
  let sum = 0;
  for (const body of MOVED[index]) {
    const { mass_kg: mass, center_m: center } = RIG.bodies[body];
    const weight = times(GRAVITY, mass);
    if (dof.slides) { sum -= dot(axis, weight); continue; }
    const at = add(poses[body].p, rotate(poses[body].q, center));
    sum -= dot(axis, cross(sub(at, poses[dof.body].p), weight));
  }
  return sum;
});
