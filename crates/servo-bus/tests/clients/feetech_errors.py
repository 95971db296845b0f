"""Checks the errors that a Feetech SDK reports for an STS3215 that is too hot.

Usage: feetech_errors.py LINK COUNT, with
sinew servo simulate --kind sts3215 --ids 1,2 --fault 2:hot=90.

Servo 2 has switched itself off: each of its answers has the temperature bit. Servo 1 reports no error.
PYTHONPATH selects the SDK, as for feetech.py. Exits with 1 if any exchange was wrong."""
import random
import sys
import time

import scservo_sdk as S

link, count = sys.argv[1], int(sys.argv[2])
port = S.PortHandler(link)
assert port.openPort() and port.setBaudRate(1000000)


def patient(port, length):
    """Waits half a second for an answer, because this machine may be busy. A silent servo still counts as wrong."""
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


port.setPacketTimeout = patient.__get__(port)
old = not hasattr(S, 'sms_sts')
pk, first = (S.PacketHandler(0), (port,)) if old else (S.sms_sts(port), ())
rng, wrong = random.Random(16), []
TOO_HOT = 1 << 2
# Wait until the servo has read its sensor once.
assert any(pk.read1ByteTxRx(*first, 2, 65)[0] == TOO_HOT for n in range(1000))
for i in (1, 2):
    pk.write1ByteTxRx(*first, i, 40, 1)
for n in range(count):
    i = rng.choice((1, 2))
    error = TOO_HOT if i == 2 else 0
    name, got, expected = rng.choice([
        ('ping', lambda: pk.ping(*first, i), (777, 0, error)),
        ('status', lambda: pk.read1ByteTxRx(*first, i, 65), (error, 0, error)),
        ('goal', lambda: pk.write2ByteTxRx(*first, i, 42, n % 4096), (0, error)),
    ])
    answer = got()
    told = pk.getRxPacketError(answer[-1])
    if answer != expected or ('heat' in told.lower()) != (i == 2):
        wrong.append((i, name, answer, expected, told))
# A goal switches torque on, until the servo detects that it is too hot.
time.sleep(0.05)
torque = [pk.read1ByteTxRx(*first, i, 40) for i in (1, 2)]
if torque != [(1, 0, 0), (0, 0, TOO_HOT)]:
    wrong.append(('torque', torque))
print('%s, a servo too hot: %d wrong of %d' % (S.__file__.split('/')[-3], len(wrong), count), wrong[:3])
sys.exit(bool(wrong))
