"""A hostile host at the port of a board: damaged frames, frames of anything, commands of strangers, floods.

Usage: hostile.py PORT COUNT SEED [--arms]. Sends COUNT frames, and prints what was answered as JSON. Exits with 1 if the
board answers what docs/link.md does not allow, leaves a command unanswered, or lost a setting, its rig or a show.
Without --arms, no frame with the session's number commands `Arm`. A frame of this host never changes what the board
stores; a stranger's, which must be refused, would."""
import collections
import json
import random
import select
import sys
import time

import link
from link import count, real, reals

# A busy machine delays a simulated board.
LATE_S = 20.0
# Commands that would change what is stored, or what the test must know.
EXCLUDED = ('WriteSetting', 'DeleteShow', 'EndUpload')
# Commands that move a rig or end its motion, and how often they are in a mood.
MOODS = [['Play', 'Hold'], ['Play'], ['Play'], ['Float', 'Hold'], ['Float'], ['Maintain', 'Leave'], ['Maintain'],
         ['Calibrate'], ['Teach'], ['Play', 'Stop'], ['Play', 'Disarm'], ['EStop'], ['Play', 'Float', 'Maintain', 'Leave']]


class Host:
    """A host with a session, and the choices of its hostile messages."""

    def __init__(self, path, seed, arms):
        self.port, self.rng, self.arms = link.Port(path), random.Random(seed), arms
        self.session, self.state, self.heard = 0, 'Off', None
        self.seqs = [0, 0]
        # Whether live frames are sent beside heartbeats.
        self.performs = False
        self.sent, self.answers, self.wrong = collections.Counter(), collections.Counter(), []
        # The first mood moves a rig, even in a short attack.
        self.mood, self.mood_end = ['Play'], None
        # What a source of live frames has in this mood.
        self.feed, self.pose = 1, [1.2, 0.2, -0.3]
        # Session and number of each command that must be refused.
        self.strange = set()

    # The well-behaved part.

    def listen(self):
        """Takes what has come, and returns the answers."""
        answers = []
        for name, fields in self.port.read():
            if name == 'Welcome':
                self.welcome(fields)
            elif name == 'Answer':
                which, result = fields['outcome']
                told = result[0] if which == 2 else ('applied', 'limited', '', 'working')[which]
                self.answers[told] += 1
                answers.append(fields)
                if told != 'Session' and (fields['session'], fields['number']) in self.strange:
                    self.wrong.append(('executed for a stranger', repr(fields)))
            elif name == 'Telemetry':
                self.heard = fields['number']
                if fields['part'][0] == 0:
                    self.state = fields['part'][1]['state']
        return answers

    def welcome(self, fields):
        accepted = fields['verdict'][0] == 0
        self.answers['welcome' if accepted else 'misfit'] += 1
        if accepted and fields['session'] != self.session:
            self.session, self.seqs = fields['session'], [0, 0]
        if not accepted and fields['session'] != 0:
            self.wrong.append(('a refused program knows a session', repr(fields)))

    def write(self, data):
        end = time.monotonic() + LATE_S
        while data:
            taken = self.port.write(data)
            data = data[taken:]
            if not taken:
                if time.monotonic() > end:
                    raise TimeoutError('the board reads nothing')
                self.listen()
                select.select([self.port.fd], [self.port.fd], [], 0.01)

    def greet(self):
        nonce = self.rng.getrandbits(32)
        end = time.monotonic() + 120.0
        before = self.answers['welcome']
        while self.answers['welcome'] == before:
            if time.monotonic() > end:
                raise TimeoutError('no welcome')
            self.write(link.frame(link.hello(nonce)))
            self.pause(0.1)

    def pause(self, seconds):
        """Stays alive without a hostile message. Returns the answers."""
        end = time.monotonic() + seconds
        answers = []
        while time.monotonic() < end:
            self.beat()
            select.select([self.port.fd], [], [], 0.02)
            answers += self.listen()
        return answers

    def beat(self):
        if self.session:
            heard = self.heard is not None
            self.write(link.frame(self.stream(4 if heard else 0, count(self.heard) if heard else b'')))
            if self.performs:
                sent_us = int(time.monotonic() * 1e6) & 0xffffffff
                self.write(link.frame(self.stream(3, count(sent_us) + reals(self.pose))))

    def stream(self, kind, fields=b''):
        self.seqs[1] = self.seqs[1] + 1 & 0xffff
        return link.stream(self.session, self.seqs[1], kind, fields)

    def command(self, name, fields=b''):
        self.seqs[0] = self.seqs[0] + 1 & 0xffff
        return link.command(self.session, self.seqs[0], name, fields)

    def ask(self, name, fields=b''):
        """Sends a command until it is answered."""
        for _ in range(100):
            session = self.session
            data, seq = link.frame(self.command(name, fields)), self.seqs[0]
            end = time.monotonic() + LATE_S
            while time.monotonic() < end and self.session == session:
                self.write(data)
                for answer in self.pause(0.1):
                    if (answer['session'], answer['number']) == (session, seq) and answer['outcome'][0] != 3:
                        return answer['outcome']
            if self.session == session:
                self.wrong.append(('no answer', name))
                return None
        raise TimeoutError('a new session again and again')

    def stock(self):
        """Returns all that the board stores."""
        settings = [self.ask('ReadSetting', count(key)) for key in range(1, 22)]
        places = [count(0), count(1)] + [count(2) + bytes([slot]) for slot in range(4)]
        return settings + [self.ask('AskStored', place) for place in places]

    def rest(self):
        """Waits until the rig is limp, with faults cleared."""
        end = time.monotonic() + 240.0
        while self.state != 'Limp':
            if time.monotonic() > end:
                raise TimeoutError('the rig stays ' + self.state)
            if self.state in ('Faulted', 'Off'):
                self.ask('ClearFaults')
            elif self.state not in ('Stopping', 'Lowering'):
                self.ask('Stop')
            self.ask('SetTelemetry', real(20.0) + bytes([15]))
            self.pause(0.3)

    def begin(self):
        """Arms the rig, and moves it, so that the attack meets a rig that moves."""
        end = time.monotonic() + 240.0

        def until(is_done):
            while not is_done():
                if time.monotonic() > end:
                    raise TimeoutError('the rig stays ' + self.state)
                self.pause(0.2)

        until(lambda: self.ask('Arm')[0] == 0)
        until(lambda: self.state == 'Holding')
        self.performs = True
        until(lambda: self.ask('Play', count(1))[0] == 0)
        self.pause(2.0)
        self.performs = False

    # The hostile part.

    def real(self):
        kind = self.rng.randrange(4)
        if kind == 0:
            return self.rng.uniform(-3, 3)
        if kind == 1:
            return self.rng.choice([0.0, -0.0, 3.4e38, -3.4e38, 1e-40, 1.0])
        if kind == 2:
            return self.rng.choice([float('nan'), float('inf'), -float('inf')])
        return self.rng.uniform(-0.5, 0.5)

    def chance(self, most):
        return self.rng.randrange(most) == 0

    def fields(self, name):
        """Returns fields of a command, valid or not, that store nothing."""
        r = self.rng
        small = bytes([r.randrange(5)])
        if name == 'Play':
            return count(self.feed if not self.chance(50) else r.randrange(4))
        if name in ('Maintain', 'Leave'):
            return bytes([r.choice([1, 1, 1, 2])])
        if name == 'LoadShow':
            return bytes([r.choice([0, 0, 1, 9])])
        if name == 'SetTelemetry':
            return real(r.choice([20.0, 50.0, 1e9, self.real()])) + bytes([r.choice([1, 15, 15, 255])])
        if name in ('ReadSetting', 'ReadFault', 'ReadPassed'):
            return count(r.randrange(700))
        if name == 'AskStored':
            return count(r.randrange(4)) + small
        if name == 'BeginUpload':
            length = r.choice([0, 1, 300, 4000, 2**32 - 1])
            return link.item(r.randrange(4), r.randrange(4), length, r.randbytes(32), r.getrandbits(32), b'Mallory')
        if name == 'UploadBlock':
            return link.block(r.choice([0, 0, 256, 512, 2**32 - 1]), r.randbytes(r.choice([0, 4, 9, 256, r.randrange(257)])))
        if name == 'PassOn':
            return link.pass_on(r.randrange(3), r.choice([0, 0, 1, 57600, 2**32 - 1]), r.choice([0, 300, 20000, 2**32 - 1]),
                                r.randbytes(r.choice([0, 10, 14, 128])))
        return b''

    def choose_mood(self):
        now = time.monotonic()
        if self.mood_end is None:
            self.mood_end = now + 5.0
        if now > self.mood_end:
            self.mood_end = now + self.rng.uniform(0.4, 4.0)
            self.mood = self.rng.choice(MOODS)
            self.feed = self.rng.randrange(3)
            self.pose = [self.rng.choice([self.rng.uniform(-2.0, 2.0), self.real()]) for _ in range(3)]

    def own(self):
        """Returns a command of the session."""
        # The way out of what is done by hand.
        if self.state in ('Calibrating', 'Teaching') and self.chance(500):
            return self.command('Stop')
        if self.arms and self.chance(5):
            if self.state == 'Faulted':
                return self.command('ClearFaults')
            if self.state == 'Limp' and not set(self.mood) & {'Calibrate', 'Teach'}:
                # An operator would keep it.
                return self.command('Leave', b'\1') if self.chance(4) else self.command('Arm')
            ends = {'Stop', 'Disarm', 'EStop'}
            name = self.rng.choice(self.mood)
            return self.command('Hold' if name in ends and not self.chance(2000) else name, self.fields(name))
        names = [name for name in link.COMMANDS[13:24] if name not in EXCLUDED] + ['LoadShow', 'ClearFaults']
        if not self.arms:
            names += ['Play', 'Hold', 'Float', 'Maintain', 'Leave', 'Calibrate', 'Teach', 'Disarm', 'Stop']
        name = self.rng.choice(names)
        if self.arms and name == 'PassOn' and not self.chance(300):
            # Registers are compared again after each packet, before the rig can be armed.
            name = 'ReadHealth'
        if name == 'LoadShow' and not self.chance(100):
            name = 'ReadFault'
        if self.chance(60):
            self.seqs[0] += self.rng.choice([-3, -1, 1, 7])
        if name == 'SetTelemetry' and not self.chance(20):
            return self.command(name, real(20.0) + bytes([15]))
        return self.command(name, self.fields(name))

    def streams(self):
        r = self.rng
        kind = r.choice([0, 1, 2, 3, 3, 3, 4])
        if kind == 4:
            return self.stream(4, count(self.heard if self.heard is not None and not self.chance(9) else r.randrange(65536)))
        values, sent_us = self.pose, int(time.monotonic() * 1e6)
        if self.chance(20):
            values = [self.real() for _ in range(r.choice([3, 3, 6, 64, r.randrange(70)]))]
        if self.chance(50):
            sent_us = r.getrandbits(32)
        fields = [b'', bytes([r.choice([1, 1, 1, 2])]), bytes([r.randrange(5)]) + real(self.real()),
                  count(sent_us & 0xffffffff) + reals(values)]
        if self.chance(20):
            self.seqs[1] += r.choice([-5, -1, 3])
        return self.stream(kind, fields[kind])

    def stranger(self):
        """Returns a valid command, with everything that changes what is stored, of another session."""
        r = self.rng
        # None, the one before, or one that the board has not reached: its welcome may be lost on a full line.
        session = r.choice([0, self.session - 1, self.session + r.randrange(10000, 50000)]) & 0xffff
        if self.chance(5):
            return link.stream(session, r.randrange(65536), r.randrange(3), b'\1' + real(0.5))
        name = r.choice([name for name in link.COMMANDS if name not in ('Stop', 'EStop') or self.arms and self.chance(3000)])
        fields = {'WriteSetting': count(6) + link.number(5.0), 'DeleteShow': b'\0'}.get(name) or self.fields(name)
        seq = r.randrange(65536)
        if name not in ('Stop', 'EStop'):
            self.strange.add((session, seq))
        return link.command(session, seq, name, fields)

    def is_excluded(self, body):
        """Returns whether a body that was made by chance could arm, or change what is stored. Goes on from its number,
        since the board refuses lower ones."""
        r = link.Reader(body)
        try:
            which = r.count() if r.byte() == 0x53 else 0
            if which not in (1, 2) or r.count() & 0xffff != self.session:
                return False
            seq = r.count() & 0xffff
            if seq - self.seqs[which - 1] & 0xffff < 0x8000:
                self.seqs[which - 1] = seq
            name = link.COMMANDS[r.count()]
        except IndexError:
            return False
        return which == 1 and (name in EXCLUDED or name == 'Arm' and not self.arms)

    def mutated(self, body):
        r, body = self.rng, bytearray(body)
        for _ in range(r.randrange(1, 4)):
            at = r.randrange(len(body))
            how = r.randrange(4)
            if how == 0:
                body[at] ^= 1 << r.randrange(8)
            elif how == 1:
                # A number that is longer than its type.
                body[at:at + 1] = b'\xff' * r.randrange(1, 12)
            elif how == 2:
                del body[at]
            else:
                body[at:at] = r.randbytes(r.randrange(1, 5))
            if not body:
                break
        return bytes(body)

    def message(self):
        """Returns the bytes of any frame, and its kind."""
        r = self.rng
        which = r.randrange(100)
        if which < 45:
            return 'stream', link.frame(self.streams())
        if which < 75:
            return 'command', link.frame(self.own())
        if which < 85:
            return 'stranger', link.frame(self.stranger())
        if which == 85 and self.chance(20):
            return 'hello', link.frame(link.hello(r.getrandbits(32), r.choice([0, 1, 1, 2, 255]), r.randrange(4)))
        if which < 90:
            data = bytearray(link.frame(self.own()))
            data[r.randrange(1, len(data) - 1)] ^= 1 << r.randrange(8)
            return 'damaged', bytes(data)
        if which < 94:
            body = self.mutated(self.own() if self.chance(2) else self.streams())
            if self.is_excluded(body):
                return 'damaged', b'\0'
            return 'mutated', link.frame(body)
        if which < 97:
            body = b'\x53' * self.chance(2) + r.randbytes(r.choice([1, 2, 3, 5, 8, 13, r.randrange(1, 300)]))
            return 'anything', b'\0' if self.is_excluded(body) else link.frame(body)
        if which < 98:
            return 'bytes', r.randbytes(r.randrange(1, 40)).replace(b'\0', b'\1')
        data = link.frame(self.own())
        return 'cut', data[:r.randrange(1, len(data))]

    def attack(self, messages):
        looked = 0
        while sum(self.sent.values()) < messages:
            self.choose_mood()
            batch = []
            for _ in range(16):
                kind, data = self.message()
                self.sent[kind] += 1
                batch.append(data)
            self.write(b''.join(batch))
            self.listen()
            if sum(self.sent.values()) - looked > 5000:
                looked = sum(self.sent.values())
                # A command between them is answered; the zero ends what was cut.
                self.write(b'\0')
                self.ask('ReadSetting', count(6))


def main():
    path, messages, seed, *more = sys.argv[1:]
    link.check_examples()
    host = Host(path, int(seed), '--arms' in more)
    host.greet()
    host.rest()
    before = host.stock()
    if host.arms:
        host.begin()
    begun = time.monotonic()
    host.attack(int(messages))
    took = time.monotonic() - begun
    host.write(b'\0')
    host.rest()
    host.greet()
    if host.stock() != before:
        host.wrong.append(('what is stored is not what it was', repr(before)))
    # Bytes that wait when a program opens the port are not whole.
    undecoded = host.port.undecoded
    host.wrong += [('not as on the page', frame) for frame in undecoded]
    print(json.dumps(dict(seconds=round(took, 1), sent=host.sent, answers=host.answers, wrong=len(host.wrong))))
    for wrong in host.wrong[:20]:
        print(wrong, file=sys.stderr)
    return 1 if host.wrong else 0


if __name__ == '__main__':
    sys.exit(main())
