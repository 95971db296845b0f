"""Random exchanges of ROBOTIS's dynamixel-sdk with simulated servos 11, 12, 13. Usage: dynamixel.py LINK COUNT.

pip install pyserial dynamixel-sdk==4.1.0. Prints how many exchanges were wrong, and exits with 1 if any was.

The ids differ from all bytes of addresses and lengths in this test: fastBulkRead of this SDK searches for an id in all
bytes of its question. If another byte is equal, it uses the length of a wrong servo, or reads past the end."""
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
rng = random.Random(16)
IDS = (11, 12, 13)
# Address, size, minimum, maximum of registers that may be written while torque is off, independently of each other.
ITEMS = [(65, 1, 0, 1), (84, 2, 0, 16383), (80, 2, 0, 16383), (100, 2, -885, 885), (102, 2, -1750, 1750),
         (104, 4, -445, 445), (108, 4, 0, 32767), (112, 4, 0, 32767), (116, 4, 0, 4095)]
model = {i: {} for i in IDS}
wrong, by_kind = [], {}


def check(kind, ok, *what):
    by_kind[kind] = by_kind.get(kind, 0) + 1
    if not ok:
        wrong.append((kind, what))


def raw(value, size):
    return value & ((1 << 8 * size) - 1)


def data(value, size):
    return list(raw(value, size).to_bytes(size, 'little'))


def write(i, address, size, value):
    result, error = getattr(pk, 'write%dByteTxRx' % size)(port, i, address, raw(value, size))
    return result, error


def read(i, address, size):
    return getattr(pk, 'read%dByteTxRx' % size)(port, i, address)


def pick():
    address, size, least, most = rng.choice(ITEMS)
    return address, size, rng.choice([least, most, -1 if least < 0 else 0, rng.randint(least, most)])


def one(kind):
    i = rng.choice(IDS)
    address, size, value = pick()
    if kind == 'ping':
        got = pk.ping(port, i)
        check(kind, got == (1200, 0, 0), got)
    elif kind == 'write and read':
        got = write(i, address, size, value), read(i, address, size)
        model[i][address] = value
        check(kind, got == ((0, 0), (raw(value, size), 0, 0)), i, address, value, got)
    elif kind == 'refused':
        got = write(i, 116, 4, rng.randint(4096, 1 << 30)), write(i, 132, 4, 0), write(i, 64, 1, 2), write(i, 66, 1, 0)
        check(kind, got == ((0, 6), (0, 7), (0, 4), (0, 7)), got)
    elif kind in ('sync', 'fast sync'):
        writer = D.GroupSyncWrite(port, pk, address, size)
        for n, j in enumerate(IDS):
            model[j][address] = value - n if value > 2 else value
            writer.addParam(j, data(model[j][address], size))
        reader = D.GroupSyncRead(port, pk, address, size)
        for j in rng.sample(IDS, 3):
            reader.addParam(j)
        got = writer.txPacket(), reader.txRxPacket() if kind == 'sync' else reader.fastSyncRead()
        values = [reader.getData(j, address, size) for j in IDS]
        check(kind, got == (0, 0) and values == [raw(model[j][address], size) for j in IDS], got, values)
    elif kind in ('bulk', 'fast bulk'):
        writer, reader, picks = D.GroupBulkWrite(port, pk), D.GroupBulkRead(port, pk), {}
        for j in rng.sample(IDS, 3):
            picks[j] = pick()
            model[j][picks[j][0]] = picks[j][2]
            writer.addParam(j, picks[j][0], picks[j][1], data(picks[j][2], picks[j][1]))
            reader.addParam(j, picks[j][0], picks[j][1])
        got = writer.txPacket(), reader.txRxPacket() if kind == 'bulk' else reader.fastBulkRead()
        ok = all(reader.getData(j, a, s) == raw(v, s) for j, (a, s, v) in picks.items())
        check(kind, got == (0, 0) and ok, got, picks)
    elif kind == 'reg write and action':
        got = pk.regWriteTxRx(port, i, address, size, data(value, size)), pk.action(port, D.BROADCAST_ID)
        model[i][address] = value
        got += (read(i, address, size),)
        check(kind, got == ((0, 0), 0, (raw(value, size), 0, 0)), got)
    elif kind == 'stuffing':
        # Goal PWM -1, then a current that begins with FD: FF FF FD. The SDK does not stuff its packets.
        low = rng.randrange(6)
        got = pk.writeTxRx(port, i, 100, 4, [0xFF, 0xFF, 0xFD, low]), pk.readTxRx(port, i, 100, 4)
        model[i].update({100: -1, 102: 0xFD | low << 8})
        read_data, result, error = got[1]
        check(kind, got[0] == (0, 0) and (list(read_data), result, error) == ([255, 255, 253, low], 0, 0), got)
    elif kind == 'not stuffed':
        # FF FF FD FD: the servo takes the last FD for stuffing, finds 3 bytes, and refuses. Nothing is written.
        got = pk.writeTxRx(port, i, 100, 4, [0xFF, 0xFF, 0xFD, 0xFD])
        check(kind, got == (0, 5), got)
    elif kind == 'reboot':
        got = pk.reboot(port, i),
        # The servo needs a moment to start.
        time.sleep(0.4)
        got += (read(i, 64, 1),)
        model[i].clear()
        check(kind, got == ((0, 0), (0, 0, 0)), got)
    elif kind == 'still there':
        for a, v in model[i].items():
            s = next(s for x, s, _, _ in ITEMS if x == a)
            got = read(i, a, s)
            check(kind, got == (raw(v, s), 0, 0), i, a, v, got)


found, result = pk.broadcastPing(port)
check('broadcast ping', result == 0 and all(found.get(i) == [1200, 52] for i in IDS), found, result)
KINDS = ['ping', 'write and read', 'refused', 'sync', 'fast sync', 'bulk', 'fast bulk', 'reg write and action',
         'stuffing', 'not stuffed', 'still there']
for n in range(count):
    one('reboot' if n % 100 == 99 else rng.choice(KINDS))
print(by_kind)
print('dynamixel-sdk: %d wrong' % len(wrong), wrong[:3])
sys.exit(bool(wrong))
