"""Random exchanges of a Feetech SDK with simulated servos 1, 2, 3. Usage: feetech.py LINK COUNT sts|scs.

feetech-servo-sdk, ftservo-python-sdk and vassar-feetech-servo-sdk share the module scservo_sdk: install each with
pip install --no-deps --target DIR NAME, and select one by PYTHONPATH. Exits with 1 if any exchange was wrong."""
import random
import sys

import scservo_sdk as S

link, count, kind = sys.argv[1], int(sys.argv[2]), sys.argv[3]
port = S.PortHandler(link)
assert port.openPort() and port.setBaudRate(1000000)


def patient(port, length):
    """Waits half a second for an answer, because this machine may be busy. A silent servo still counts as wrong."""
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


port.setPacketTimeout = patient.__get__(port)
old = not hasattr(S, 'sms_sts')
sts = kind == 'sts'
pk = S.PacketHandler(0 if sts else 1) if old else S.sms_sts(port) if sts else S.scscl(port)
first = (port,) if old else ()
rng = random.Random(16)
IDS = (1, 2, 3)
ITEMS = [(42, 2, 0, 1023), (44, 2, 0, 1000), (46, 2, 0, 30000), (41, 1, 0, 254), (40, 1, 0, 1)]
ITEMS += [(48, 2, 0, 1000)] if sts else []
number = 777 if sts else 1284
wrong, by_kind = [], {}


def check(name, ok, *what):
    by_kind[name] = by_kind.get(name, 0) + 1
    if not ok:
        wrong.append((name, what))


def call(name, *arguments):
    return getattr(pk, name)(*first, *arguments)


def data(value, size):
    order = 'little' if sts else 'big'
    return list(value.to_bytes(size, order))


for n in range(count):
    i, (address, size, least, most) = rng.choice(IDS), rng.choice(ITEMS)
    value = rng.choice([least, most, rng.randint(least, most)])
    kinds = ['ping', 'write and read', 'reg write and action', 'sync write'] + (['sync'] if sts else [])
    name = rng.choice(kinds)
    if name == 'ping':
        got = call('ping', i)
        check(name, got == (number, 0, 0), got)
    elif name == 'write and read':
        got = call('write%dByteTxRx' % size, i, address, value), call('read%dByteTxRx' % size, i, address)
        check(name, got == ((0, 0), (value, 0, 0)), i, address, value, got)
    elif name == 'reg write and action':
        got = call('regWriteTxRx', i, address, size, data(value, size))
        call('action', S.BROADCAST_ID)
        got += call('read%dByteTxRx' % size, i, address)
        check(name, got == (0, 0, value, 0, 0), got)
    else:
        writer = S.GroupSyncWrite(*first, pk, address, size)
        for j in IDS:
            writer.addParam(j, data(value, size))
        got = [writer.txPacket()]
        if name == 'sync':
            reader = S.GroupSyncRead(*first, pk, address, size)
            for j in rng.sample(IDS, 3):
                reader.addParam(j)
            got += [reader.txRxPacket()] + [reader.getData(j, address, size) for j in IDS]
            check(name, got == [0, 0, value, value, value], got)
        else:
            got += [call('read%dByteTxRx' % size, j, address) for j in IDS]
            check(name, got == [0] + [(value, 0, 0)] * 3, got)
print(by_kind)
print('%s %s: %d wrong' % (S.__file__.split('/')[-3], kind, len(wrong)), wrong[:3])
sys.exit(bool(wrong))
