#!/usr/bin/env python3
"""Flight software in Python over LCM's bytes: stops the rotation of ../first/satellite.yaml, as ../first/fsw.cc does.

    lcm-gen -p --ppath TYPES bridge/schema/lcm/*.lcm
    fsw.py TYPES &
    unlatch hil bridge/examples/first/satellite.yaml --transport lcm --pace lockstep
"""
import random
import socket
import struct
import sys
import time

sys.path.insert(0, sys.argv[1])
from unlatch import Catalog, Command, Hello, HelloAck, State, StepAck  # what lcm-gen made

GYRO, WHEEL = (Catalog.CatalogKind_kSensor, b"gyro.z"), (Catalog.CatalogKind_kChannel, b"wheel")
GROUP = ("239.255.76.67", 7667)
SHORT_MESSAGE = 0x4C433032  # "LC02": a message in one datagram; ours all are
PATIENCE = 10  # s
GONE = 2  # s; a simulator that has been silent for so long is gone
wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
wire.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
wire.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
wire.bind(GROUP)
wire.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP[0]) + bytes(4))
wire.settimeout(PATIENCE)


def control(rate):
    return -40 * rate  # N m for rad/s. Your algorithm goes here.


def make(kind, **fields):
    message = kind()
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def send(channel, message):
    wire.sendto(struct.pack(">II", SHORT_MESSAGE, 0) + channel + b"\0" + message.encode(), GROUP)


def main():
    numbers, session, heard, warned, command, hellos = {}, None, 0, False, None, 0
    participant = random.getrandbits(31)  # distinguishes two programs of one name
    print("fsw: waits for a simulator", flush=True)
    while True:
        channel, _, data = wire.recv(65536)[8:].partition(b"\0")
        if channel == b"UNLATCH_HELLO":
            hello = Hello.decode(data)
            if hello.status >= State.RunStatus_kDone:
                continue  # of a session that is over
            if hello.session != session:
                if session is not None and time.monotonic() - heard < GONE:
                    if not warned:
                        print(f"fsw: another simulator is heard, session {hello.session}; stays with session {session}", flush=True)
                    warned = True
                    continue
                session, numbers = hello.session, {}
                command = make(Command, session=session, sequence=0, tick=-1)
            heard = time.monotonic()
            if numbers.keys() >= {GYRO, WHEEL}:
                send(b"UNLATCH_HELLO_ACK",
                     make(HelloAck, session=session, sequence=hellos, schema_hash=HelloAck.kSchemaHash, model_hash=hello.model_hash,
                          dt_ns=hello.dt_ns, protocol=HelloAck.kProtocolVersion, participant=participant,
                          name=b"fsw".ljust(48, b"\0"), reason=bytes(96)))
                hellos += 1
        elif channel == b"UNLATCH_CATALOG":  # numbers of sensor values and channels, by name
            item = Catalog.decode(data)
            if item.session == session:
                numbers[item.kind, item.name.partition(b"\0")[0]] = item.index
        elif channel == b"UNLATCH_STATE" and numbers.keys() >= {GYRO, WHEEL}:
            state = State.decode(data)
            if state.session != session:
                continue
            heard = time.monotonic()
            if state.status >= State.RunStatus_kDone:
                return print(f"fsw: the session ended at tick {state.tick}")
            if state.tick > command.tick:  # new; a State that is resent gets the same answer again
                rate = state.sensors[numbers[GYRO]]
                command = make(Command, session=session, sequence=state.tick + 1, tick=state.tick, valid_until_tick=-1,
                               value=control(rate), participant=participant, channel=numbers[WHEEL])
            send(b"UNLATCH_COMMAND", command)
            send(b"UNLATCH_STEP_ACK", make(StepAck, session=session, sequence=state.sequence, tick=state.tick,
                                           last_command=command.sequence, participant=participant, command_count=1))


try:
    main()
except TimeoutError:
    sys.exit(f"fsw: no simulator was heard for {PATIENCE} s; does `ip route get {GROUP[0]}` name the interface that it uses (lo)?")
