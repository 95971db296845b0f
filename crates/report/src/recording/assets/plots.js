
// ---- Plots of one joint over time: each is an SVG that is stretched to its box, with texts as HTML over it ----
const KINDS = [
  { title: "Position", lines: ["commanded", "measured"], unit: ["°", " mm"], factor: [180 / Math.PI, 1000], decimals: 1 },
  { title: "Error", lines: ["error"], unit: ["°", " mm"], factor: [180 / Math.PI, 1000] },
  { title: "Torque", lines: ["effort"], unit: [" N m", " N"], factor: [1, 1], isLimited: true },
  { title: "Current", lines: ["current"], unit: [" A", " A"], factor: [1, 1] },
];

// By joint and sample: number of the limiter, counted from 1; 0 for none.
const unpacked = (codes) =>
  codes === "" ? new Uint8Array(SHOW.count) : Uint8Array.from(atob(codes), (c) => c.charCodeAt(0));
const LIMITED = SHOW.limited.map(unpacked);
// By joint and sample: 1 if the joint swings.
const SWINGS = SHOW.swings.map(unpacked);
const codeAt = (codes, time) => {
  const [sample, share] = placeOf(time);
  return codes[Math.min(sample + (share < 0.5 ? 0 : 1), SHOW.count - 1)];
};
const limiterAt = (joint, time) => {
  const code = codeAt(LIMITED[joint], time);
  return code === 0 ? null : SHOW.limiters[code - 1] ?? "a limit";
};

// Returns the intervals in which a joint is limited, in samples.
const limitedSpans = (joint) => {
  const spans = [];
  LIMITED[joint].forEach((code, sample) => {
    if (code === 0) return;
    const last = spans.at(-1);
    if (last && last[1] === sample) last[1] += 1;
    else spans.push([sample, sample + 1]);
  });
  return spans;
};

// Returns a plot as `figure`, and `now`, which shows the values at a time.
const plot = ({ title, lines, unit, factor, decimals, isLimited }, joint) => {
  const dof = RIG.dofs[joint];
  const [words, scale] = [unit, factor].map((of) => of[dof.slides ? 1 : 0]);
  const say = (x) => Number.isNaN(x) ? "unknown" : number(x, decimals) + words;
  const courses = lines.map((line) => COURSES[line][joint].map((x) => x * scale));
  let least = Infinity, most = -Infinity;
  for (const x of courses.flatMap((course) => [...course]).filter(Number.isFinite)) {
    [least, most] = [Math.min(least, x), Math.max(most, x)];
  }
  const isKnown = least <= most;
  if (!isKnown) [least, most] = [0, 0];
  let [low, high] = [Math.min(least, 0), Math.max(most, 0)];
  if (high - low < 1e-9) [low, high] = [low - 1, high + 1];
  const margin = 0.12 * (high - low);
  [low, high] = [low - margin, high + margin];

  const y = (value) => 100 * (high - value) / (high - low);
  const x = (sample) => WIDTH * sample / Math.max(SHOW.count - 1, 1);
  const svg = drawn("svg", { viewBox: `0 0 ${WIDTH} 100`, preserveAspectRatio: "none", "aria-hidden": "true" });
  for (const { name, from_s: from, to_s: to } of SHOW.states) {
    if (name === "playing" || from > END) continue;
    const [left, right] = [from, Math.min(to, END)].map((time) => WIDTH * time / END);
    svg.append(drawn("rect", { class: "idle", x: left, width: right - left, y: 0, height: 100 }));
  }
  for (const [from, to] of isLimited ? limitedSpans(joint) : []) {
    svg.append(drawn("rect", { class: "excess", x: x(from - 0.5), width: x(to) - x(from), y: 0, height: 100 }));
  }
  svg.append(drawn("line", { class: "zero", x1: 0, x2: WIDTH, y1: y(0), y2: y(0) }));
  courses.forEach((course, index) => svg.append(drawn("path", { class: `course ${lines[index]}`, d: outline(course, x, y) })));
  for (const time of SHOW.faults.filter((time) => time <= END)) {
    const at = WIDTH * time / END;
    svg.append(drawn("line", { class: "fault", x1: at, x2: at, y1: 0, y2: 100 }));
  }

  // Texts beside the lines, if they do not overlap.
  const ticks = element("div", { className: "ticks", ariaHidden: "true" });
  const taken = [];
  for (const value of [0, most, least]) {
    if (taken.some((other) => Math.abs(y(other) - y(value)) < 18)) continue;
    taken.push(value);
    ticks.append(element("span", { textContent: number(value, decimals), style: `top: ${y(value)}%` }));
  }

  const values = lines.map((line) => element("span", { className: `value ${line}` }));
  const limiter = element("span", { className: "flag" });
  const told = element("span", { className: "told", textContent: isKnown ? `${say(least)} to ${say(most)}` : "not known" });
  const caption = element("figcaption", {}, [element("b", { textContent: title }), ...values, limiter, told]);
  const area = element("div", { className: "area", role: "img", ariaLabel: `${title} over time: ${told.textContent}` },
    [svg, element("div", { className: "cursor" })]);
  return {
    figure: element("figure", {}, [caption, element("div", { className: "plot" }, [ticks, area])]),
    now: (time) => {
      values.forEach((value, index) => {
        const name = lines.length > 1 ? `${lines[index]} ` : "";
        value.textContent = name + say(between(courses[index], placeOf(time)));
      });
      const by = isLimited ? limiterAt(joint, time) : null;
      limiter.textContent = by === null ? "" : `limited by ${by}`;
      area.lastChild.style.left = `${100 * time / END}%`;
    },
  };
};
