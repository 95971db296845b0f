"""Checks the errors that ROBOTIS's dynamixel-sdk reports for a servo that is too hot.

Usage: dynamixel_errors.py LINK COUNT, with
sinew servo simulate --kind xl330 --ids 11,12 --fault 12:hot=90.

Servo 12 has switched itself off: each of its answers has the alert bit, and an error number if an instruction fails.
Hardware Error Status (70) contains the cause. Servo 11 reports no error. Exits with 1 if any exchange was wrong."""
import random
import sys
import time

import dynamixel_sdk as D

link, count = sys.argv[1], int(sys.argv[2])
port, pk = D.PortHandler(link), D.PacketHandler(2.0)
assert port.openPort() and port.setBaudRate(1000000)


def patient(port, length):
    """Waits half a second for an answer, because this machine may be busy. A silent servo still counts as wrong."""
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


port.setPacketTimeout = patient.__get__(port)
rng, wrong = random.Random(16), []
OVERHEATING, DATA_LIMIT = 1 << 2, 6
# Wait until the servo has read its sensor once.
assert any(pk.read1ByteTxRx(port, 12, 70)[0] == OVERHEATING for n in range(1000))
# Torque is on for both servos, until servo 12 detects that it is too hot.
assert pk.write1ByteTxRx(port, 11, 64, 1) == (0, 0)
pk.write1ByteTxRx(port, 12, 64, 1)
for n in range(count):
    i = rng.choice((11, 12))
    alert, why = (D.ERRBIT_ALERT, OVERHEATING) if i == 12 else (0, 0)
    name, got, expected = rng.choice([
        ('ping', lambda: pk.ping(port, i), (1200, 0, alert)),
        ('why', lambda: pk.read1ByteTxRx(port, i, 70), (why, 0, alert)),
        ('led', lambda: pk.write1ByteTxRx(port, i, 65, n % 2), (0, alert)),
        ('refused', lambda: pk.write4ByteTxRx(port, i, 116, 5000), (0, alert | DATA_LIMIT)),
    ])
    answer = got()
    told = pk.getRxPacketError(answer[-1])
    if answer != expected or ('Hardware error' in told) != (i == 12):
        wrong.append((i, name, answer, expected, told))
time.sleep(0.05)
torque = [pk.read1ByteTxRx(port, i, 64) for i in (11, 12)]
if torque != [(1, 0, 0), (0, 0, D.ERRBIT_ALERT)]:
    wrong.append(('torque', torque))
print('dynamixel-sdk, a servo too hot: %d wrong of %d' % (len(wrong), count), wrong[:3])
sys.exit(bool(wrong))
