// The rig in 3D: the measured pose as solid bodies, the commanded pose as lines, the show's ghost as broken lines.

import { byId, effort, make, position, write } from "./dom.js";
import { kinematicsOf, shade, stageOn } from "./renderer.js";

const LEGEND = [["solid", "measured"], ["wanted", "commanded"], ["ghost", "ghost of the show"]];
const LOADS = [0, 0.5, 1];

const legend = (hasLoads) => {
  const items = LEGEND.map(([name, text]) => make("span", {}, make("i", { className: `key ${name}` }), text));
  if (hasLoads) {
    const dots = LOADS.map((share) => {
      const dot = make("i", { className: "key dot" });
      dot.style.background = shade(share);
      return dot;
    });
    items.push(make("span", {}, ...dots, "load"));
  }
  byId("legend").replaceChildren(...items);
};

// Points that the rig reaches if one joint moves a third of the way to an end of its range, for each joint and end.
const reach = (rig) => rig.dofs.flatMap((dof, index) => dof.range.flatMap((end) => {
  rig.values[index] = dof.home + (end - dof.home) / 3;
  const points = rig.pointsOf(rig.solve());
  rig.values[index] = dof.home;
  return points;
}));

// `choose`: called with the joint that the user clicks on.
export const view = (head, choose) => {
  // A new canvas has no listeners from an earlier rig.
  const old = byId("stage");
  const canvas = old.cloneNode();
  old.replaceWith(canvas);
  const rig = kinematicsOf(head);
  const hasLoads = head.dofs.some((dof) => dof.effort > 0);
  legend(hasLoads);

  let frame = null, chosen = -1, isAsked = false, swings = new Set();
  const shares = () => head.dofs.map((dof, index) =>
    frame && dof.effort > 0 ? Math.abs(frame.effort[index]) / dof.effort : null);
  const posesAt = (coordinates) => {
    rig.take(coordinates);
    return rig.solve();
  };
  const paint = () => {
    isAsked = false;
    if (!frame) { stage.draw(rig.solve(), shares(), { chosen }); return; }
    const { measured, wanted, ghost } = frame;
    const ghostPoses = ghost && posesAt(ghost);
    const sent = wanted.some(Number.isFinite)
      ? posesAt(wanted.map((x, i) => Number.isFinite(x) ? x : measured[i])) : null;
    // A joint without a measured position is drawn at its commanded position.
    const poses = posesAt(measured.map((x, i) => Number.isFinite(x) ? x : wanted[i]));
    const isDriven = head.bodies[0]?.kind === "free";
    const way = isDriven ? [poses[0].p[0] - home[0].p[0], 0, poses[0].p[2] - home[0].p[2]] : [0, 0, 0];
    stage.draw(poses, shares(), {
      chosen, sent, ghost: ghostPoses, way,
      marked: (index) => frame.limit[index] !== null && frame.limit[index] !== undefined || swings.has(index),
    });
    const dof = head.dofs[chosen];
    write(byId("picked"), dof
      ? `${dof.name}: ${position(dof, rig.values[chosen])}, range ${position(dof, dof.range[0])} to ${position(dof, dof.range[1])}`
        + (dof.effort > 0 ? `, ${effort(dof, frame.effort[chosen])} of ${effort(dof, dof.effort)}` : "")
      : "Click on a joint of the rig to choose it.");
  };
  const show = () => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(paint);
  };
  const home = rig.solve();
  const covered = () => ["legend", "picked"].map((id) => byId(id).offsetHeight);
  const stage = stageOn(rig, canvas, [...rig.pointsOf(home), ...reach(rig)], show, covered);
  new ResizeObserver(stage.fit).observe(canvas);
  byId("front").onclick = () => { stage.front(); };

  // A click that does not turn the view chooses a joint.
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  canvas.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const joint = stage.jointAt(event.offsetX, event.offsetY);
    if (joint >= 0) choose(joint);
  });
  show();
  return {
    take: (now, swinging) => { frame = now; swings = swinging; show(); },
    choose: (joint) => { chosen = joint; show(); },
  };
};
