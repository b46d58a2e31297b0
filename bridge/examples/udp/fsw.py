#!/usr/bin/env python3
"""Flight software in Python over plain UDP, without middleware: stops the rotation of ../first/satellite.yaml, as ../first/fsw.cc
does. The datagrams: ../../UDP.md. The messages inside are encoded by what lcm-gen makes; nothing of LCM is needed to run it.

    lcm-gen -p --ppath TYPES bridge/schema/lcm/*.lcm
    fsw.py TYPES [ADDRESS PORT] &
    unlatch hil bridge/examples/first/satellite.yaml --transport udp --pace lockstep
"""
import itertools
import random
import socket
import struct
import sys
import zlib

sys.path.insert(0, sys.argv[1])
from unlatch import Catalog, Command, Hello, HelloAck, State, StepAck  # what lcm-gen made

SIMULATOR = (sys.argv[2], int(sys.argv[3])) if len(sys.argv) > 2 else ("127.0.0.1", 7670)
HEADER = struct.Struct(">IIIHHI")  # magic, run, sequence, kind, length, checksum
MAGIC = 0x554E4C31  # "UNL1"
JOIN, HELLO, CATALOG, HELLO_ACK, STATE, COMMAND, STEP_ACK = range(7)  # 1 + the message's number
AS_PARTICIPANT = struct.pack(">I", 1)
PATIENCE = 100  # joins, ten a second

wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
wire.connect(SIMULATOR)  # what comes from elsewhere is kept away
wire.settimeout(0.1)
run, sequences = random.getrandbits(32), itertools.count()


def control(rate):
    return -40 * rate  # N m for rad/s. Your algorithm goes here.


def seal(kind, payload):
    header = HEADER.pack(MAGIC, run, next(sequences) % 2**32, kind, len(payload), 0)
    checksum = zlib.crc32(header + payload)
    return header[:16] + struct.pack(">I", checksum) + payload


def send(kind, payload):
    try:
        wire.send(seal(kind, payload))
    except ConnectionRefusedError:
        pass  # no simulator yet


def receive():
    """(kind, message's bytes) of the next datagram; joins while there is none, and once in a while besides"""
    for _ in range(PATIENCE):
        try:
            datagram = wire.recv(65536)
        except (TimeoutError, ConnectionRefusedError):
            send(JOIN, AS_PARTICIPANT)
            continue
        magic, _run, _sequence, kind, length, checksum = HEADER.unpack_from(datagram)
        payload = datagram[HEADER.size:]
        if (magic, length, checksum) == (MAGIC, len(payload), zlib.crc32(datagram[:16] + bytes(4) + payload)):
            return kind, payload
    sys.exit(f"fsw: no simulator was heard at {SIMULATOR[0]}:{SIMULATOR[1]}")


def make(kind, **fields):
    message = kind()
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def main():
    numbers, me, command, hellos = {}, None, None, 0
    participant = random.getrandbits(31)  # distinguishes two programs of one name
    print("fsw: waits for a simulator", flush=True)
    send(JOIN, AS_PARTICIPANT)
    while True:
        kind, data = receive()
        if kind == CATALOG:  # numbers of sensor values and channels, by name
            item = Catalog.decode(data)
            numbers[item.kind, item.name.partition(b"\0")[0]] = item.index
        elif kind == HELLO and (Catalog.CatalogKind_kChannel, b"wheel") in numbers:
            hello = Hello.decode(data)
            if me is None or me.session != hello.session:
                command = make(Command, session=hello.session, sequence=0, tick=-1)
            me = make(HelloAck, session=hello.session, sequence=hellos, schema_hash=HelloAck.kSchemaHash, model_hash=hello.model_hash,
                      dt_ns=hello.dt_ns, protocol=HelloAck.kProtocolVersion, participant=participant,
                      name=b"fsw".ljust(48, b"\0"), reason=bytes(96))
            send(HELLO_ACK, me.encode())
            hellos += 1
        elif kind == STATE and me is not None:
            state = State.decode(data)
            if state.session != me.session:
                continue
            if state.status >= State.RunStatus_kDone:
                return print(f"fsw: the session ended at tick {state.tick}")
            if state.tick > command.tick:  # new; a State that is resent gets the same answer again
                rate = state.sensors[numbers[Catalog.CatalogKind_kSensor, b"gyro.z"]]
                command = make(Command, session=me.session, sequence=state.tick + 1, tick=state.tick, valid_until_tick=-1,
                               value=control(rate), participant=participant, channel=numbers[Catalog.CatalogKind_kChannel, b"wheel"])
            send(COMMAND, command.encode())
            send(STEP_ACK, make(StepAck, session=me.session, sequence=state.sequence, tick=state.tick,
                                last_command=command.sequence, participant=participant, command_count=1).encode())


main()
