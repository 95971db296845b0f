
// ---- Plots of one joint over time: each is an SVG that is stretched to its box, with texts as HTML over it ----
const KINDS = [
  { kind: "position", title: "Position", unit: ["°", " mm"], factor: [180 / Math.PI, 1000] },
  { kind: "speed", title: "Speed", unit: [" rad/s", " m/s"], factor: [1, 1] },
  { kind: "acceleration", title: "Acceleration", unit: [" rad/s²", " m/s²"], factor: [1, 1] },
  { kind: "effort", title: "Torque", unit: [" N m", " N"], factor: [1, 1] },
];
// Positions have one decimal, as in the tables.
const worded = (kind) => kind === "position" ? (x) => number(x, 1) : (x) => number(x);

// Returns the limits of a dof in a plot, lower and upper; empty if it has none. A missing limit is null in the data.
const limitsOf = (dof, kind) => {
  if (kind === "position") return dof.position.filter((x) => x !== null);
  return dof[kind] === null ? [] : [-dof[kind], dof[kind]];
};

// Returns a plot as `figure`, and `now`, which shows the value at a time.
const plot = ({ kind, title, unit, factor }, joint) => {
  const dof = RIG.dofs[joint];
  const [words, scale] = [unit, factor].map((of) => of[dof.slides ? 1 : 0]);
  const say = worded(kind);
  const course = COURSES[kind][joint].map((x) => x * scale);
  const limits = limitsOf(dof, kind).map((x) => x * scale);
  const long = kind === "effort" && dof.continuous !== null ? dof.continuous : null;
  let least = Infinity, most = -Infinity;
  for (const x of course) [least, most] = [Math.min(least, x), Math.max(most, x)];
  const peak = Math.max(Math.abs(least), Math.abs(most));
  // A limit that is far away would make the trace a flat line: it is only written in the caption.
  const near = limits.filter((limit) => Math.abs(limit) <= Math.max(3 * peak, 1e-9));
  let [low, high] = [Math.min(least, 0, ...near), Math.max(most, 0, ...near)];
  if (high - low < 1e-9) [low, high] = [low - 1, high + 1];
  const margin = 0.12 * (high - low);
  [low, high] = [low - margin, high + margin];

  const y = (value) => 100 * (high - value) / (high - low);
  const x = (sample) => WIDTH * sample / Math.max(SHOW.count - 1, 1);
  const svg = drawn("svg", { viewBox: `0 0 ${WIDTH} 100`, preserveAspectRatio: "none", "aria-hidden": "true" });
  for (const excess of SHOW.excesses) {
    if (excess.joint !== joint || excess.plot !== kind) continue;
    const [from, to] = [excess.from_s, excess.to_s].map((time) => Math.min(WIDTH * time / END, WIDTH));
    svg.append(drawn("rect", { class: "excess", x: from - 1.5, width: to - from + 3, y: 0, height: 100 }));
  }
  const level = (value, style) => {
    if (value <= low || value >= high) return;
    svg.append(drawn("line", { class: style, x1: 0, x2: WIDTH, y1: y(value), y2: y(value) }));
  };
  level(0, "zero");
  for (const limit of near) level(limit, "limit");
  for (const sign of long === null ? [] : [-1, 1]) level(sign * long, "long");
  svg.append(drawn("path", { class: "course", d: outline(course, x, y) }));

  // Texts beside the lines, if they do not overlap.
  const ticks = element("div", { className: "ticks", ariaHidden: "true" });
  const taken = [];
  for (const value of [...near, 0, most, least]) {
    if (taken.some((other) => Math.abs(y(other) - y(value)) < 18)) continue;
    taken.push(value);
    ticks.append(element("span", { textContent: say(value), style: `top: ${y(value)}%` }));
  }

  const told = limits.length === 0 ? "no limit"
    : kind === "position" ? `range ${limits.map(say).join(" to ")}${words}` : `limit ${say(limits.at(-1))}${words}`;
  const far = near.length < limits.length ? " (outside the plot)" : "";
  const lasting = long === null ? "" : `, for long ${say(long)}${words}`;
  const range = kind === "position" ? `from ${say(least)} to ${say(most)}${words}` : `at most ${say(peak)}${words}`;
  const value = element("span", { className: "value" });
  const caption = element("figcaption", {}, [
    element("b", { textContent: title }), value,
    element("span", { className: "told", textContent: `${told}${far}${lasting}` }),
  ]);
  const area = element("div", { className: "area", role: "img", ariaLabel: `${title} over time: ${range}, ${told}` },
    [svg, element("div", { className: "cursor" })]);
  return {
    figure: element("figure", {}, [caption, element("div", { className: "plot" }, [ticks, area])]),
    now: (time) => {
      value.textContent = say(between(course, placeOf(time))) + words;
      area.lastChild.style.left = `${100 * time / END}%`;
    },
  };
};
