(() => {
  const list = document.getElementById("sliders");
  const play = document.getElementById("move");
  let chosen = -1;

  const share = (load, dof) => dof.capacity > 0 ? Math.abs(load) / dof.capacity : 0;
  const number = (signed) => {
    // Avoids a negative zero.
    const x = Math.abs(signed) < 0.0005 ? 0 : signed;
    return Math.abs(x) >= 100 ? x.toFixed(0) : Math.abs(x) >= 1 ? x.toFixed(2) : x.toFixed(3);
  };
  const degrees = (x) => (x * 180 / Math.PI).toFixed(1) + "°";
  const shown = (dof, x) => dof.slides ? (x * 1000).toFixed(1) + " mm" : degrees(x);

  // ---- Sliders ----
  const rows = RIG.dofs.map((dof, index) => {
    const row = document.createElement("li");
    const id = `joint-${index}`;
    const label = document.createElement("label");
    label.htmlFor = id;
    const name = document.createElement("span");
    name.textContent = dof.name;
    const value = document.createElement("span");
    label.append(name, value);
    const slider = document.createElement("input");
    Object.assign(slider, { type: "range", id, min: dof.range[0], max: dof.range[1], step: "any" });
    slider.addEventListener("input", () => { stop(); values[index] = Number(slider.value); chosen = index; show(); });
    slider.addEventListener("focus", () => { chosen = index; show(); });
    slider.addEventListener("keydown", (event) => {
      // Steps of a fiftieth of the range: with "any", the browser would choose the step.
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!way) return;
      event.preventDefault();
      const [least, most] = dof.range;
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
    worst.setAttribute("aria-label", `Worst pose of ${dof.name}`);
    worst.addEventListener("click", () => { stop(); chosen = index; take(dof.worst); show(); });
    load.append(words, worst);
    row.append(label, slider, load);
    list.append(row);
    return { slider, value, swatch, text };
  });

  // Sets the sliders to coordinates of the rig. Sliders cannot show the quaternion of a ball joint: it stays at home.
  const take = (q) => {
    RIG.bodies.forEach((body, index) => {
      if (COUNT[body.kind] <= 2) OF_BODY[index].forEach((slider, axis) => { values[slider] = q[FIRST[index] + axis]; });
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
        const dof = RIG.dofs[index];
        row.slider.value = values[index];
        row.slider.setAttribute("aria-valuetext", shown(dof, values[index]));
        row.value.textContent = shown(dof, values[index]) + (dof.limited ? "" : " (no limit)");
        const unit = dof.slides ? "N" : "N m";
        const of = dof.capacity > 0
          ? `, ${(100 * share(efforts[index], dof)).toFixed(0)} % of ${number(dof.capacity)}` : "";
        row.text.textContent = `${number(efforts[index])} ${unit}${of}`;
        row.swatch.style.background = shade(share(efforts[index], dof));
      });
      draw(poses, RIG.dofs.map((dof, index) => share(efforts[index], dof)), { chosen });
    });
  };

  const { draw } = stageOn(RIG, document.getElementById("stage"), pointsOf(solve()), show);

  // ---- Motion: each joint in turn through its range, then all joints together ----
  let since = null;
  const SECONDS = 1.6;
  const stop = () => { since = null; play.setAttribute("aria-pressed", "false"); };
  const tick = (now) => {
    if (since === null) return;
    const time = (now - since) / 1000;
    const turn = Math.floor(time / SECONDS) % (RIG.dofs.length + 2);
    const phase = 2 * Math.PI * (time % SECONDS) / SECONDS;
    RIG.dofs.forEach((dof, index) => {
      const all = turn >= RIG.dofs.length;
      const [least, most] = dof.range;
      const reach = Math.sin(phase) * (all ? 0.35 : 0.8);
      const way = reach > 0 ? most - dof.home : dof.home - least;
      values[index] = index === turn || all ? dof.home + reach * Math.min(way, dof.slides ? 1 : 1.4) : dof.home;
    });
    if (turn < RIG.dofs.length) chosen = turn;
    show();
    requestAnimationFrame(tick);
  };
  const start = () => {
    if (RIG.dofs.length === 0) return;
    since = performance.now();
    play.setAttribute("aria-pressed", "true");
    requestAnimationFrame(tick);
  };
  play.addEventListener("click", () => since === null ? start() : stop());
  document.getElementById("home").addEventListener("click", () => {
    stop();
    RIG.dofs.forEach((dof, index) => { values[index] = dof.home; });
    show();
  });
  document.getElementById("zero").addEventListener("click", () => {
    stop();
    RIG.dofs.forEach(({ range: [least, most] }, index) => { values[index] = Math.min(Math.max(0, least), most); });
    show();
  });

  show();
  // The motion starts at once, unless the user prefers reduced motion.
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) start();
})();
