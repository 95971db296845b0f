// ---- One time for everything on the page: play, stop and seek ----
// `draw` draws the page at a time. Returns `show`, which requests a drawing, `seek` and `setPlaying`.
const transport = (draw) => {
  const [play, scrubber, clock, charts] = ["play", "scrubber", "clock", "charts"].map((id) => document.getElementById(id));
  let time = 0, playing = false, before = null, asked = false;
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
      draw(time);
      scrubber.value = time;
      scrubber.setAttribute("aria-valuetext", `${time.toFixed(2)} of ${END.toFixed(2)} s`);
      clock.textContent = `${time.toFixed(2)} s`;
      if (playing) show();
    });
  };
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

  play.addEventListener("click", () => setPlaying(!playing));
  scrubber.addEventListener("input", () => seek(Number(scrubber.value)));
  const seekIn = (event) => {
    const area = event.target.closest(".area");
    if (!area || event.buttons !== 1) return;
    const { left, width } = area.getBoundingClientRect();
    seek(END * (event.clientX - left) / width);
  };
  for (const kind of ["pointerdown", "pointermove"]) charts.addEventListener(kind, seekIn);
  // If no control uses these keys: space starts and stops playing, arrows move by a tenth of a second.
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (event.target.closest("input, select, button, canvas, a, .scroll, ol")) return;
    const done = {
      " ": () => setPlaying(!playing),
      ArrowLeft: () => seek(time - 0.1), ArrowRight: () => seek(time + 0.1),
    }[event.key];
    if (done) { event.preventDefault(); done(); }
  });
  for (const control of [scrubber, document.getElementById("stage")]) {
    control.addEventListener("keydown", (event) => {
      if (event.key === " ") { event.preventDefault(); setPlaying(!playing); }
    });
  }
  return { show, seek, setPlaying };
};

// Marks an interval of time on the strip below the scrubber.
const onStrip = (from, to, className = "") => {
  if (from > END) return;
  const [left, right] = [from, Math.min(to, END)].map((at) => 100 * at / END);
  document.getElementById("strip").append(element("i", { className, style: `left: ${left}%; width: ${right - left}%` }));
};
const still = matchMedia("(prefers-reduced-motion: reduce)");

// ---- One chosen joint for the plots and the table: `shown` receives its index ----
const joints = (shown) => {
  const joint = document.getElementById("joint");
  const rows = [...document.querySelectorAll("#joints tbody tr")];
  const choose = (index) => {
    joint.value = index;
    rows.forEach((row, place) => {
      row.classList.toggle("chosen", place === index);
      row.querySelector("button").setAttribute("aria-pressed", place === index);
    });
    shown(index);
  };
  const bring = () => document.getElementById("plots")
    .scrollIntoView({ block: "nearest", behavior: still.matches ? "auto" : "smooth" });
  rows.forEach((row, index) => row.addEventListener("click", () => { choose(index); bring(); }));
  joint.addEventListener("change", () => choose(Number(joint.value)));
  return { rows, choose };
};
