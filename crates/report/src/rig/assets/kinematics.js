// The kinematics of a rig, for pages. `kinematicsOf` adds to a rig's bodies and dofs all that
// a page needs; its poses are in world axes, y up.
"use strict";

// ---- Vectors and quaternions (x y z w) ----
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(...a);
const product = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
  aw * bw - ax * bx - ay * by - az * bz,
];
const rotate = (q, v) => {
  const u = q.slice(0, 3);
  const t = times(cross(u, v), 2);
  return add(add(v, times(t, q[3])), cross(u, t));
};
const about = (axis, angle) => [...times(axis, Math.sin(angle / 2)), Math.cos(angle / 2)];
const exponential = (v) => {
  const angle = norm(v);
  return angle < 1e-12 ? [0, 0, 0, 1] : about(times(v, 1 / angle), angle);
};

const COUNT = { fixed: 0, revolute: 1, prismatic: 1, universal: 2, spherical: 4, free: 7 };

const kinematicsOf = ({ bodies, dofs }) => {
  // One number for each slider.
  const values = dofs.map((dof) => dof.home);
  const ofBody = bodies.map(() => []);
  dofs.forEach((dof, index) => { ofBody[dof.body][dof.axis] = index; });

  // Index at which the coordinates of each joint begin.
  let coordinates = 0;
  const first = bodies.map((body) => (coordinates += COUNT[body.kind]) - COUNT[body.kind]);

  // Coordinates of ball joints, before their sliders, and of a driven base.
  const given = bodies.map((body) => body.home);

  // Takes joint coordinates in the rig's order. The sliders of a ball joint turn on from its coordinates.
  const take = (q) => {
    bodies.forEach((body, index) => {
      const own = Array.from(q.slice(first[index], first[index] + COUNT[body.kind]));
      const isBall = body.kind === "spherical";
      if (isBall || body.kind === "free") given[index] = own.every(Number.isFinite) ? own : body.home;
      ofBody[index].forEach((slider, axis) => {
        values[slider] = isBall ? 0 : Number.isFinite(own[axis]) ? own[axis] : dofs[slider].home;
      });
    });
  };

  // Rotation and way of a body in its joint's frame.
  const motion = (body, index) => {
    const q = ofBody[index].map((slider) => values[slider]);
    switch (body.kind) {
      case "revolute": return [about(body.axes[0], q[0]), [0, 0, 0]];
      case "prismatic": return [[0, 0, 0, 1], times(body.axes[0], q[0])];
      case "universal": return [product(about(body.axes[0], q[0]), about(body.axes[1], q[1])), [0, 0, 0]];
      case "spherical": return [product(given[index], exponential(q)), [0, 0, 0]];
      case "free": return [given[index].slice(0, 4), given[index].slice(4)];
      default: return [[0, 0, 0, 1], [0, 0, 0]];
    }
  };

  // World poses of the bodies, and of their joints' frames before the joint's own motion.
  const solve = () => {
    const poses = [];
    bodies.forEach((body, index) => {
      const parent = body.parent === null ? { q: [0, 0, 0, 1], p: [0, 0, 0] } : poses[body.parent];
      const frame = {
        q: product(parent.q, body.rotation_xyzw),
        p: add(parent.p, rotate(parent.q, body.position_m)),
      };
      const [turn, way] = motion(body, index);
      poses.push({ q: product(frame.q, turn), p: add(frame.p, rotate(frame.q, way)), frame });
    });
    return poses;
  };

  // World axis of a dof.
  const axisOf = (dof, poses) => {
    const body = bodies[dof.body];
    const isFirst = body.kind === "universal" && dof.axis === 0;
    const of = isFirst ? poses[dof.body].frame.q : poses[dof.body].q;
    return rotate(of, body.axes[dof.axis]);
  };

  // Points that are to be seen: joints, centres of mass, ends, solids.
  const bounds = bodies.map((body) => (body.shapes ?? []).flatMap(boundsOf));
  const pointsOf = (poses) => bodies.flatMap((body, index) => [
    poses[index].p,
    ...[body.center_m, ...body.tips_m, ...bounds[index]].map((at) => add(poses[index].p, rotate(poses[index].q, at))),
  ]);
  return { bodies, dofs, first, ofBody, values, given, take, solve, axisOf, pointsOf };
};
