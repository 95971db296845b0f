
// ---- The player: one time and one joint for the rig, the plots and the tables ----
// Sets the rig to its measured or commanded pose. The numbers of a ball joint are its rotation vector.
RIG.bodies.forEach((body, index) => { if (body.kind === "spherical") given[index] = [0, 0, 0, 1]; });
const takePose = (time, kind = "measured") => {
  const place = placeOf(time);
  RIG.dofs.forEach((dof, index) => {
    const now = between(COURSES[kind][index], place);
    values[index] = Number.isNaN(now) ? dof.home : now;
  });
};

(() => {
  // Error at the end of the colour scale, rad and m.
  const MOST = [10 * Math.PI / 180, 0.01];
  const sharesAt = (time) => RIG.dofs.map(({ slides }, index) => {
    // A joint that swings has the colour of a large error, even if it is near its target.
    if (codeAt(SWINGS[index], time) > 0) return 1;
    const error = between(COURSES.error[index], placeOf(time));
    return Number.isNaN(error) ? null : Math.abs(error) / MOST[slides ? 1 : 0];
  });
  const events = [...document.querySelectorAll("#excesses button")];
  let chosen = 0, plots = [];
  const { show, seek, setPlaying } = transport((time) => {
    takePose(time, "commanded");
    const sent = solve();
    takePose(time);
    draw(solve(), sharesAt(time), { chosen, sent });
    for (const { now } of plots) now(time);
    const last = events.filter((button) => Number(button.dataset.at) <= time + 1e-9).at(-1) ?? events[0];
    for (const button of events) button.classList.toggle("now", button === last);
  });
  const { draw, approach } = stageOn(RIG, document.getElementById("stage"), everywhere(), show);
  approach();

  const { choose } = joints((index) => {
    chosen = index;
    plots = KINDS.map((kind) => plot(kind, index));
    document.getElementById("charts").replaceChildren(...plots.map(({ figure }) => figure));
    show();
  });
  for (const button of document.querySelectorAll("[data-at]")) {
    button.addEventListener("click", () => seek(Number(button.dataset.at)));
  }
  for (const { name, from_s: from, to_s: to } of SHOW.states) if (name === "playing") onStrip(from, to, "playing");
  for (const time of SHOW.faults) onStrip(time, time, "fault");

  // Initially chosen: the joint with the largest error, at the start of the show.
  const most = COURSES.error.map((course) => course.reduce((most, x) => Math.max(most, Math.abs(x) || 0), 0));
  if (RIG.dofs.length > 0) choose(most.indexOf(Math.max(...most)));
  const begin = SHOW.states.find(({ name }) => name === "playing");
  if (begin) seek(begin.from_s);
  show();
  // Playing starts at once, unless the user prefers reduced motion.
  if (!still.matches) setPlaying(true);
})();
