"""A second reader of shows, written from docs/show-format.md alone.

    python3 decode.py FILE.show SAMPLE...

prints q, qd and qdd at each of these samples (fractions allowed), one line each.
"""

import sys
import zlib
from struct import unpack_from

CHANNELS = {0: 0, 1: 1, 2: 1, 3: 2, 4: 4, 5: 7}


def span(rung):
    return 1 if rung == 0 else (2 + (rung - 1) % 2) * 2 ** ((rung - 1) // 2)


def unmapped(u):
    return -(u + 1) // 2 if u % 2 else u // 2


class Bits:
    def __init__(self, data):
        self.text = "".join(f"{byte:08b}" for byte in data)
        self.at = 0

    def number(self, width):
        text = self.text[self.at : self.at + width]
        self.at += width
        return int(text, 2) if width else 0

    def ones(self, most):
        count = 0
        while count < most:
            if self.number(1) == 0:
                return count
            count += 1
        return most

    def gamma(self):
        zeros = 0
        while self.text[self.at + zeros] == "0":
            zeros += 1
        self.at += zeros
        return self.number(zeros + 1)


class Show:
    def __init__(self, data):
        assert data[:4] == b"SNWS" and unpack_from("<H", data, 4)[0] == 2
        self.flags, self.total, self.head = unpack_from("<HII", data, 6)
        self.rig, samples, seconds, self.length = unpack_from("<IIII", data, 16)
        self.rate = samples / seconds
        self.block, joints, channels, cues, cues_len = unpack_from("<HHHHH", data, 32)
        assert len(data) == self.total
        assert zlib.crc32(data[: self.head]) == unpack_from("<I", data, self.head)[0]
        at = 56
        self.joints = list(data[at : at + joints])
        at += joints
        assert sum(CHANNELS[kind] for kind in self.joints) == channels
        self.records = [unpack_from("<fiiBBBB", data, at + 16 * k) for k in range(channels)]
        at += 16 * channels
        self.cues = []
        end = at + cues_len
        while at < end:
            sample, size = unpack_from("<IB", data, at)
            self.cues.append((sample, data[at + 5 : at + 5 + size].decode()))
            at += 5 + size
        assert len(self.cues) == cues
        count = -(-self.length // self.block)
        starts = [*unpack_from(f"<{count}I", data, at), self.total]
        assert at + 4 * count == self.head and starts[0] == self.head + 4
        self.knots = [[] for _ in range(channels)]
        for k in range(count):
            content = data[starts[k] + 4 : starts[k + 1]]
            assert zlib.crc32(content) == unpack_from("<I", data, starts[k])[0]
            bits = Bits(content)
            width = bits.number(5)
            sizes = [bits.number(width) for _ in range(channels)]
            for channel, size in enumerate(sizes):
                end = bits.at + size
                self.knots[channel] += self.read(bits, end, self.records[channel], k * self.block)
                assert bits.at == end
        if self.flags & 1:
            for channel, record in enumerate(self.records):
                sign = -1 if record[5] else 1
                first = self.knots[channel][:6]
                self.knots[channel] += [(t + self.length, sign * c) for t, c in first]

    @staticmethod
    def read(bits, end, record, start):
        _, least, most, mean, trend, _, _ = record
        width = (most - least).bit_length()
        knot = start - bits.gamma()
        last = before = least + bits.number(width)
        rung = bits.number(5)
        mean *= 16
        knots = [(knot, last)]
        while bits.at < end:
            change = bits.ones(10)
            rung = bits.number(5) if change == 10 else rung + unmapped(change)
            knot += span(rung)
            expected = last + ((last - before) * trend) // 16
            low = (mean // 32).bit_length()
            high = bits.ones(16)
            if high == 16:
                control = least + bits.number(width)
                more = control - expected
                u = 2 * more if more >= 0 else -2 * more - 1
            else:
                u = (high << low) | bits.number(low)
                control = min(max(expected + unmapped(u), least), most)
            mean += 4 * u - mean // 4
            before, last = last, control
            knots.append((knot, control))
        return knots

    def channel(self, index, at):
        knots = self.knots[index]
        i = max(k for k, (t, _) in enumerate(knots[:-3]) if t <= at)
        t = {k: knots[i + k][0] for k in range(-2, 4)}
        c = {k: knots[i + k][1] for k in range(-1, 3)}
        s = {k: 3 * (c[k] - c[k - 1]) / (t[k + 1] - t[k - 2]) for k in (0, 1, 2)}
        a = {k: 2 * (s[k + 1] - s[k]) / (t[k + 1] - t[k - 1]) for k in (0, 1)}
        b, h, u = t[0] - t[-1], t[1] - t[0], at - t[0]
        v = (s[0] * h + s[1] * b) / (h + b)
        x = c[0] - v * (h - b) / 3 + a[0] * b * h / 6
        jerk = (a[1] - a[0]) / h
        step = self.records[index][0]
        return (
            step * (x + v * u + a[0] * u**2 / 2 + jerk * u**3 / 6),
            step * (v + a[0] * u + jerk * u**2 / 2) * self.rate,
            step * (a[0] + jerk * u) * self.rate**2,
        )

    def state(self, at):
        at = at % self.length if self.flags & 1 else min(at, self.length)
        q, qd, qdd = [], [], []
        first = 0
        for kind in self.joints:
            jets = [self.channel(first + k, at) for k in range(CHANNELS[kind])]
            first += CHANNELS[kind]
            if kind in (4, 5):
                p, p1, p2 = zip(*jets[:4])
                squared = sum(x * x for x in p)
                unit = [x / squared**0.5 for x in p]
                w = [2 * x / squared for x in times(conjugate(p), p1)[:3]]
                along = 2 * sum(x * y for x, y in zip(p, p1)) / squared
                q += unit
                qd += w
                turn = times(conjugate(p), p2)[:3]
                qdd += [2 * x / squared - along * y for x, y in zip(turn, w)]
                if kind == 5:
                    x, v, a = zip(*jets[4:])
                    q += x
                    qd += turned(conjugate(unit), v)
                    qdd += turned(conjugate(unit), a)
            else:
                q += [jet[0] for jet in jets]
                qd += [jet[1] for jet in jets]
                qdd += [jet[2] for jet in jets]
        return q, qd, qdd


def conjugate(q):
    x, y, z, w = q
    return [-x, -y, -z, w]


def times(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]


def turned(q, v):
    return times(times(q, [*v, 0]), conjugate(q))[:3]


if __name__ == "__main__":
    with open(sys.argv[1], "rb") as file:
        show = Show(file.read())
    for sample in sys.argv[2:]:
        print(*(x for part in show.state(float(sample)) for x in part))
