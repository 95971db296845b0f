
// The playback has the same mannequins, camera and light as the still pictures.
(() => {
  const player = document.getElementById("player");
  if (!player) return;
  const data = JSON.parse(document.getElementById("playback-data").textContent);
  const element = (id) => document.getElementById(id);
  const scrubber = element("scrubber");

  // ---- Data ----
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const desired = new Int16Array(bytes(data.desired));
  const runs = data.runs.map((run) => ({
    ...run,
    measured: new Int16Array(bytes(run.measured)),
    errors: new Uint16Array(bytes(run.errors)),
  }));
  const last = data.frames - 1;

  // Returns the points of a track at a time in frames, interpolated between the two nearest frames.
  const pointsAt = (track, time) => {
    const frame = Math.min(Math.floor(time), Math.max(last - 1, 0));
    const share = time - frame;
    const stride = data.points * 3;
    const from = frame * stride, to = Math.min(frame + 1, last) * stride;
    const points = [];
    for (let i = 0; i < stride; i += 3) {
      points.push([0, 1, 2].map(
        (axis) => (track[from + i + axis] * (1 - share) + track[to + i + axis] * share) * data.unit_m));
    }
    return points;
  };

  // ---- State ----
  const START = { yaw: data.yaw_rad, pitch: 0.2, distance: 5.7 * data.size_m };
  const camera = { ...START };
  let time = Number(scrubber.value);
  let playing = false;
  let before = null;
  let asked = false;
  // Returns the target of the camera: a fixed point, or the mean position of the first point over about 1.2 s.
  const target = (time) => {
    if (data.target_m) return data.target_m;
    const width = Math.round(0.6 / data.dt_s);
    const sum = [0, 0, 0];
    let n = 0;
    for (let frame = Math.floor(time) - width; frame <= time + width; frame += 2) {
      const at = Math.min(Math.max(frame, 0), last) * data.points * 3;
      for (const axis of [0, 1, 2]) sum[axis] += desired[at + axis] * data.unit_m;
      n += 1;
    }
    return sum.map((s) => s / n);
  };

  // ---- Drawing ----
  const projector = (width, height, target) => {
    const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
    const focal = 2.15 * height;
    return (p) => {
      const x = p[0] - target[0], y = p[1] - target[1], z = p[2] - target[2];
      const depth = camera.distance - (x * cp * sy + y * sp + z * cp * cy);
      const scale = focal / Math.max(depth, 0.1 * data.size_m);
      return {
        x: width / 2 + scale * (x * cy - z * sy),
        y: height / 2 - scale * (-x * sp * sy + y * cp - z * sp * cy),
        depth, scale,
      };
    };
  };
  const mix = (a, b, t) => a.map((v, i) => v + (b[i] - v) * t);

  const capsule = (path, a, b) => {
    const length = Math.hypot(b.x - a.x, b.y - a.y);
    if (length <= Math.abs(a.r - b.r)) {
      const c = a.r > b.r ? a : b;
      path.moveTo(c.x + c.r, c.y);
      path.arc(c.x, c.y, c.r, 0, 2 * Math.PI);
      return;
    }
    const along = Math.atan2(b.y - a.y, b.x - a.x);
    const touch = Math.acos((a.r - b.r) / length);
    path.moveTo(b.x + b.r * Math.cos(along - touch), b.y + b.r * Math.sin(along - touch));
    path.arc(b.x, b.y, b.r, along - touch, along + touch);
    path.arc(a.x, a.y, a.r, along + touch, along - touch + 2 * Math.PI);
    path.closePath();
  };

  const SHADES = {
    desired: [[0, "#ffffff"], [0.55, "#e4e8ee"], [1, "#98a2b0"]],
    measured: [[0, "#ff7b68"], [0.5, "#d8301e"], [1, "#7e120a"]],
  };
  const drawPart = (context, [a, b], shades) => {
    const [dx, dy] = [b.x - a.x, b.y - a.y];
    const length = Math.max(Math.hypot(dx, dy), 1e-6);
    let [nx, ny] = [dy / length, -dx / length];
    if (length < 0.5 * Math.max(a.r, b.r)) [nx, ny] = [-0.45, -0.89];
    else if (-0.45 * nx - 0.89 * ny < 0) [nx, ny] = [-nx, -ny];
    const [x, y, r] = [(a.x + b.x) / 2, (a.y + b.y) / 2, Math.max(a.r, b.r)];
    const gradient = context.createLinearGradient(x + nx * r, y + ny * r, x - nx * r, y - ny * r);
    for (const [offset, color] of shades) gradient.addColorStop(offset, color);
    const path = new Path2D();
    capsule(path, a, b);
    context.fillStyle = gradient;
    context.fill(path);
    context.stroke(path);
  };

  // The trunk is one group of several parts; every other part is a separate group.
  const all = data.parts.map((_, i) => i);
  const GROUPS = [all.slice(0, data.trunk), ...all.slice(data.trunk).map((i) => [i])].filter((group) => group.length > 0);

  const { height_m: GROUND, radius_m: RADIUS, grid_m: GRID } = data.ground;
  const drawGround = (context, project, center) => {
    const at = (x, z) => project([x, GROUND, z]);
    const path = new Path2D();
    for (let i = 0; i < 48; i += 1) {
      const p = at(center[0] + RADIUS * Math.sin(i * Math.PI / 24), center[2] + RADIUS * Math.cos(i * Math.PI / 24));
      path.lineTo(p.x, p.y);
    }
    path.closePath();
    context.fillStyle = "#596573";
    context.fill(path);
    const lines = new Path2D();
    for (const across of [0, 2]) {
      const most = Math.ceil(RADIUS / GRID + 0.5);
      for (let step = -most; step <= most; step += 1) {
        const middle = (Math.round(center[across] / GRID) + step) * GRID;
        const off = middle - center[across];
        if (Math.abs(off) >= RADIUS) continue;
        const half = Math.sqrt(RADIUS * RADIUS - off * off);
        for (const [i, way] of [-half, half].entries()) {
          const p = across === 0 ? at(middle, center[2] + way) : at(center[0] + way, middle);
          if (i === 0) lines.moveTo(p.x, p.y); else lines.lineTo(p.x, p.y);
        }
      }
    }
    context.strokeStyle = "#76828f";
    context.stroke(lines);
  };

  const draw = (view) => {
    const { canvas, context } = view;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (width === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const run = view.run();
    const center = target(time);
    const project = projector(width, height, center);
    const figures = [
      { points: pointsAt(desired, time), girth: data.girth, shades: SHADES.desired },
      { points: pointsAt(run.measured, time), girth: run.girth, shades: SHADES.measured },
    ];
    context.fillStyle = "#47525f";
    context.fillRect(0, 0, width, height);
    context.lineWidth = 0.8 * ratio;
    drawGround(context, project, center);
    context.fillStyle = "rgba(34, 42, 51, .28)";
    const parts = figures.map(({ points, girth }) => {
      const shadow = new Path2D();
      const drawn = data.parts.map(([a, b, from, to, rFrom, rTo]) => {
        const ends = [[mix(points[a], points[b], from), rFrom], [mix(points[a], points[b], to), rTo]];
        const below = ends.map(([p, r]) => {
          const s = project([p[0], GROUND, p[2]]);
          return { x: s.x, y: s.y, r: r * girth * s.scale * 0.55 };
        });
        capsule(shadow, ...below);
        const seen = ends.map(([p, r]) => {
          const s = project(p);
          return { x: s.x, y: s.y, r: r * girth * s.scale, depth: s.depth };
        });
        return { seen, depth: (seen[0].depth + seen[1].depth) / 2 };
      });
      context.fill(shadow);
      return drawn;
    });
    context.strokeStyle = "#38424d";
    // Draws from the farthest group to the nearest. Corresponding parts of the two figures are in one group.
    const depth = (group) => group.reduce((sum, i) => sum + parts[0][i].depth + parts[1][i].depth, 0) / group.length;
    const groups = GROUPS.map((group) => ({ group, depth: depth(group) })).sort((a, b) => b.depth - a.depth);
    for (const { group } of groups) {
      figures.forEach((figure, f) => group.forEach((i) => drawPart(context, parts[f][i].seen, figure.shades)));
    }
    const frame = Math.round(time) * 4;
    const shown = (i) => `${(run.errors[frame + i] / 100).toFixed(2)}`;
    view.readouts[0].textContent = `${shown(0)}°  ${shown(1)} cm`;
    view.readouts[1].textContent = `${shown(2)}°  ${shown(3)} cm`;
  };

  const views = [...player.querySelectorAll(".view")].map((node) => ({
    canvas: node.querySelector("canvas"),
    context: node.querySelector("canvas").getContext("2d"),
    readouts: node.querySelectorAll("[data-readout]"),
    method: node.querySelector("[data-method]"),
    run() {
      const scale = Number(element("figure").value);
      return runs.find((run) => run.scale === scale && run.method === this.method.value);
    },
  }));

  // ---- Time ----
  const render = (now) => {
    asked = false;
    if (playing) {
      // The time of the first frame may be earlier than the key press that requested it.
      const passed = Math.max(now - (before ?? now), 0) / 1000;
      before = now;
      time += passed / data.dt_s * Number(element("speed").value);
      if (time >= last) { time = last; setPlaying(false); }
      scrubber.value = Math.round(time);
    }
    const clock = `${(time * data.dt_s).toFixed(2)} s`;
    element("clock").textContent = clock;
    scrubber.setAttribute("aria-valuetext", clock);
    views.forEach(draw);
    if (playing) ask();
  };
  const ask = () => {
    if (!asked) { asked = true; requestAnimationFrame(render); }
  };
  const setPlaying = (value) => {
    playing = value;
    const button = element("play");
    button.textContent = playing ? "❚❚" : "▶";
    button.setAttribute("aria-label", playing ? "Pause" : "Play");
    if (playing) {
      if (time >= last) time = 0;
      before = null;
      ask();
    }
  };
  element("play").addEventListener("click", () => setPlaying(!playing));
  scrubber.addEventListener("input", () => { time = Number(scrubber.value); ask(); });
  document.addEventListener("keydown", (event) => {
    const elsewhere = event.target.closest("select, button, a, [contenteditable]");
    if (event.key === " " && !elsewhere && !event.ctrlKey && !event.metaKey) {
      event.preventDefault();
      setPlaying(!playing);
    }
  });

  // ---- View ----
  const turn = (yaw, pitch) => {
    camera.yaw += yaw;
    camera.pitch = Math.min(Math.max(camera.pitch + pitch, -0.1), 1.5);
    ask();
  };
  const zoom = (factor) => {
    camera.distance = Math.min(Math.max(camera.distance * factor, 2 * data.size_m), 15 * data.size_m);
    ask();
  };
  const KEYS = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0),
    ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1 / 0.9),
  };
  for (const { canvas, method } of views) {
    const pointers = new Map();
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener("pointermove", (event) => {
      const from = pointers.get(event.pointerId);
      if (!from) return;
      const apart = pointers.size === 2 ? spread() : 0;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (pointers.size === 2) zoom(apart / Math.max(spread(), 1));
      else turn(-(event.clientX - from.x) * 0.008, (event.clientY - from.y) * 0.006);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    }
    // The wheel scrolls the page, unless the view has the focus.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.0012));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const act = KEYS[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act();
    });
    method.addEventListener("change", ask);
    new ResizeObserver(ask).observe(canvas);
  }
  element("figure").addEventListener("change", ask);
  element("nearer").addEventListener("click", () => zoom(0.85));
  element("farther").addEventListener("click", () => zoom(1 / 0.85));
  element("reset").addEventListener("click", () => { Object.assign(camera, START); ask(); });
  ask();
})();
