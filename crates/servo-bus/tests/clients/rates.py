"""Measures the rate that ROBOTIS's dynamixel-sdk reaches with simulated XL330.

Usage: rates.py LINK IDS, for example 6 for ids 1 to 6. pip install pyserial dynamixel-sdk==4.1.0.

In each tick all servos are written (goal position) and read (current, speed, position), as in the table of
docs/buses.md; no supply is read. The servos run in real time, and their bytes take as long as on a real wire:
a busy machine makes the rate smaller, never larger. Prints a row for each rate of the bus."""
import sys
import time

import dynamixel_sdk as D

link, count = sys.argv[1], int(sys.argv[2])
# Values of Baud Rate (address 8).
BAUDS = {1_000_000: 3, 2_000_000: 4, 3_000_000: 5, 4_000_000: 6}
GOAL, STATE = (116, 4), (126, 10)
SECONDS = 2.0
port, pk = D.PortHandler(link), D.PacketHandler(2.0)
ids = range(1, count + 1)
assert port.openPort() and port.setBaudRate(1_000_000)


def wait_long(port, length):
    port.packet_start_time = port.getCurrentTime()
    port.packet_timeout = 500.0


port.setPacketTimeout = wait_long.__get__(port)
for i in ids:
    # Return delay 2 us, and answers only to reads.
    assert pk.write1ByteTxRx(port, i, 9, 1) == (0, 0)
    assert pk.write1ByteTxOnly(port, i, 68, 1) == 0
writer, reader = D.GroupSyncWrite(port, pk, *GOAL), D.GroupSyncRead(port, pk, *STATE)
for i in ids:
    assert writer.addParam(i, [0, 8, 0, 0]) and reader.addParam(i)


def rate_hz(read):
    ticks, start = 0, time.monotonic()
    while time.monotonic() - start < SECONDS:
        for i in ids:
            writer.changeParam(i, list((2048 + ticks % 100).to_bytes(4, 'little')))
        assert writer.txPacket() == 0
        assert read() == 0
        assert all(reader.isAvailable(i, *STATE) for i in ids)
        ticks += 1
    return ticks / (time.monotonic() - start)


print('| servos | Mbps | sync read, Hz | fast sync read, Hz |')
print('|---:|---:|---:|---:|')
for baud, value in BAUDS.items():
    writer_of_baud = D.GroupSyncWrite(port, pk, 8, 1)
    for i in ids:
        writer_of_baud.addParam(i, [value])
    assert writer_of_baud.txPacket() == 0
    time.sleep(0.2)
    assert port.setBaudRate(baud)
    rates = [rate_hz(read) for read in (reader.txRxPacket, reader.fastSyncRead)]
    print(f'| {count} | {baud // 1_000_000} | {rates[0]:.0f} | {rates[1]:.0f} |', flush=True)
