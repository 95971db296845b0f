"""Compares our control tables with the machine-readable tables inside ROBOTIS's dynamixel-sdk (Apache-2.0).

Usage: cargo run -p sinew-servo-bus --example tables | tables.py. pip install dynamixel-sdk==4.1.0. These files contain
address, size and name of each register, but not whether it can be written. Exits with 1 if anything differs that is
not in KNOWN."""
import pathlib
import re
import sys

import dynamixel_easy_sdk

# Registers that only our tables have, by name, with the reason. They apply to all models that have the register.
KNOWN = {
    'Startup Configuration': 'the e-manual has it (address 60), their files leave it out',
    'Backup Ready': 'the e-manual has it (address 147), their files leave it out',
}
folder = pathlib.Path(dynamixel_easy_sdk.__file__).parent / 'control_table'
files = {}
for line in (folder / 'dynamixel.model').read_text().splitlines()[1:]:
    number, name = line.split('\t')[:2]
    files[int(number)] = name


def plain(name):
    return re.sub('[^a-z0-9]', '', name.lower()).removesuffix('1') if 'Indirect' in name else name.lower()


def theirs(number, firmware):
    """Returns address and size of each register of a model, by name, without the library's own shortcuts."""
    name = files[number]
    moved = name.replace('.model', '_fw52.model')
    if firmware >= 52 and (folder / moved).exists():
        name = moved
    text = (folder / name).read_text().split('[control table]')[1]
    rows = [line.split('\t') for line in text.splitlines() if line.count('\t') >= 2 and line[0].isdigit()]
    return {plain(row[2]): (int(row[0]), int(row[1])) for row in rows
            if not re.match('Indirect .* (Read|Write)$', row[2])}


ours = {}
for line in sys.stdin:
    number, firmware, address, size, access, name = line.rstrip('\n').split('\t')
    # Their tables name only the first of several runs of indirect registers.
    items = ours.setdefault((int(number), int(firmware)), {})
    items.setdefault(plain(name), (int(address), int(size), name))
compared, wrong, known = 0, [], set()
for (number, firmware), items in ours.items():
    if number not in files:
        wrong.append((number, 'they have no such model'))
        continue
    listed = theirs(number, firmware)
    for key, (address, size, name) in items.items():
        if name in KNOWN and key not in listed:
            known.add(name)
        elif listed.get(key) != (address, size):
            wrong.append((files[number], firmware, name, (address, size), listed.get(key)))
        else:
            compared += 1
    wrong += [(files[number], firmware, 'ours lacks', key) for key in listed.keys() - items.keys()]
models = {number for number, _ in ours}
print('control tables: %d items of %d models compared, in two firmwares each; %d models in their list'
      % (compared, len(models), len(files)))
for name in sorted(known):
    print('  left out: %s: %s' % (name, KNOWN[name]))
if not models:
    wrong.append('nothing came in')
for difference in wrong:
    print('  differs:', difference)
sys.exit(bool(wrong))
