"""Random exchanges of feetech-cli with simulated STS servos 1, 2, 3. Usage: feetech_cli_bus.py LINK COUNT.

pip install feetech-cli==0.1.8. Exits with 1 if any exchange was wrong."""
import random
import sys

import serial
from feetech_cli.protocol import PacketHandler

link, count = sys.argv[1], int(sys.argv[2])
handler = PacketHandler(serial.Serial(link, 1000000, timeout=0.2), little_endian=True)
rng, wrong, by_kind = random.Random(16), [], {}
ITEMS = [(42, 2, 4095), (44, 2, 1000), (46, 2, 30000), (48, 2, 1000), (41, 1, 254), (21, 1, 254)]


def check(name, ok, *what):
    by_kind[name] = by_kind.get(name, 0) + 1
    if not ok:
        wrong.append((name, what))


for n in range(count):
    i, (address, size, most) = rng.choice((1, 2, 3)), rng.choice(ITEMS)
    value = rng.choice([0, most, rng.randint(0, most)])
    name = rng.choice(['ping', 'write and read', 'sync'])
    if name == 'ping':
        check(name, handler.ping(i) and not handler.ping(9) if n % 20 == 0 else handler.ping(i))
    elif name == 'write and read':
        handler.write(i, address, handler.encode(size, value))
        got = handler.decode(size, handler.read(i, address, size))
        check(name, got == value, got, value)
    else:
        values = {j: (value + j) % (most + 1) for j in (1, 2, 3)}
        handler.sync_write(address, [(j, handler.encode(size, v)) for j, v in values.items()])
        answers = handler.sync_read([3, 1, 2], address, size)
        got = {j: handler.decode(size, answers[j][1]) for j in answers}
        check(name, got == values, got, values)
print(by_kind)
print('feetech-cli: %d wrong' % len(wrong), wrong[:3])
sys.exit(bool(wrong))
