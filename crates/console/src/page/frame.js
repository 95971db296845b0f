// The binary frame of the hub: 24 bytes of head, numbers, then bytes; all little-endian.

const FLAGS = { jog: 1, show: 2, linkLost: 4, ghost: 8 };
const NONE = 255;
const NO_TEMPERATURE = -128;

// Returns the frame, or null for a message of another kind or length.
export const decode = (buffer) => {
  const view = new DataView(buffer);
  if (buffer.byteLength < 24 || view.getUint8(0) !== 2) return null;
  const flags = view.getUint8(3);
  const [n, d, s] = [18, 20, 22].map((at) => view.getUint16(at, true));
  const hasGhost = (flags & FLAGS.ghost) !== 0;
  if (buffer.byteLength < 24 + 4 * (n * (hasGhost ? 3 : 2) + d) + d + 6 * s) return null;
  let at = 24;
  const floats = (count) => {
    const numbers = new Float32Array(count);
    for (let i = 0; i < count; i += 1, at += 4) numbers[i] = view.getFloat32(at, true);
    return numbers;
  };
  const each = (count, size, get) => Array.from({ length: count }, () => {
    const value = get(at);
    at += size;
    return value;
  });
  const optional = (value, none) => value === none ? null : value;
  const byte = (i) => view.getUint8(i);
  return {
    state: view.getUint8(1),
    fault: optional(view.getUint8(2), NONE),
    isJog: (flags & FLAGS.jog) !== 0,
    isShow: (flags & FLAGS.show) !== 0,
    isLinkLost: (flags & FLAGS.linkLost) !== 0,
    t: view.getFloat32(4, true),
    place: view.getFloat32(8, true),
    supply: view.getFloat32(12, true),
    tick: view.getUint16(16, true),
    measured: floats(n),
    wanted: floats(n),
    ghost: hasGhost ? floats(n) : null,
    effort: floats(d),
    limit: each(d, 1, (i) => optional(byte(i), NONE)),
    celsius: each(s, 1, (i) => optional(view.getInt8(i), NO_TEMPERATURE)),
    heat: each(s, 1, byte),
    errors: each(s, 2, (i) => view.getUint16(i, true)),
    ownError: each(s, 1, byte),
    volts: each(s, 1, (i) => optional(byte(i) / 10, 0)),
  };
};
