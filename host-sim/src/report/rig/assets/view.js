(() => {
  const canvas = document.getElementById("stage");
  const context = canvas.getContext("2d");
  const list = document.getElementById("sliders");
  const play = document.getElementById("move");
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  // ---- What is where at home: the camera looks at its middle ----
  const points = (poses) => RIG.bodies.flatMap((body, index) => [
    poses[index].p,
    ...[body.center_m, ...body.tips_m].map((at) => add(poses[index].p, rotate(poses[index].q, at))),
  ]);
  const box = points(solve()).reduce(
    ([low, high], p) => [low.map((x, i) => Math.min(x, p[i])), high.map((x, i) => Math.max(x, p[i]))],
    [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]]);
  const middle = times(add(...box), 0.5);
  const size = Math.max(norm(sub(box[1], box[0])), 0.02);
  const camera = { yaw: 0.7, pitch: 0.25, distance: 2.4 * size };
  const ground = box[0][1];

  let width = 0, height = 0, chosen = -1;
  const project = (p) => {
    const [sy, cy, sp, cp] = [Math.sin(camera.yaw), Math.cos(camera.yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
    const [x, y, z] = sub(p, middle);
    const depth = camera.distance - (x * cp * sy + y * sp + z * cp * cy);
    const scale = 1.5 * Math.min(width, height * 1.3) / Math.max(depth, 0.02 * size);
    return { x: width / 2 + scale * (x * cy - z * sy), y: height / 2 - scale * (-x * sp * sy + y * cp - z * sp * cy), depth, scale };
  };

  // ---- Loads ----
  const share = (load, freedom) => freedom.capacity > 0 ? Math.abs(load) / freedom.capacity : 0;
  const LOW = [46, 158, 107], MID = [217, 165, 20], HIGH = [211, 55, 31];
  const mix = (a, b, t) => a.map((v, i) => v + (b[i] - v) * t);
  const shade = (s) => {
    const [r, g, b] = s < 0.5 ? mix(LOW, MID, s / 0.5) : mix(MID, HIGH, Math.min((s - 0.5) / 0.5, 1));
    return `rgb(${r.toFixed(0)} ${g.toFixed(0)} ${b.toFixed(0)})`;
  };
  const number = (signed) => {
    // No zero below zero.
    const x = Math.abs(signed) < 0.0005 ? 0 : signed;
    return Math.abs(x) >= 100 ? x.toFixed(0) : Math.abs(x) >= 1 ? x.toFixed(2) : x.toFixed(3);
  };
  const degrees = (x) => (x * 180 / Math.PI).toFixed(1) + "°";
  const shown = (freedom, x) => freedom.slides ? (x * 1000).toFixed(1) + " mm" : degrees(x);

  // ---- Drawing: far things first ----
  const line = (a, b, style, thick) => {
    context.beginPath();
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
    context.strokeStyle = style;
    context.lineWidth = Math.max(thick, 1);
    context.stroke();
  };
  const arc = (freedom, poses, radius) => {
    const axis = axisOf(freedom, poses);
    const { p } = poses[freedom.body];
    const start = Math.abs(axis[1]) < 0.9 ? cross(axis, [0, 1, 0]) : cross(axis, [1, 0, 0]);
    const across = times(start, 1 / norm(start));
    const now = values[RIG.freedoms.indexOf(freedom)];
    const at = (angle) => {
      const way = angle - now;
      return project(add(p, times(add(times(across, Math.cos(way)), times(cross(axis, across), Math.sin(way))), radius)));
    };
    const [least, most] = freedom.range;
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
  const ratio = () => window.devicePixelRatio || 1;
  const grid = () => {
    const step = 10 ** Math.round(Math.log10(size / 4));
    const reach = 6;
    for (let i = -reach; i <= reach; i += 1) {
      for (const [a, b] of [[[i, -reach], [i, reach]], [[-reach, i], [reach, i]]]) {
        const at = ([x, z]) => project([middle[0] + x * step, ground, middle[2] + z * step]);
        line(at(a), at(b), color("line"), ratio());
      }
    }
  };
  const draw = (poses, asked) => {
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.round(x * ratio()));
    if (w === 0) return;
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    [width, height] = [w, h];
    context.clearRect(0, 0, w, h);
    context.lineCap = "round";
    grid();
    const thick = 0.018 * size;
    const parts = [];
    RIG.bodies.forEach((body, index) => {
      const from = poses[index].p;
      const to = RIG.bodies.map((_, child) => child).filter((child) => RIG.bodies[child].parent === index)
        .map((child) => poses[child].frame.p);
      const own = [...body.tips_m, ...(to.length + body.tips_m.length === 0 ? [times(body.center_m, 1.6)] : [])];
      to.push(...own.map((tip) => add(from, rotate(poses[index].q, tip))));
      for (const end of to) {
        const [a, b] = [project(from), project(end)];
        parts.push({ depth: (a.depth + b.depth) / 2, paint: () => {
          line(a, b, color("muted"), thick * a.scale + 2 * ratio());
          line(a, b, color("paper"), thick * a.scale);
        } });
      }
    });
    RIG.freedoms.forEach((freedom, index) => {
      const axis = axisOf(freedom, poses);
      const { p } = poses[freedom.body];
      const half = (freedom.slides ? 0.05 : 0.03) * size;
      const [a, b] = [-half, half].map((way) => project(add(p, times(axis, way))));
      const style = shade(share(asked[index], freedom));
      parts.push({ depth: project(p).depth - 0.02 * size, paint: () => {
        if (index === chosen && !freedom.slides) arc(freedom, poses, 0.14 * size);
        line(a, b, color(index === chosen ? "focus" : "text"), 1.7 * thick * a.scale + 2 * ratio());
        line(a, b, style, 1.7 * thick * a.scale);
      } });
    });
    parts.sort((a, b) => b.depth - a.depth);
    for (const part of parts) part.paint();
  };

  // ---- Sliders ----
  const rows = RIG.freedoms.map((freedom, index) => {
    const row = document.createElement("li");
    const id = `joint-${index}`;
    const label = document.createElement("label");
    label.htmlFor = id;
    const name = document.createElement("span");
    name.textContent = freedom.name;
    const value = document.createElement("span");
    label.append(name, value);
    const slider = document.createElement("input");
    Object.assign(slider, { type: "range", id, min: freedom.range[0], max: freedom.range[1], step: "any" });
    slider.addEventListener("input", () => { stop(); values[index] = Number(slider.value); chosen = index; show(); });
    slider.addEventListener("focus", () => { chosen = index; show(); });
    slider.addEventListener("keydown", (event) => {
      // Steps of a fiftieth of the range: "any" would leave them to the browser.
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!way) return;
      event.preventDefault();
      const [least, most] = freedom.range;
      stop();
      values[index] = Math.min(Math.max(values[index] + way * (most - least) / 50, least), most);
      show();
    });
    const load = document.createElement("div");
    load.className = "load";
    const words = document.createElement("span");
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    const text = document.createElement("span");
    words.append(swatch, text);
    const worst = document.createElement("button");
    worst.type = "button";
    worst.textContent = "Worst pose";
    worst.setAttribute("aria-label", `Worst pose of ${freedom.name}`);
    worst.addEventListener("click", () => { stop(); chosen = index; take(freedom.worst); show(); });
    load.append(words, worst);
    row.append(label, slider, load);
    list.append(row);
    return { slider, value, swatch, text };
  });

  // Joint coordinates as the rig has them: a ball joint's quaternion is not shown by its sliders, and stays at home.
  const take = (q) => {
    let place = 0;
    RIG.bodies.forEach((body, index) => {
      const count = { revolute: 1, prismatic: 1, universal: 2, spherical: 4, free: 7 }[body.kind] || 0;
      if (count <= 2) OF_BODY[index].forEach((slider, axis) => { values[slider] = q[place + axis]; });
      place += count;
    });
  };

  let asked = false;
  const show = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      const poses = solve();
      const efforts = loads(poses);
      rows.forEach((row, index) => {
        const freedom = RIG.freedoms[index];
        row.slider.value = values[index];
        row.slider.setAttribute("aria-valuetext", shown(freedom, values[index]));
        row.value.textContent = shown(freedom, values[index]) + (freedom.limited ? "" : " (no limit)");
        const unit = freedom.slides ? "N" : "N m";
        const of = freedom.capacity > 0
          ? `, ${(100 * share(efforts[index], freedom)).toFixed(0)} % of ${number(freedom.capacity)}` : "";
        row.text.textContent = `${number(efforts[index])} ${unit}${of}`;
        row.swatch.style.background = shade(share(efforts[index], freedom));
      });
      draw(poses, efforts);
    });
  };

  // ---- Motion: every joint in turn through its range, then all together ----
  let since = null;
  const SECONDS = 1.6;
  const stop = () => { since = null; play.setAttribute("aria-pressed", "false"); };
  const tick = (now) => {
    if (since === null) return;
    const time = (now - since) / 1000;
    const turn = Math.floor(time / SECONDS) % (RIG.freedoms.length + 2);
    const phase = 2 * Math.PI * (time % SECONDS) / SECONDS;
    RIG.freedoms.forEach((freedom, index) => {
      const all = turn >= RIG.freedoms.length;
      const [least, most] = freedom.range;
      const reach = Math.sin(phase) * (all ? 0.35 : 0.8);
      const way = reach > 0 ? most - freedom.home : freedom.home - least;
      values[index] = index === turn || all ? freedom.home + reach * Math.min(way, freedom.slides ? 1 : 1.4) : freedom.home;
    });
    if (turn < RIG.freedoms.length) chosen = turn;
    show();
    requestAnimationFrame(tick);
  };
  const start = () => {
    if (RIG.freedoms.length === 0) return;
    since = performance.now();
    play.setAttribute("aria-pressed", "true");
    requestAnimationFrame(tick);
  };
  play.addEventListener("click", () => since === null ? start() : stop());
  document.getElementById("home").addEventListener("click", () => {
    stop();
    RIG.freedoms.forEach((freedom, index) => { values[index] = freedom.home; });
    show();
  });
  document.getElementById("zero").addEventListener("click", () => {
    stop();
    RIG.freedoms.forEach(({ range: [least, most] }, index) => { values[index] = Math.min(Math.max(0, least), most); });
    show();
  });

  // ---- Camera ----
  const turnView = (yaw, pitch) => {
    camera.yaw += yaw;
    camera.pitch = Math.min(Math.max(camera.pitch + pitch, -1.5), 1.5);
    show();
  };
  const zoom = (factor) => {
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
  addEventListener("resize", show);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  show();
  // A rig that moves says more than one that stands; who asked for no motion starts it by hand.
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) start();
})();
