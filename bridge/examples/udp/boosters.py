#!/usr/bin/env python3
"""Flight software of the boosters over plain UDP, with Python's standard library alone: boosters.py [ADDRESS:PORT]

    build/release/bin/unlatch hil hil/scenarios/boosters/scenario.yaml --transport udp --pace lockstep --until 2 &
    bridge/examples/udp/boosters.py

Written from bridge/CLIENTS.md and UDP.md: formats, fingerprints and numbers are those of their tables.
"""
import random
import socket
import struct
import sys
import time
import zlib

PROTOCOL, SCHEMA_HASH = 4, 3634127338689530239
JOIN, HELLO, CATALOG, HELLO_ACK, STATE, COMMAND, STEP_ACK = range(7)  # kinds of a datagram
FINGERPRINTS = {HELLO: 0xC69D8744C01B28EB, CATALOG: 0xD6E07B8DDD67E639, HELLO_ACK: 0xE700D822FE6560E3, STATE: 0x6775E179FE5F7785,
                COMMAND: 0x656025A7E259739A, STEP_ACK: 0xB2E66E417C19C063}
FORMATS = {HELLO: ">Q9q10i48s", CATALOG: ">Q2q4d2i48s48s", HELLO_ACK: ">Q5q4i48s96s", STATE: ">Q5q64d208d6i64s", COMMAND: ">Q4qd2i",
           STEP_ACK: ">Q4q2i"}
HEADER, MAGIC = ">IIIHHI", 0x554E4C31
CHANNEL, SENSOR = 2, 3  # kinds of an item of the catalog
DONE = 5  # RunStatus: this and more: over
SEQUENCE = ((100, "throttle", 0.84), (250, "verniers", 0), (300, "rudder", 0), (450, "cut_ties", 1), (500, "cutoff", 1))  # tick


class Link:
    """Datagrams to and from the simulator."""

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(address)
        self.socket.settimeout(0.1)
        self.run, self.sent, self.joined = random.getrandbits(32), 0, 0.0
        self.heard_run, self.expected = None, 0

    def send(self, kind, payload):
        parts = [MAGIC, self.run, self.sent, kind, len(payload)]
        checksum = zlib.crc32(struct.pack(HEADER, *parts, 0) + payload)
        self.sent = (self.sent + 1) & 0xFFFFFFFF
        try:
            self.socket.send(struct.pack(HEADER, *parts, checksum) + payload)
        except ConnectionRefusedError:  # no simulator yet
            pass

    def say(self, kind, *fields):
        self.send(kind, struct.pack(FORMATS[kind], FINGERPRINTS[kind], *fields))

    def receive(self):
        """(kind, fields), or None where nothing usable came."""
        if time.monotonic() > self.joined + 0.1:
            self.joined = time.monotonic()
            self.send(JOIN, struct.pack(">I", 1))
        try:
            datagram = self.socket.recv(65536)
        except (socket.timeout, ConnectionRefusedError):
            return None
        size = struct.calcsize(HEADER)
        if len(datagram) < size:
            return None
        magic, run, sequence, kind, length, checksum = struct.unpack_from(HEADER, datagram)
        if magic != MAGIC or length != len(datagram) - size or zlib.crc32(datagram[:16] + bytes(4) + datagram[20:]) != checksum:
            return None
        if run != self.heard_run:
            self.heard_run, self.expected = run, sequence
        if (sequence - self.expected) & 0x80000000:  # behind
            return None
        self.expected = (sequence + 1) & 0xFFFFFFFF
        if kind not in FORMATS or length != struct.calcsize(FORMATS[kind]):
            return None
        fingerprint, *fields = struct.unpack(FORMATS[kind], datagram[size:])
        return (kind, fields) if fingerprint == FINGERPRINTS[kind] else None


class FlightSoftware:
    """The cyclogram of the separation: what is commanded at a tick of 1 ms."""

    def __init__(self):
        self.contact = {}  # booster: tick at which its contact fired

    def command(self, tick, channels, sensors):
        commands = []
        for at, name, value in SEQUENCE:
            if tick == at:
                commands += [(index, value) for channel, index in channels.items() if channel.rstrip("1234") == name]
        for i in "1234":
            if sensors[f"kr{i}"] > 0.5:
                self.contact.setdefault(i, tick)
            if tick == self.contact.get(i, tick) + 12:  # the nozzle pushes the nose away
                commands.append((channels[f"nozzle{i}"], 1))
        return commands


def main():
    address, port = (sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:7670").split(":")
    link, software = Link((address, int(port))), FlightSoftware()
    number = random.getrandbits(31)
    session, answered, last_command, acknowledgements, answer = None, -1, 0, 0, []
    channels, sensors, counts = {}, {}, (0, 0)
    while True:
        message = link.receive()
        if message is None:
            continue
        kind, fields = message
        if kind == HELLO:
            if session is None and fields[11] < DONE:
                session, model_hash, dt_ns, counts = fields[0], fields[3], fields[4], (fields[15], fields[16])
            if fields[0] != session or (len(channels), len(sensors)) != counts:
                continue  # of another session, or the catalog is not complete
            link.say(HELLO_ACK, session, acknowledgements, SCHEMA_HASH, model_hash, dt_ns, PROTOCOL, number, 0, 0, b"fsw", b"")
            acknowledgements += 1
        elif kind == CATALOG and fields[0] == session:
            name = fields[8].split(b"\0")[0].decode()
            if fields[6] in (CHANNEL, SENSOR):
                (channels if fields[6] == CHANNEL else sensors)[name] = fields[7]
        elif kind == STATE and fields[0] == session and fields[278] == 0:  # part 0
            sequence, tick, status = fields[1], fields[2], fields[277]
            if tick > answered:
                values = {name: fields[5 + index] for name, index in sensors.items()}
                answered, answer = tick, []
                for channel, value in software.command(tick, channels, values):
                    last_command += 1
                    answer.append((session, last_command, tick, -1, value, number, channel))
            if tick == answered:
                for command in answer:
                    link.say(COMMAND, *command)
                link.say(STEP_ACK, session, sequence, tick, last_command, number, len(answer))
            if status >= DONE:
                print(f"fsw: the session ended at tick {tick}, status {status}, {len(software.contact)} contacts")
                return 0 if status == DONE else 1


if __name__ == "__main__":
    sys.exit(main())
