"""Random exchanges of rustypot with simulated servos 1, 2, 3. Usage: rustypot_bus.py LINK COUNT dxl|sts.

pip install rustypot==1.13.1. Exits with 1 if any exchange was wrong."""
import random
import sys
import time

import rustypot

link, count, kind = sys.argv[1], int(sys.argv[2]), sys.argv[3]
bus = (rustypot.Xl330PyController if kind == 'dxl' else rustypot.Sts3215PyController)(link, 1000000, 0.5)
rng = random.Random(16)
IDS, wrong, by_kind = [1, 2, 3], [], {}
# Distance from the goal at rest, in counts: from holding a tenth of the stall torque, from friction and from play.
# XL330: 0.06 N m / 0.55 N m/rad = 71, 15 and 0. STS3215: 0.2 / 17.8 = 7, 4 and 6.
SAG = 90 if kind == 'dxl' else 20


def check(name, ok, *what):
    by_kind[name] = by_kind.get(name, 0) + 1
    if not ok:
        wrong.append((name, what))


for n in range(count):
    if kind == 'dxl':
        bus.set_fast_sync_read(n % 2 == 0)
    i, values = rng.choice(IDS), [rng.randint(0, 4095) for _ in IDS]
    name = rng.choice(['ping', 'write and read', 'sync'])
    if name == 'ping':
        check(name, bus.ping(i))
    elif name == 'write and read':
        bus.write_raw_goal_position(i, values[0])
        got = bus.read_raw_goal_position(i)
        check(name, got == [values[0]], got, values[0])
    else:
        bus.sync_write_raw_goal_position(IDS, values)
        got = bus.sync_read_raw_goal_position(IDS)
        check(name, got == values, got, values)
for n in range(4):
    values = [rng.randint(200, 3800) for _ in IDS]
    for i in IDS:
        bus.write_torque_enable(i, True)
    bus.sync_write_raw_goal_position(IDS, values)
    time.sleep(1.5)
    got = bus.sync_read_raw_present_position(IDS)
    check('move', all(abs(g - v) <= SAG for g, v in zip(got, values)), got, values)
print(by_kind)
print('rustypot %s: %d wrong' % (kind, len(wrong)), wrong[:3])
sys.exit(bool(wrong))
