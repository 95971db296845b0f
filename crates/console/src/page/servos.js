// A row for each servo. Words mark a servo that swings, is hot, is limited or has errors.

import { byId, effort, make, number, position, setHidden, write } from "./dom.js";

const HOT_PERCENT = 80;
const HOT_C = 60;
// A servo counts as hot if its temperature is less than this below its own limit, °C.
const NEAR_C = 8;
const ERRORS_SINCE_MS = 10000;

const COLUMNS = ["Servo", "Goal", "Position", "Load", "°C", "Heat", "Volts", "Bus errors"];

export const servos = (head, choose) => {
  const table = byId("servo-table");
  const rows = head.servos.map((servo) => {
    const cells = Object.fromEntries(
      ["goal", "position", "load", "celsius", "heat", "volts", "errors"].map((name) => [name, make("td")]));
    const [bar, text] = [make("i", { className: "bar" }), make("span")];
    cells.load.append(bar, text);
    const flags = make("span", { className: "flags" });
    const where = [servo.line, servo.id === null || servo.id === undefined ? null : `id ${servo.id}`, servo.class];
    const name = make("th", { scope: "row" },
      servo.dof === null ? servo.name : make("button", { type: "button", className: "plain", onclick: () => choose(servo.dof) }, servo.name),
      make("small", {}, where.filter((part) => part !== null && part !== undefined).join(" · ")), flags);
    const row = make("tr", {}, name, ...Object.values(cells));
    return { row, flags, bar, text, cells, errors: [] };
  });
  table.replaceChildren(
    make("caption", { className: "hidden" }, "Servos"),
    make("thead", {}, make("tr", {}, ...COLUMNS.map((name) => make("th", { scope: "col" }, name)))),
    make("tbody", {}, ...rows.map(({ row }) => row)));

  // Bus errors of the last 10 s.
  const recent = (row, errors, now) => {
    row.errors.push([now, errors]);
    while (row.errors.length > 1 && now - row.errors[0][0] > ERRORS_SINCE_MS) row.errors.shift();
    return errors - row.errors[0][1];
  };
  // Returns the marks of a servo.
  const oddOf = (servo, index, frame, swings, newErrors) => {
    const odd = [];
    const celsius = frame.celsius[index];
    const limit = servo.dof === null ? null : frame.limit[servo.dof];
    const hotFrom = servo.hot_c ? servo.hot_c - NEAR_C : HOT_C;
    if (frame.ownError[index] !== 0) odd.push(["fault", `servo error ${frame.ownError[index]}`]);
    if (swings.has(servo.dof)) odd.push(["fault", "swings"]);
    if (celsius !== null && celsius >= hotFrom || frame.heat[index] >= HOT_PERCENT) odd.push(["hot", "hot"]);
    if (limit !== null && limit !== undefined) odd.push(["limited", `limited by ${head.limits[limit] ?? limit}`]);
    if (newErrors > 0) odd.push(["limited", "bus errors"]);
    return odd;
  };

  return {
    take: (frame, swings) => {
      const now = performance.now();
      let count = 0;
      head.servos.forEach((servo, index) => {
        const row = rows[index];
        const dof = servo.dof === null ? null : head.dofs[servo.dof];
        const errors = frame.errors[index];
        const newErrors = recent(row, errors, now);
        const odd = oddOf(servo, index, frame, swings, newErrors);
        if (odd.length > 0) count += 1;
        const key = odd.map(([, text]) => text).join();
        if (row.flags.dataset.key !== key) {
          row.flags.dataset.key = key;
          row.flags.replaceChildren(...odd.map(([kind, text]) => make("b", { className: kind }, text)));
          row.row.className = odd[0]?.[0] ?? "";
        }
        const { cells } = row;
        if (dof) {
          write(cells.goal, position(dof, frame.wanted[dof.coordinate]));
          write(cells.position, position(dof, frame.measured[dof.coordinate]));
          const load = frame.effort[servo.dof];
          const share = dof.effort > 0 ? Math.min(Math.abs(load) / dof.effort, 1) : 0;
          row.bar.style.setProperty("--part", Number.isFinite(share) ? share.toFixed(3) : "0");
          row.bar.classList.toggle("much", share >= 0.8);
          write(row.text, effort(dof, load));
        }
        write(cells.celsius, number(frame.celsius[index] ?? NaN, 0));
        write(cells.heat, `${frame.heat[index]} %`);
        write(cells.volts, number(frame.volts[index] ?? NaN, 1));
        write(cells.errors, newErrors > 0 ? `${errors} (+${newErrors})` : String(errors));
      });
      write(byId("servos-hint"),
        `Supply ${frame.supply > 0 ? `${number(frame.supply, 1)} V` : "not measured"}. Heat: of the winding, computed, in % of its maximum. `
        + (count === 0 ? "No servo is marked." : `${count} of ${head.servos.length} servos are marked.`));
      setHidden(byId("odd"), count === 0);
      write(byId("odd"), String(count));
    },
  };
};
