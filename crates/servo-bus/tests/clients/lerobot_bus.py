"""Random exchanges of LeRobot's motor buses with simulated servos 1, 2, 3.

Usage: lerobot_bus.py LINK COUNT dxl|sts DIR. DIR: pip download --no-deps lerobot==0.4.4, unzipped, so that torch
is not needed. Needs numpy, deepdiff, tqdm, pyserial, and dynamixel-sdk or feetech-servo-sdk.
Exits with 1 if any exchange was wrong."""
import random
import sys
import time
import types

link, count, kind, where = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4]
sys.path.insert(0, where)


def stub(name, **what):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__dict__.update(what)


stub('torch', device=object, dtype=object, Tensor=object, float32=0)
stub('accelerate', Accelerator=object)
stub('datasets')
stub('datasets.utils')
stub('datasets.utils.logging', disable_progress_bar=None, enable_progress_bar=None)
from lerobot.motors import Motor, MotorNormMode  # noqa: E402

if kind == 'dxl':
    from lerobot.motors.dynamixel import DynamixelMotorsBus as Bus
    model, number = 'xl330-m288', 1200
else:
    from lerobot.motors.feetech import FeetechMotorsBus as Bus
    model, number = 'sts3215', 777
bus = Bus(link, {'j%d' % i: Motor(i, model, MotorNormMode.DEGREES) for i in (1, 2, 3)})


def patient(port, length):
    """Waits half a second for an answer, because this machine may be busy. A silent servo still counts as wrong."""
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


bus.port_handler.setPacketTimeout = patient.__get__(bus.port_handler)
bus.connect(handshake=True)
rng, wrong = random.Random(16), []
# Distance from the goal at rest, in counts: from holding a tenth of the stall torque, from friction and from play.
# XL330: 0.06 N m / 0.55 N m/rad = 71, 15 and 0. STS3215: 0.2 / 17.8 = 7, 4 and 6.
SAG = 90 if kind == 'dxl' else 20


def check(name, ok, *what):
    if not ok:
        wrong.append((name, what))


found = bus.broadcast_ping()
check('broadcast ping', all(found.get(i) == number for i in (1, 2, 3)), found)
for n in range(count):
    joint, goals = rng.choice(list(bus.motors)), {j: rng.randint(0, 4095) for j in bus.motors}
    name = rng.choice(['ping', 'sync', 'offset'])
    if name == 'ping':
        check(name, bus.ping(joint) == number)
    elif name == 'sync':
        bus.sync_write('Goal_Position', goals, normalize=False)
        got = bus.sync_read('Goal_Position', normalize=False)
        check(name, got == goals, got, goals)
    else:
        bus.disable_torque(joint)
        offset = rng.randint(-2000, 2000)
        bus.write('Homing_Offset', joint, offset, normalize=False)
        got = bus.read('Homing_Offset', joint, normalize=False)
        check(name, got == offset, got, offset)
bus.disable_torque()
for joint in bus.motors:
    bus.write('Homing_Offset', joint, 0, normalize=False)
bus.enable_torque()
for n in range(4):
    goals = {j: rng.randint(200, 3800) for j in bus.motors}
    bus.sync_write('Goal_Position', goals, normalize=False)
    time.sleep(1.5)
    got = bus.sync_read('Present_Position', normalize=False)
    check('move', all(abs(got[j] - goals[j]) <= SAG for j in goals), got, goals)
bus.disconnect(disable_torque=True)
print('lerobot %s: %d wrong of %d' % (kind, len(wrong), count), wrong[:3])
sys.exit(bool(wrong))
