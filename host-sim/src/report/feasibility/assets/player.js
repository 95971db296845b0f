
// ---- The player: one time and one joint for the rig, the plots and the tables ----
(() => {
  const find = (id) => document.getElementById(id);
  const [play, scrubber, clock, charts, joint] = ["play", "scrubber", "clock", "charts", "joint"].map(find);
  const rows = [...document.querySelectorAll("#joints tbody tr")];
  const items = [...document.querySelectorAll("[data-excess]")].map((button) => ({
    button, excess: SHOW.excesses[Number(button.dataset.excess)],
  }));
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let time = 0, chosen = 0, playing = false, before = null, asked = false, plots = [];

  // ---- What is seen at a time ----
  // A mark that is shorter than a blink is not seen.
  const BLINK = 0.06;
  const isNow = ({ from_s: from, to_s: to }) => from - BLINK <= time && time <= to + BLINK;
  const shares = () => RIG.freedoms.map(({ effort, continuous }, index) => {
    const limit = effort ?? continuous;
    return limit > 0 ? Math.abs(between(COURSES.effort[index], placeOf(time))) / limit : null;
  });
  const show = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame((now) => {
      asked = false;
      if (playing) {
        if (before !== null) time += (now - before) / 1000;
        before = now;
        if (time > END) time = 0;
      }
      takePose(time);
      const poses = solve();
      const marks = new Set(SHOW.excesses.filter(isNow).map((excess) => excess.joint));
      draw(poses, shares(), { chosen, marked: (index) => marks.has(index), way: wayOf(poses) });
      scrubber.value = time;
      scrubber.setAttribute("aria-valuetext", `${time.toFixed(2)} of ${END.toFixed(2)} s`);
      clock.textContent = `${time.toFixed(2)} s`;
      for (const { now } of plots) now(time);
      rows.forEach((row, index) => row.classList.toggle("now", marks.has(index)));
      for (const { button, excess } of items) button.classList.toggle("now", isNow(excess));
      if (playing) show();
    });
  };
  const { draw, approach } = stageOn(find("stage"), everywhere(), show);
  approach();

  const setPlaying = (value) => {
    playing = value && END > 0;
    before = null;
    play.textContent = playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", playing ? "Pause" : "Play");
    show();
  };
  const seek = (to) => {
    setPlaying(false);
    time = Math.min(Math.max(to, 0), END);
    show();
  };

  // ---- Which joint ----
  const choose = (index) => {
    chosen = index;
    joint.value = index;
    plots = KINDS.map((kind) => plot(kind, index));
    charts.replaceChildren(...plots.map(({ figure }) => figure));
    rows.forEach((row, place) => {
      row.classList.toggle("chosen", place === index);
      row.querySelector("button").setAttribute("aria-pressed", place === index);
    });
    show();
  };
  const bring = () => find("plots").scrollIntoView({ block: "nearest", behavior: still.matches ? "auto" : "smooth" });
  rows.forEach((row, index) => row.addEventListener("click", () => { choose(index); bring(); }));
  joint.addEventListener("change", () => choose(Number(joint.value)));
  for (const { button, excess } of items) {
    button.addEventListener("click", () => {
      if (excess.joint !== null) choose(excess.joint);
      seek(excess.worst_s);
    });
  }

  // ---- Time ----
  const strip = find("strip");
  for (const { from_s: from, to_s: to } of SHOW.excesses) {
    if (from > END) continue;
    const [left, right] = [from, Math.min(to, END)].map((at) => 100 * at / END);
    strip.append(element("i", { style: `left: ${left}%; width: ${right - left}%` }));
  }
  play.addEventListener("click", () => setPlaying(!playing));
  scrubber.addEventListener("input", () => seek(Number(scrubber.value)));
  const seekIn = (event) => {
    const area = event.target.closest(".area");
    if (!area || event.buttons !== 1) return;
    const { left, width } = area.getBoundingClientRect();
    seek(END * (event.clientX - left) / width);
  };
  for (const kind of ["pointerdown", "pointermove"]) charts.addEventListener(kind, seekIn);
  // Wherever no control takes the keys for itself: space plays, arrows go a tenth of a second.
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (event.target.closest("input, select, button, canvas, a, .scroll, ol")) return;
    const done = {
      " ": () => setPlaying(!playing),
      ArrowLeft: () => seek(time - 0.1), ArrowRight: () => seek(time + 0.1),
    }[event.key];
    if (done) { event.preventDefault(); done(); }
  });
  for (const control of [scrubber, find("stage")]) {
    control.addEventListener("keydown", (event) => {
      if (event.key === " ") { event.preventDefault(); setPlaying(!playing); }
    });
  }

  // First the joint of the first excess, or the one with the most load.
  const loads = RIG.freedoms.map(({ effort, continuous }, index) =>
    COURSES.effort[index].reduce((most, x) => Math.max(most, Math.abs(x)), 0) / (effort ?? continuous ?? Infinity));
  const first = SHOW.excesses.reduce((a, b) => a && a.from_s <= b.from_s ? a : b, null);
  if (RIG.freedoms.length > 0) choose(first?.joint ?? loads.indexOf(Math.max(...loads)));
  show();
  // A rig that moves says more than one that stands; who asked for no motion starts it by hand.
  if (!still.matches) setPlaying(true);
})();
