"""LeRobot's calibration of an SO-101 on simulated servos 1 to 6, and its file through the rig file and back.

Usage: lerobot_calibration.py LINK SINEW DIR. DIR: as for lerobot_bus.py. The steps are those of lerobot-calibrate
(robots/so101_follower): torque off, position mode, half-turn homings, ranges, file. A goal moves each joint in place of
a hand. Exits with 1 if the file does not come out the same, or the registers differ from it."""
import json
import subprocess
import sys
import tempfile
import time
import types

link, sinew, where = sys.argv[1:4]
sys.path.insert(0, where)


def stub(name, **what):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__dict__.update(what)


stub('torch', device=object, dtype=object, Tensor=object, float32=0)
stub('accelerate', Accelerator=object)
stub('datasets')
stub('datasets.utils')
stub('datasets.utils.logging', disable_progress_bar=None, enable_progress_bar=None)
from lerobot.motors import Motor, MotorCalibration, MotorNormMode  # noqa: E402
from lerobot.motors.feetech import FeetechMotorsBus, OperatingMode  # noqa: E402

NAMES = ['shoulder_pan', 'shoulder_lift', 'elbow_flex', 'wrist_flex', 'wrist_roll', 'gripper']
bus = FeetechMotorsBus(link, {n: Motor(i + 1, 'sts3215', MotorNormMode.DEGREES) for i, n in enumerate(NAMES)})
bus.connect(handshake=True)


def patient(port, length):
    """Waits half a second for an answer, because this machine may be busy."""
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


bus.port_handler.setPacketTimeout = patient.__get__(bus.port_handler)


def places():
    return bus.sync_read('Present_Position', normalize=False)


def at_rest():
    """Waits until no joint has moved for 0.2 s, and returns the positions."""
    before, now = None, places()
    while now != before:
        time.sleep(0.2)
        before, now = now, places()
    return now


def go(place):
    """Moves each joint to its own place near another one, lets go of it, and waits until it rests."""
    goals = {n: place + 10 * i for i, n in enumerate(NAMES)}
    bus.sync_write('Goal_Position', goals, normalize=False)
    at_rest()
    bus.disable_torque()
    return at_rest()


bus.disable_torque()
for name in NAMES:
    bus.write('Operating_Mode', name, OperatingMode.POSITION.value)
go(1500)
homings = bus.set_half_turn_homings()
# A servo takes its offset in its next tick.
time.sleep(0.05)
middle = places()
least, most = go(1000), go(3000)
calibration = {
    n: MotorCalibration(i + 1, 0, homings[n], *((0, 4095) if n == 'wrist_roll' else (least[n], most[n])))
    for i, n in enumerate(NAMES)
}
bus.write_calibration(calibration)
wrong = []
if not bus.is_calibrated:
    wrong.append(('is_calibrated', bus.read_calibration()))
# A joint that rests keeps its count, so each middle is exact. A joint that falls does not rest: the servos' default load
# accelerates by 1500 counts/s2 at this place (gravity less friction, over inertia).
if any(place != 2047 for place in middle.values()):
    wrong.append(('middle', middle))
bus.disconnect(disable_torque=False)

with tempfile.TemporaryDirectory() as folder:
    theirs, ours, rig = (f'{folder}/{name}' for name in ('theirs.json', 'ours.json', 'rig.toml'))
    text = json.dumps({n: vars(c) for n, c in calibration.items()}, indent=4)
    with open(theirs, 'w') as file:
        file.write(text)
    with open(rig, 'w') as file:
        file.write('name = "so101"\n[[body]]\nname = "base"\n')
        for i, name in enumerate(NAMES):
            file.write(f'[[body]]\nname = "{name}"\n[[joint]]\nname = "{name}"\n'
                       f'parent = "{NAMES[i - 1] if i else "base"}"\nchild = "{name}"\naxis = [0, 1, 0]\n'
                       f'[[drive]]\njoints = ["{name}"]\nservos = ["{name}"]\n'
                       f'[[servo]]\nname = "{name}"\nmodel = "STS3215-7.4V"\nid = {i + 1}\n')
    for option, path in (('--from', theirs), ('--to', ours)):
        subprocess.run([sinew, 'servo', 'lerobot', '--rig', rig, option, path], check=True)
    with open(ours) as file:
        if file.read() != text:
            wrong.append(('file', text))
    command = [sinew, 'servo', '--port', link, 'diff', '--rig', rig, '--format', 'json']
    compared = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=False).stdout)
    of_calibration = {'Homing Offset', 'Min Position Limit', 'Max Position Limit', 'Phase'}
    for servo in compared['servos']:
        names = {difference['name'] for difference in servo['differences']}
        if servo['error'] or names & of_calibration:
            wrong.append((servo['name'], servo['error'], names))
print('lerobot calibration: %d wrong' % len(wrong), wrong[:3])
sys.exit(bool(wrong))
