#!/usr/bin/env python3
"""Flight software in Python over DDS, by Cyclone's C library and ctypes: takes part in a lockstep session of ../probe.yaml as 'pilot', opens
the throttle at tick 100 and shuts it at tick 300, as ../c/pilot.c does. Cyclone's own binding for Python is in no Debian package.

    dds.py bridge/schema/unlatch.idl TYPES.so &
    unlatch hil bridge/examples/probe.yaml --transport dds --pace lockstep

TYPES.so has the descriptors that `idlc unlatch.idl` makes: cc -shared -fPIC unlatch.c -o TYPES.so -lddsc. The messages are structures of
the IDL's fields in their order, without padding.
"""
import ctypes
import ctypes.util
import os
import random
import re
import sys
import time

NETWORK = b"""<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer Address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""
OPEN_AT, SHUT_AT = 100, 300
PATIENCE = 30  # s
GONE = 2  # s; a simulator that has been silent for so long is gone
SECOND = 1_000_000_000
NUMBERS = {"long long": ctypes.c_int64, "long": ctypes.c_int32, "double": ctypes.c_double, "octet": ctypes.c_uint8}


def read_idl(path):
    """Constants by their names; structures as classes of ctypes."""
    text = re.sub(r"//.*", "", open(path, encoding="utf-8").read())
    constants = {name: int(value) for name, value in re.findall(r"const (?:long )+(\w+) = (-?\d+);", text)}
    types = dict(NUMBERS)
    for name, body in re.findall(r"struct (\w+) \{(.*?)\};", text, re.S):
        fields = []
        for kind, field, size in re.findall(r"([\w ]+?)\s+(\w+)(?:\[(?:unlatch::)?(\w+)\])?;", body.replace("@key", "")):
            of = types[kind.strip()]
            fields.append((field.lstrip("_"), of * int(constants.get(size, size)) if size else of))
        types[name] = type(name, (ctypes.Structure,), {"_fields_": fields})
    return constants, types


CONSTANTS, TYPES = read_idl(sys.argv[1])
dds = ctypes.CDLL(ctypes.util.find_library("ddsc"), mode=ctypes.RTLD_GLOBAL)
descriptors = ctypes.CDLL(sys.argv[2])
dds.dds_create_qos.restype = ctypes.c_void_p
dds.dds_strretcode.restype = ctypes.c_char_p


def check(what, entity):
    if entity < 0:
        sys.exit(f"pilot: {what}: {dds.dds_strretcode(entity).decode()}")
    return ctypes.c_int32(entity)


def make_qos(transient, depth):
    """Everything is reliable. What must outlive the moments in which both sides discover each other is transient-local."""
    qos = ctypes.c_void_p(dds.dds_create_qos())
    dds.dds_qset_reliability(qos, 1, ctypes.c_int64(SECOND // 10))
    dds.dds_qset_history(qos, 0, ctypes.c_int32(depth))
    if transient:
        dds.dds_qset_durability(qos, 1)
        dds.dds_qset_durability_service(qos, ctypes.c_int64(0), 0, ctypes.c_int32(64), *[ctypes.c_int32(-1)] * 3)
        dds.dds_qset_lifespan(qos, ctypes.c_int64(2 * SECOND))  # the next simulator shall not receive old commands
    return qos


class Topic:
    """A reader or a writer of one message."""

    def __init__(self, participant, name, transient, writes):
        self.type = TYPES[name]
        descriptor = ctypes.c_char.in_dll(descriptors, f"unlatch_{name}_desc")
        topic = check(name, dds.dds_create_topic(participant, ctypes.byref(descriptor), f"unlatch_{name}".encode(), None, None))
        qos = make_qos(transient, 64 if writes else 256)
        create = dds.dds_create_writer if writes else dds.dds_create_reader
        self.entity = check(name, create(participant, topic, qos, None))
        dds.dds_delete_qos(qos)

    def write(self, message):
        dds.dds_write(self.entity, ctypes.byref(message))

    def take(self):
        """The next message; None: there is none."""
        message, info = self.type(), (ctypes.c_uint64 * 32)()  # dds_sample_info_t is smaller; valid_data is its fourth number
        pointer = ctypes.c_void_p(ctypes.addressof(message))
        while dds.dds_take(self.entity, ctypes.byref(pointer), info, ctypes.c_size_t(1), ctypes.c_uint32(1)) == 1:
            if ctypes.cast(info, ctypes.POINTER(ctypes.c_uint8))[12]:
                return message
        return None


def decide(state):
    """The command from a State, for which flight software is there; None: nothing to command."""
    return {OPEN_AT: 1.0, SHUT_AT: 0.0}.get(state.tick)


def main():
    if "CYCLONEDDS_URI" not in os.environ:
        check("domain", dds.dds_create_domain(0, NETWORK))
    participant = check("participant", dds.dds_create_participant(0, None, None))
    hellos, catalog, states = (Topic(participant, name, name != "State", False) for name in ("Hello", "Catalog", "State"))
    acks, commands, step_acks = (Topic(participant, name, name != "StepAck", True) for name in ("HelloAck", "Command", "StepAck"))
    number, throttle, session, heard, answered, command, latest, introductions = random.getrandbits(31), None, None, time.monotonic(), -1, None, 0, 0
    hello = None
    while time.monotonic() - heard < PATIENCE:
        busy = False
        while (state := states.take()) is not None:
            busy = True
            if state.session != session or throttle is None or state.part != 0 or state.tick < answered:
                continue
            heard = time.monotonic()
            if state.status >= CONSTANTS["RunStatus_kDone"]:
                print(f"pilot: the session ended at tick {state.tick}, x = {state.bodies[0].x:.6f} m")
                return 0 if state.status == CONSTANTS["RunStatus_kDone"] else 1
            if state.tick > answered:
                answered, command, value = state.tick, None, decide(state)
                if value is not None:
                    latest += 1
                    command = TYPES["Command"](session=session, sequence=latest, tick=state.tick, valid_until_tick=-1, value=value,
                                               participant=number, channel=throttle)
            if command is not None:  # a State that is resent is answered again, with the same numbers
                commands.write(command)
            step_acks.write(TYPES["StepAck"](session=session, sequence=state.sequence, tick=state.tick, last_command=latest,
                                             participant=number, command_count=int(command is not None)))
        while (found := hellos.take()) is not None:
            busy = True
            if found.status >= CONSTANTS["RunStatus_kDone"] or (found.session != session and session is not None and time.monotonic() - heard < GONE):
                continue  # kept from a session that is over, or of another simulator
            if found.session != session:
                session, throttle, answered, latest, introductions = found.session, None, -1, 0, 0
            hello, heard = found, time.monotonic()
        while (item := catalog.take()) is not None:
            busy = True
            if item.session == session and item.kind == CONSTANTS["CatalogKind_kChannel"] and bytes(item.name).partition(b"\0")[0] == b"throttle":
                throttle = item.index
        if hello is not None and throttle is not None:
            acks.write(TYPES["HelloAck"](session=session, sequence=introductions, schema_hash=CONSTANTS["kSchemaHash"], model_hash=hello.model_hash,
                                         dt_ns=hello.dt_ns, protocol=CONSTANTS["kProtocolVersion"], participant=number,
                                         status=CONSTANTS["AckStatus_kReady"], name=(ctypes.c_uint8 * 48)(*b"pilot")))
            introductions, hello = introductions + 1, None
        if not busy:
            time.sleep(0.0005)
    print("pilot: the simulator is silent", file=sys.stderr)
    return 1


if __name__ == "__main__":
    code = main()
    dds.dds_delete(ctypes.c_int32(0x7fff0100))  # DDS_CYCLONEDDS_HANDLE: Cyclone's threads end before the process does
    sys.exit(code)
