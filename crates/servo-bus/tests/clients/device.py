"""Simulated STS servos of feetech-cli on a pseudo-terminal: a foreign device to test our controller's side.

Usage: device.py LINK IDS, for example: device.py /tmp/sts 1,2,3. pip install feetech-cli==0.1.8. Prints `ready`, and
serves until it is stopped."""
import os
import pty
import sys
import tty

from feetech_cli.simulator import SimulatedBus, SimulatedServo

link, ids = sys.argv[1], [int(i) for i in sys.argv[2].split(',')]
ours, theirs = pty.openpty()
tty.setraw(theirs)
if os.path.islink(link):
    os.unlink(link)
os.symlink(os.ttyname(theirs), link)
bus, heard = SimulatedBus([SimulatedServo(i) for i in ids]), b''
print('ready', flush=True)


def packet():
    """Returns the first complete packet that was received: the simulator accepts only complete packets."""
    global heard
    start = heard.find(b'\xff\xff')
    heard = heard[start:] if start >= 0 else heard[-1:]
    end = 4 + heard[3] if len(heard) >= 4 else 4
    if start < 0 or len(heard) < end:
        return None
    whole, heard = heard[:end], heard[end:]
    return whole


while True:
    heard += os.read(ours, 4096)
    while whole := packet():
        bus.write(whole)
        os.write(ours, bus.read(4096))
