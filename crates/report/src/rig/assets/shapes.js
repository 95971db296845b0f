// Solids of bodies: boxes, spheres, cylinders and capsules as shaded faces, drawn from the far ones to the near ones.

// Colour of a solid that has none of its own.
const PLAIN = [0.67, 0.71, 0.76];
// Direction from which the light comes, seen by the camera: right, up, towards it.
const LIGHT = [0.36, 0.72, 0.6];

// Faces of a solid in its own frame: corners, counterclockwise from outside, and normal. `around`: sides of a circle.
const facesOf = (shape, around) => {
  const faces = [];
  const face = (corners, normal) => faces.push({ corners, normal });
  const ring = (radius, z) => Array.from({ length: around }, (_, i) => {
    const angle = 2 * Math.PI * i / around;
    return [radius * Math.cos(angle), radius * Math.sin(angle), z];
  });
  const normalOf = ([a, b, c]) => {
    const across = cross(sub(b, a), sub(c, a));
    return times(across, 1 / Math.max(norm(across), 1e-12));
  };
  // A band between two rings. A ring without radius is a point.
  const band = (low, high) => {
    for (let i = 0; i < around; i += 1) {
      const next = (i + 1) % around;
      const corners = [low[i], low[next], high[next], high[i]]
        .filter((p, at, all) => norm(sub(p, all[(at + 3) % 4])) > 1e-9);
      if (corners.length > 2) face(corners, normalOf(corners));
    }
  };
  if (shape.kind === "box") {
    // Faces that are long are cut, so that their parts are sorted by their own depths.
    const half = shape.size.map((edge) => edge / 2);
    const short = Math.min(...shape.size);
    const cuts = shape.size.map((edge) => Math.min(Math.max(Math.ceil(edge / (2 * short)), 1), 4));
    for (let axis = 0; axis < 3; axis += 1) {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      for (const side of [-1, 1]) {
        const normal = [0, 0, 0];
        normal[axis] = side;
        const corner = (a, b) => {
          const p = [0, 0, 0];
          p[axis] = side * half[axis];
          p[u] = half[u] * (2 * a / cuts[u] - 1);
          p[v] = half[v] * (2 * b / cuts[v] - 1);
          return p;
        };
        for (let a = 0; a < cuts[u]; a += 1) {
          for (let b = 0; b < cuts[v]; b += 1) {
            const corners = [corner(a, b), corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)];
            face(side > 0 ? corners : corners.reverse(), normal);
          }
        }
      }
    }
    return faces;
  }
  const { radius } = shape;
  const half = shape.kind === "sphere" ? 0 : shape.length / 2;
  if (shape.kind === "cylinder") {
    const parts = Math.min(Math.max(Math.ceil(shape.length / (4 * radius)), 1), 4);
    const rings = Array.from({ length: parts + 1 }, (_, i) => ring(radius, half * (2 * i / parts - 1)));
    for (let i = 0; i < parts; i += 1) band(rings[i], rings[i + 1]);
    face(rings[parts], [0, 0, 1]);
    face([...rings[0]].reverse(), [0, 0, -1]);
    return faces;
  }
  // A ball, whose halves are apart by the length of a capsule.
  const steps = Math.ceil(around / 4);
  const rings = [];
  for (let i = -steps; i <= steps; i += 1) {
    const angle = i / steps * Math.PI / 2;
    const at = (end) => ring(radius * Math.cos(angle), radius * Math.sin(angle) + end);
    if (i === 0 && half > 0) rings.push(at(-half), at(half));
    else rings.push(at(Math.sign(i) * half));
  }
  for (let i = 0; i + 1 < rings.length; i += 1) band(rings[i], rings[i + 1]);
  return faces;
};

// Sides of a circle, by its radius as a share of the rig's size.
const sidesOf = (share) => share > 0.08 ? 16 : share > 0.03 ? 10 : 8;

// A solid of a rig of that size, prepared for drawing: faces in the body's frame.
const solidOf = (shape, size) => {
  const place = (p) => add(shape.position, rotate(shape.rotation, p));
  const faces = facesOf(shape, sidesOf((shape.radius ?? 0) / size)).map(({ corners, normal }) => ({
    corners: corners.map(place), normal: rotate(shape.rotation, normal),
  }));
  return { faces, color: shape.color ?? PLAIN };
};

// Points that bound a solid, in the body's frame.
const boundsOf = (shape) => {
  const half = shape.kind === "box" ? shape.size.map((edge) => edge / 2)
    : [shape.radius, shape.radius, shape.radius + (shape.kind === "sphere" ? 0 : shape.length / 2)];
  return [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) =>
    add(shape.position, rotate(shape.rotation, [x * half[0], y * half[1], z * half[2]])))));
};

// Colour of a face: lighter where it looks towards the light.
const litColor = (color, normal) => {
  const light = 0.62 + 0.38 * Math.max(dot(normal, LIGHT), -0.6);
  return `rgb(${color.map((share) => Math.round(255 * Math.min(share * light, 1))).join(" ")})`;
};

// Corners of the outline of projected points: their convex hull.
const hullOf = (points) => {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const turns = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const half = (all) => {
    const kept = [];
    for (const point of all) {
      while (kept.length > 1 && turns(kept.at(-2), kept.at(-1), point) <= 0) kept.pop();
      kept.push(point);
    }
    return kept.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
};
