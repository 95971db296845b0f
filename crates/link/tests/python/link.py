"""The host's side of the link, written from docs/link.md alone: frames, messages to a controller, messages from it.

`python3 link.py` checks the examples of that page."""
import os
import struct
import zlib

MINOR = 2
COMMANDS = ('EStop Arm Disarm Play Hold Stop Calibrate Teach Maintain Leave ClearFaults LoadShow DeleteShow SetTelemetry '
            'ReadSetting WriteSetting ReadFault AskStored BeginUpload UploadBlock EndUpload PassOn ReadPassed ReadHealth '
            'Float').split()
NUMBER = {name: number for number, name in enumerate(COMMANDS)}
STATES = ('Off Limp Calibrating Teaching Arming Holding Playing Maintenance Stopping Lowering Faulted Floating').split()
REFUSALS = ('Session Late Forgotten State NotMeasured StopUntested FeedSilent Fault StillThere NeedsUpload NoFault '
            'InMaintenance Unknown Value Capacity NoFreeSlot Offset Hash OtherRig Content Memory Unsupported Busy '
            'RegistersUnread RegisterDiffers Moving Setting NoEffort Overload Supply').split()
LIMITS = 14


def cobs(data):
    """Codes bytes so that they contain no zero."""
    out, block = bytearray(), bytearray()
    for byte in data + b'\0':
        if byte == 0:
            out += bytes([len(block) + 1]) + block
            block = bytearray()
            continue
        block.append(byte)
        if len(block) == 254:
            out += b'\xff' + block
            block = bytearray()
    return bytes(out)


def uncobs(data):
    """Decodes bytes; raises ValueError if they are damaged."""
    out, at = bytearray(), 0
    while at < len(data):
        count = data[at]
        if count == 0 or at + count > len(data):
            raise ValueError('COBS')
        out += data[at + 1:at + count]
        at += count
        if count != 255 and at < len(data):
            out.append(0)
    return bytes(out)


def frame(body):
    return b'\0' + cobs(body + struct.pack('<I', zlib.crc32(body))) + b'\0'


def unframe(coded):
    """Returns the body of what is between two zeros."""
    data = uncobs(coded)
    body, crc = data[:-4], data[-4:]
    if len(data) < 5 or struct.pack('<I', zlib.crc32(body)) != crc:
        raise ValueError('CRC')
    return body


def count(number):
    """Codes an unsigned number of more than 8 bits."""
    out = bytearray()
    while number > 0x7f:
        out.append(number & 0x7f | 0x80)
        number >>= 7
    return bytes(out) + bytes([number])


def real(number):
    return struct.pack('<f', number)


def sized(data):
    return count(len(data)) + data


def reals(numbers):
    return count(len(numbers)) + b''.join(real(number) for number in numbers)


# Values of a setting.
def flag(value):
    return b'\0' + bytes([value])


def whole(value):
    return b'\1' + count(value)


def number(value):
    return b'\2' + real(value)


def words(value):
    return b'\3' + sized(value)


def item(kind, schema, length, sha, rig, approver):
    return count(kind) + count(schema) + count(length) + sha + count(rig) + sized(approver)


def block(offset, data):
    return count(offset) + sized(data)


def pass_on(line, baud, wait_us, data):
    return bytes([line]) + count(baud) + count(wait_us) + sized(data)


def hello(nonce, major=1, minor=MINOR):
    return b'\x53\0' + bytes([major, minor]) + count(nonce)


def command(session, seq, name, fields=b''):
    return b'\x53\1' + count(session) + count(seq) + count(NUMBER[name]) + fields


def stream(session, seq, kind, fields=b''):
    """Kinds: 0 Heartbeat, 1 HoldToRun, 2 Jog, 3 Live, 4 Heard."""
    return b'\x53\2' + count(session) + count(seq) + count(kind) + fields


class Reader:
    """Reads fields of a body, one after the other; IndexError or struct.error at its end."""

    def __init__(self, body):
        self.body, self.at = body, 0

    def raw(self, length):
        data = self.body[self.at:self.at + length]
        if len(data) < length:
            raise IndexError('too short')
        self.at += length
        return data

    def byte(self):
        return self.raw(1)[0]

    def count(self):
        value, shift = 0, 0
        while True:
            byte = self.byte()
            value |= (byte & 0x7f) << shift
            shift += 7
            if byte < 0x80:
                return value

    def signed(self):
        value = self.count()
        return (value >> 1) ^ -(value & 1)

    def real(self):
        return struct.unpack('<f', self.raw(4))[0]

    def flag(self):
        value = self.byte()
        if value > 1:
            raise ValueError('bool')
        return bool(value)

    def optional(self, read):
        return read() if self.flag() else None

    def list(self, read):
        return [read() for _ in range(self.count())]

    def sized(self):
        return self.raw(self.count())

    def kind(self, *reads):
        """Reads one of several."""
        which = self.count()
        return which, reads[which]()

    def state(self):
        return STATES[self.count()]


def fault(r):
    return dict(fault=r.byte(), state=r.state(), servo=r.optional(r.count), start=r.count(), us=r.count(),
                times=r.count())


def stored(r):
    return r.count(), r.count(), r.count(), r.raw(32).hex(), r.count(), r.sized().decode()


def refusal(r):
    name = REFUSALS[r.count()]
    two = (r.count, r.count)
    fields = {'State': (r.state,), 'FeedSilent': (r.count,), 'Capacity': two, 'OtherRig': two, 'Offset': (r.count,),
              'Content': (r.count,), 'RegisterDiffers': two + (r.signed, r.signed), 'Moving': two + (r.count,),
              'Setting': (r.count, r.real, r.real, r.real), 'Overload': two + (r.count,), 'Supply': two + (r.count,)}
    if name in ('Fault', 'StillThere', 'NeedsUpload', 'InMaintenance'):
        return name, (r.byte(),)
    return name, tuple(read() for read in fields.get(name, ()))


def outcome(r):
    def done():
        return r.kind(
            lambda: None, r.state, lambda: (r.real(), r.byte()), lambda: r.kind(r.flag, r.count, r.real, r.sized),
            lambda: (r.count(), r.optional(lambda: fault(r))), lambda: r.optional(lambda: stored(r)), r.count,
            lambda: (r.count(), r.count(), r.sized()),
            lambda: (r.count(), [[r.count() for _ in range(4)] for _ in range(4)], r.real()))

    def limited():
        what, limit = done(), r.count()
        if limit >= LIMITS:
            raise ValueError('limit')
        return what, limit

    return r.kind(done, limited, lambda: refusal(r), lambda: None)


def summary(r):
    errors = r.optional  # mean and largest angle, mean and largest distance, joint
    return dict(
        state=r.state(), fault=r.optional(r.byte),
        errors=errors(lambda: (r.real(), r.real(), r.real(), r.real(), r.byte())), tick_us=r.count(),
        longest_us=r.count(), overruns=r.count(), stack=r.count(), supply_v=r.real(), damaged=r.count(),
        lost=r.count(), live_ms=r.optional(r.count), place_ms=r.count())


def part(r):
    return r.kind(
        lambda: summary(r), lambda: (r.byte(), r.list(r.real)),
        lambda: (r.byte(), r.list(lambda: (r.real(), r.optional(r.count)))),
        lambda: (r.byte(), r.list(lambda: (r.optional(r.byte), r.byte(), r.count(), r.byte()))),
        lambda: (r.byte(), r.list(r.signed)),
        lambda: (r.byte(), r.list(r.byte)))


def decode(body):
    """Returns the name and the fields of a message to the host; raises if anything is not as the page says."""
    r = Reader(body)
    if r.byte() != 0x48:
        raise ValueError('direction')

    def welcome():
        return dict(nonce=r.count(), session=r.count(), major=r.byte(), minor=r.byte(),
                    firmware=(r.byte(), r.byte(), r.byte()), rig=r.count(),
                    capacities=[r.count(), r.count(), r.count(), r.count(), r.byte(), r.count()],
                    verdict=r.kind(r.byte, lambda: r.kind(lambda: r.raw(4), lambda: b'')))

    names = 'Welcome', 'Answer', 'Telemetry', 'Fault'
    which, fields = r.kind(
        welcome, lambda: dict(session=r.count(), number=r.count(), outcome=outcome(r)),
        lambda: dict(number=r.count(), tick=r.count(), part=part(r)), lambda: fault(r))
    if r.at != len(body):
        raise ValueError('%d bytes too many' % (len(body) - r.at))
    return names[which], fields


class Port:
    """A serial port in raw mode. Its rate is left as it is."""

    def __init__(self, path):
        import tty
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self.fd)
        self.came, self.undecoded = bytearray(), []

    def write(self, data):
        """Returns the number of bytes for which there was room."""
        try:
            return os.write(self.fd, data)
        except BlockingIOError:
            return 0

    def read(self):
        """Returns the messages that have come. Keeps the frames that cannot be decoded."""
        try:
            self.came += os.read(self.fd, 65536)
        except BlockingIOError:
            pass
        *frames, self.came = self.came.split(b'\0')
        messages = []
        for coded in filter(None, frames):
            try:
                messages.append(decode(unframe(coded)))
            except (ValueError, IndexError, struct.error) as why:
                self.undecoded.append((bytes(coded).hex(), repr(why)))
        return messages


def check_examples():
    """Compares frames with the examples of the page, both ways. Returns their number."""
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, '../../../../docs/link.md')) as page:
        lines = page.read().splitlines()
    examples = []
    for line in lines:
        name, _, data = line.strip().partition('  ')
        if name in ('body', 'wire'):
            examples.append(bytes.fromhex(data))
    ours = [
        hello(0x12345678, minor=0), command(1, 0, 'Arm'), command(1, 1, 'Play', count(1)), stream(1, 300, 0),
        stream(1, 300, 4, count(41)), stream(1, 301, 3, count(1500000) + reals([0, 0.5])),
        stream(1, 302, 2, b'\3' + real(0.5)), command(1, 3, 'EStop')]
    pairs = list(zip(examples[::2], examples[1::2]))
    for body, wire in pairs:
        assert frame(body) == wire and unframe(wire.strip(b'\0')) == body, wire.hex(' ')
    for body, (example, _) in zip(ours, pairs):
        assert body == example, (body.hex(' '), example.hex(' '))
    for body, _ in pairs[len(ours):]:
        decode(body)
    return len(pairs)


if __name__ == '__main__':
    print('%d examples are as on the page' % check_examples())
