#!/usr/bin/env python3
"""Reads our LCM messages with what `lcm-gen -p` makes and nothing else: LCM's Python module is not needed.

    lcm-gen -p --ppath TYPES bridge/schema/lcm/*.lcm
    listen.py TYPES                  listens to a session until it ends
    listen.py TYPES FILE             reads a file of lcm-logger or `unlatch log`
"""
import socket
import struct
import sys

GROUP, PORT = "239.255.76.67", 7667
SHORT_MESSAGE = 0x4C433032  # "LC02": one datagram; ours all are
LOG_EVENT = 0xEDA1DA01
SO_RCVBUFFORCE = 33  # which Python does not name


def listen():
    """(channel, bytes) of every message on the network"""
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:  # Python is slower than a simulator in a hurry: as root the buffer may take thousands of states
        heard.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 24)
    except PermissionError:
        heard.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
    heard.bind((GROUP, PORT))
    heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + bytes(4))
    heard.settimeout(30)
    print("listening", flush=True)
    while True:
        packet = heard.recv(65536)
        magic, _number = struct.unpack_from(">II", packet)
        if magic == SHORT_MESSAGE:
            channel, data = packet[8:].split(b"\0", 1)
            yield channel.decode(), data


def read(path):
    """(channel, bytes) of every event in a log file"""
    with open(path, "rb") as log:
        while header := log.read(28):
            magic, _number, _time_us, channel_length, data_length = struct.unpack(">IqqII", header)
            if magic != LOG_EVENT:
                raise ValueError(f"{path} is no LCM log")
            channel = log.read(channel_length).decode()
            yield channel, log.read(data_length)


def main():
    sys.path.insert(0, sys.argv[1])
    import unlatch  # what lcm-gen made

    types = {"UNLATCH_HELLO": unlatch.Hello, "UNLATCH_STATE": unlatch.State, "UNLATCH_COMMAND": unlatch.Command,
             "UNLATCH_EVENT": unlatch.Event}
    states = commands = 0
    for channel, data in read(sys.argv[2]) if len(sys.argv) > 2 else listen():
        if channel not in types:
            continue
        message = types[channel].decode(data)
        if channel == "UNLATCH_HELLO" and message.sequence == 0:
            print(f"session {message.session}, scenario {bytes(message.scenario).split(bytes(1))[0].decode()}", flush=True)
        elif channel == "UNLATCH_COMMAND":
            commands += 1
            print(f"command {message.sequence} for tick {message.tick}: channel {message.channel} = {message.value}")
        elif channel == "UNLATCH_STATE":
            states += 1
            if message.status >= unlatch.State.RunStatus_kDone:
                body = message.bodies[0]
                print(f"ended at tick {message.tick}: x = {body.x!r}; {states} states, {commands} commands heard")
                return


if __name__ == "__main__":
    main()
