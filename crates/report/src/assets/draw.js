// ---- Elements, numbers and lines of plots ----
const element = (tag, properties = {}, children = []) => {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
};
const drawn = (tag, attributes) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
};
const number = (signed, decimals) => {
  const size = Math.abs(signed);
  const text = signed.toFixed(decimals ?? (size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.9995 ? 2 : 3));
  // Avoids a negative zero.
  return Number(text) === 0 ? "0" : text.replace("-", "−");
};

// Returns the path of a whole trace, with no more points than a screen shows: the minimum and the maximum of each part.
// Unknown values are gaps.
const WIDTH = 1000;
const outline = (course, x, y) => {
  const step = Math.max(Math.ceil(course.length / (WIDTH / 2)), 1);
  let path = "", pen = "M";
  for (let at = 0; at < course.length; at += step) {
    const part = course.subarray(at, at + step).filter(Number.isFinite);
    if (part.length === 0) { pen = "M"; continue; }
    const [least, most] = [Math.min(...part), Math.max(...part)];
    const ends = step === 1 ? [least] : part.indexOf(least) < part.indexOf(most) ? [least, most] : [most, least];
    ends.forEach((value, i) => {
      path += `${pen}${x(at + i * step / 2).toFixed(1)} ${y(value).toFixed(2)}`;
      pen = "L";
    });
  }
  return path;
};
