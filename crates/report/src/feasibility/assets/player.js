
// ---- The player: one time and one joint for the rig, the plots and the tables ----
(() => {
  const items = [...document.querySelectorAll("[data-excess]")].map((button) => ({
    button, excess: SHOW.excesses[Number(button.dataset.excess)],
  }));
  let chosen = 0, plots = [];

  // Time for which a mark is also shown before and after its excess, s: otherwise nobody would see a short one.
  const BLINK = 0.06;
  const isAt = (time) => ({ from_s: from, to_s: to }) => from - BLINK <= time && time <= to + BLINK;
  const sharesAt = (time) => RIG.dofs.map(({ effort, continuous }, index) => {
    const limit = effort ?? continuous;
    return limit > 0 ? Math.abs(between(COURSES.effort[index], placeOf(time))) / limit : null;
  });
  const { show, seek, setPlaying } = transport((time) => {
    takePose(time);
    const poses = solve();
    const marks = new Set(SHOW.excesses.filter(isAt(time)).map((excess) => excess.joint));
    draw(poses, sharesAt(time), { chosen, marked: (index) => marks.has(index), way: wayOf(poses) });
    for (const { now } of plots) now(time);
    rows.forEach((row, index) => row.classList.toggle("now", marks.has(index)));
    for (const { button, excess } of items) button.classList.toggle("now", isAt(time)(excess));
  });
  const { draw, approach } = stageOn(RIG, document.getElementById("stage"), everywhere(), show);
  approach();

  const { rows, choose } = joints((index) => {
    chosen = index;
    plots = KINDS.map((kind) => plot(kind, index));
    document.getElementById("charts").replaceChildren(...plots.map(({ figure }) => figure));
    show();
  });
  for (const { button, excess } of items) {
    button.addEventListener("click", () => {
      if (excess.joint !== null) choose(excess.joint);
      seek(excess.worst_s);
    });
  }
  for (const { from_s: from, to_s: to } of SHOW.excesses) onStrip(from, to);

  // Initially chosen: the joint of the first excess, or the joint with the largest load.
  const loads = RIG.dofs.map(({ effort, continuous }, index) =>
    COURSES.effort[index].reduce((most, x) => Math.max(most, Math.abs(x)), 0) / (effort ?? continuous ?? Infinity));
  const first = SHOW.excesses.reduce((a, b) => a && a.from_s <= b.from_s ? a : b, null);
  if (RIG.dofs.length > 0) choose(first?.joint ?? loads.indexOf(Math.max(...loads)));
  show();
  // Playing starts at once, unless the user prefers reduced motion.
  if (!still.matches) setPlaying(true);
})();
