// The frames of the last minute, as rows of numbers in a ring.

const KEPT_MS = 60000;
const ROWS = 2000;

export const history = (head) => {
  const [d, s] = [head.dofs.length, head.servos.length];
  const offsets = {
    measured: 0, wanted: d, effort: 2 * d, celsius: 3 * d, heat: 3 * d + s, errors: 3 * d + 2 * s, volts: 3 * d + 3 * s,
    supply: 3 * d + 4 * s, tick: 3 * d + 4 * s + 1,
  };
  const width = 3 * d + 4 * s + 2;
  const numbers = new Float32Array(ROWS * width);
  const times = new Float64Array(ROWS);
  let next = 0, count = 0;

  return {
    take: (frame, now) => {
      const at = next * width;
      head.dofs.forEach(({ coordinate }, index) => {
        numbers[at + offsets.measured + index] = coordinate === null ? NaN : frame.measured[coordinate];
        numbers[at + offsets.wanted + index] = coordinate === null ? NaN : frame.wanted[coordinate];
      });
      numbers.set(frame.effort.subarray(0, d), at + offsets.effort);
      for (let index = 0; index < s; index += 1) {
        numbers[at + offsets.celsius + index] = frame.celsius[index] ?? NaN;
        numbers[at + offsets.heat + index] = frame.heat[index];
        numbers[at + offsets.errors + index] = frame.errors[index];
        numbers[at + offsets.volts + index] = frame.volts[index] ?? NaN;
      }
      numbers[at + offsets.supply] = frame.supply > 0 ? frame.supply : NaN;
      numbers[at + offsets.tick] = frame.tick;
      times[next] = now;
      next = (next + 1) % ROWS;
      count = Math.min(count + 1, ROWS);
    },
    // Calls `visit` with the age, ms, and the number of each frame of the last minute, oldest first.
    each: (kind, index, now, visit) => {
      for (let i = count; i > 0; i -= 1) {
        const row = (next - i + ROWS) % ROWS;
        const age = now - times[row];
        if (age <= KEPT_MS) visit(age, numbers[row * width + offsets[kind] + index]);
      }
    },
  };
};

export const MINUTE_MS = KEPT_MS;
