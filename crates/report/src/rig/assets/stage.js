// A rig's bodies and joints drawn in 3D on a canvas, with a camera that turns.

// ---- Colours of loads: shares of what a joint can give; none if that is not known ----
const LOW = [46, 158, 107], MID = [217, 165, 20], HIGH = [211, 55, 31], UNKNOWN = [140, 148, 158];
const mix = (a, b, t) => a.map((v, i) => v + (b[i] - v) * t);
const shade = (share) => {
  const blend = (s) => s < 0.5 ? mix(LOW, MID, s / 0.5) : mix(MID, HIGH, Math.min((s - 0.5) / 0.5, 1));
  const [r, g, b] = share === null ? UNKNOWN : blend(share);
  return `rgb(${r.toFixed(0)} ${g.toFixed(0)} ${b.toFixed(0)})`;
};

// Yaw and pitch with which the camera begins, rad.
const FRONT = [0.7, 0.25];

// `rig`: from `kinematicsOf`. `points`: all that is to be in view. `show`: asks for a new drawing, with `draw`.
// `covered`: pixels at the top and at the bottom of the canvas that texts cover; the camera centres between them.
// `approach` brings the camera as near as all points are still in view.
const stageOn = (rig, canvas, points, show, covered = () => [0, 0]) => {
  const { bodies, dofs, values, axisOf } = rig;
  const context = canvas.getContext("2d");
  // Colours of the page's style; they are read once in a drawing.
  let colors = {};
  const color = (name) =>
    colors[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const box = points.reduce(
    ([low, high], p) => [low.map((x, i) => Math.min(x, p[i])), high.map((x, i) => Math.max(x, p[i]))],
    [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]]);
  const home = times(add(...box), 0.5);
  const size = Math.max(norm(sub(box[1], box[0])), 0.02);
  const camera = { yaw: FRONT[0], pitch: FRONT[1], distance: 2.4 * size };
  const solids = bodies.map((body) => (body.shapes ?? []).map((shape) => solidOf(shape, size)));
  const hasSolids = solids.some((own) => own.length > 0);
  // Beside solids the mark of a joint is small, and smaller where joints are near each other: marks would hide them.
  const places = rig.solve();
  const markScales = dofs.map((dof, index) => {
    if (!hasSolids) return 1;
    const away = dofs.map((other, at) =>
      at === index ? Infinity : norm(sub(places[other.body].p, places[dof.body].p)));
    return Math.min(Math.max(Math.min(...away) / (0.15 * size), 0.2), 0.6);
  });
  // Places at which joints were drawn.
  let marks = [];
  const ground = box[0][1];

  // `top` and `height`: of the part that no text covers.
  let width = 0, top = 0, height = 0, middle = home;
  const ratio = () => window.devicePixelRatio || 1;
  const project = (p) => {
    const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
    const [x, y, z] = sub(p, middle);
    const depth = camera.distance - (x * cp * sy + y * sp + z * cp * cy);
    const scale = 1.5 * Math.min(width, height * 1.3) / Math.max(depth, 0.02 * size);
    return { x: width / 2 + scale * (x * cy - z * sy), y: top + height / 2 - scale * (-x * sp * sy + y * cp - z * sp * cy), depth, scale };
  };

  const measure = () => {
    const [over, under] = covered();
    const sizes = [canvas.clientWidth, over, Math.max(canvas.clientHeight - over - under, 0)];
    [width, top, height] = sizes.map((x) => Math.round(x * ratio()));
  };
  const approach = () => {
    measure();
    const isSeen = ({ x, y }) => Math.abs(x - width / 2) < 0.45 * width && Math.abs(y - top - height / 2) < 0.43 * height;
    for (camera.distance = size; camera.distance < 5 * size && !points.every((p) => isSeen(project(p)));) camera.distance *= 1.04;
  };

  // ---- Drawing: far things first ----
  const line = (a, b, style, thick) => {
    context.beginPath();
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
    context.strokeStyle = style;
    context.lineWidth = Math.max(thick, 1);
    context.stroke();
  };
  const ring = (at, radius, style) => {
    context.beginPath();
    context.arc(at.x, at.y, radius * at.scale, 0, 2 * Math.PI);
    context.strokeStyle = style;
    context.lineWidth = 2.5 * ratio();
    context.stroke();
  };
  const arc = (dof, poses, radius) => {
    const axis = axisOf(dof, poses);
    const { p } = poses[dof.body];
    const start = Math.abs(axis[1]) < 0.9 ? cross(axis, [0, 1, 0]) : cross(axis, [1, 0, 0]);
    const across = times(start, 1 / norm(start));
    const now = values[dofs.indexOf(dof)];
    const at = (angle) => {
      const way = angle - now;
      return project(add(p, times(add(times(across, Math.cos(way)), times(cross(axis, across), Math.sin(way))), radius)));
    };
    const [least, most] = dof.range;
    context.beginPath();
    const center = project(p);
    context.moveTo(center.x, center.y);
    for (let i = 0; i <= 32; i += 1) {
      const q = at(least + (most - least) * i / 32);
      context.lineTo(q.x, q.y);
    }
    context.closePath();
    context.globalAlpha = 0.18;
    context.fillStyle = color("focus");
    context.fill();
    context.globalAlpha = 1;
    line(center, at(now), color("focus"), 1.5 * ratio());
  };
  const grid = () => {
    const step = 10 ** Math.round(Math.log10(size / 4));
    const reach = 6;
    // Its lines stay on the ground while the camera goes with the rig.
    const from = sub(middle, home).map((way) => Math.round(way / step));
    for (let i = -reach; i <= reach; i += 1) {
      for (const [a, b] of [[[i, -reach], [i, reach]], [[-reach, i], [reach, i]]]) {
        const at = ([x, z]) => project([home[0] + (from[0] + x) * step, ground, home[2] + (from[2] + z) * step]);
        line(at(a), at(b), color("line"), ratio());
      }
    }
  };
  // The normal as the camera sees it: right, up, towards the camera.
  const seenNormal = ([x, y, z]) => {
    const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
    return [x * cy - z * sy, -x * sp * sy + y * cp - z * sp * cy, x * cp * sy + y * sp + z * cp * cy];
  };
  const polygon = (corners) => {
    context.beginPath();
    corners.forEach(({ x, y }, i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
    context.closePath();
  };
  // The faces that look towards the camera.
  const faces = (poses) => solids.flatMap((own, body) => own.flatMap(({ faces: all, color: paint }) => {
    const { q, p } = poses[body];
    return all.flatMap(({ corners, normal }) => {
      const at = corners.map((corner) => project(add(p, rotate(q, corner))));
      // Corners run clockwise on the canvas, whose y points down, if the face looks away.
      let area = 0;
      at.forEach((a, i) => { const b = at[(i + 1) % at.length]; area += a.x * b.y - b.x * a.y; });
      if (area >= 0) return [];
      const style = litColor(paint, seenNormal(rotate(q, normal)));
      const depth = at.reduce((sum, point) => sum + point.depth, 0) / at.length;
      return [{ depth, paint: () => {
        polygon(at);
        context.fillStyle = style;
        context.fill();
        // The seams between faces.
        context.strokeStyle = style;
        context.lineWidth = 0.8 * ratio();
        context.stroke();
      } }];
    });
  }));
  // Outlines of the solids of bodies that are elsewhere in `others` than in `poses`.
  const outlines = (others, poses) => solids.flatMap((own, body) => {
    const { q, p } = others[body];
    const turned = Math.abs(q.reduce((sum, x, i) => sum + x * poses[body].q[i], 0));
    if (norm(sub(p, poses[body].p)) < 0.004 * size && turned > 0.9998) return [];
    return own.map(({ faces: all }) =>
      hullOf(all.flatMap(({ corners }) => corners.map((corner) => project(add(p, rotate(q, corner)))))));
  });
  // From where to where each body reaches; a body with solids shows this by them.
  const bones = (poses) => bodies.flatMap((body, index) => {
    if (solids[index].length > 0) return [];
    const from = poses[index].p;
    const to = bodies.map((_, child) => child).filter((child) => bodies[child].parent === index)
      .map((child) => poses[child].frame.p);
    const own = [...body.tips_m, ...(to.length + body.tips_m.length === 0 ? [times(body.center_m, 1.6)] : [])];
    to.push(...own.map((tip) => add(from, rotate(poses[index].q, tip))));
    return to.map((end) => [from, end]);
  });
  // `shares`: of what each joint can give. `marked`: joints with a ring. `way`: how far the camera goes with the rig.
  // `sent`, `ghost`: poses that are drawn as thin lines, and as broken ones.
  const draw = (poses, shares, { chosen = -1, marked = () => false, way = [0, 0, 0], sent = null, ghost = null } = {}) => {
    colors = {};
    middle = add(home, way);
    measure();
    if (width === 0) return;
    const whole = Math.round(canvas.clientHeight * ratio());
    if (canvas.width !== width || canvas.height !== whole) Object.assign(canvas, { width, height: whole });
    context.clearRect(0, 0, width, whole);
    context.lineCap = "round";
    grid();
    const thick = 0.018 * size;
    const parts = [];
    for (const [from, to] of bones(poses)) {
      const [a, b] = [project(from), project(to)];
      parts.push({ depth: (a.depth + b.depth) / 2, paint: () => {
        line(a, b, color("muted"), thick * a.scale + 2 * ratio());
        line(a, b, color("paper"), thick * a.scale);
      } });
    }
    parts.push(...faces(poses));
    // Joints inside of solids are still seen: they are drawn last.
    const last = [];
    for (const [lines, style, dashes] of [[sent, "world", []], [ghost, "egocentric", [5, 4]]]) {
      for (const [from, to] of lines ? bones(lines) : []) {
        const [a, b] = [project(from), project(to)];
        // In front of what it is in.
        parts.push({ depth: (a.depth + b.depth) / 2 - thick, paint: () => {
          context.setLineDash(dashes.map((x) => x * ratio()));
          line(a, b, color(style), 1.5 * ratio());
          context.setLineDash([]);
        } });
      }
      for (const hull of lines ? outlines(lines, poses) : []) {
        last.push({ depth: 0, paint: () => {
          polygon(hull);
          context.setLineDash(dashes.map((x) => x * ratio()));
          context.strokeStyle = color(style);
          context.lineWidth = 1.2 * ratio();
          context.stroke();
          context.setLineDash([]);
        } });
      }
    }
    marks = dofs.map((dof) => project(poses[dof.body].p));
    dofs.forEach((dof, index) => {
      // A driven base has no axes.
      if (bodies[dof.body].kind === "free") return;
      const axis = axisOf(dof, poses);
      const { p } = poses[dof.body];
      const scale = markScales[index];
      const half = scale * (dof.slides ? 0.05 : 0.03) * size;
      const [a, b] = [-half, half].map((way) => project(add(p, times(axis, way))));
      const style = shade(shares[index]);
      const wide = scale * 1.7 * thick;
      (hasSolids ? last : parts).push({ depth: project(p).depth - 0.02 * size, paint: () => {
        if (index === chosen && !dof.slides) arc(dof, poses, 0.14 * size);
        line(a, b, color(index === chosen ? "focus" : "text"), wide * a.scale + 2 * ratio());
        line(a, b, style, wide * a.scale);
        if (marked(index)) ring(project(p), 0.05 * size, color("alert"));
      } });
    });
    for (const layer of [parts, last]) layer.sort((a, b) => b.depth - a.depth);
    for (const part of [...parts, ...last]) part.paint();
  };

  // ---- Camera ----
  let isMoved = false;
  const turnView = (yaw, pitch) => {
    isMoved = true;
    camera.yaw += yaw;
    camera.pitch = Math.min(Math.max(camera.pitch + pitch, -1.5), 1.5);
    show();
  };
  const zoom = (factor) => {
    isMoved = true;
    camera.distance = Math.min(Math.max(camera.distance * factor, 0.4 * size), 20 * size);
    show();
  };
  let held = null;
  canvas.addEventListener("pointerdown", (event) => { held = event; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    turnView((held.clientX - event.clientX) * 0.01, (event.clientY - held.clientY) * 0.01);
    held = event;
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(event.deltaY > 0 ? 1.1 : 1 / 1.1); }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const done = {
      ArrowLeft: () => turnView(-0.1, 0), ArrowRight: () => turnView(0.1, 0),
      ArrowUp: () => turnView(0, 0.1), ArrowDown: () => turnView(0, -0.1),
      "+": () => zoom(1 / 1.15), "=": () => zoom(1 / 1.15), "-": () => zoom(1.15),
    }[event.key];
    if (done) { event.preventDefault(); done(); }
  });
  // Returns the joint that was drawn nearest to a place of the canvas, -1 if none is near.
  const jointAt = (x, y) => {
    const far = marks.map((at) => Math.hypot(at.x / ratio() - x, at.y / ratio() - y));
    const near = far.indexOf(Math.min(...far));
    return far[near] < 28 ? near : -1;
  };
  const front = () => {
    [camera.yaw, camera.pitch] = FRONT;
    approach();
    isMoved = false;
    show();
  };
  // Fits the rig into a canvas of another size, unless the reader has moved the camera.
  const fit = () => {
    if (!isMoved) approach();
    show();
  };
  addEventListener("resize", show);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  return { draw, approach, front, fit, jointAt };
};
