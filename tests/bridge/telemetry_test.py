#!/usr/bin/env python3
"""Telemetry of a running session: space packets decoded by their XTCE file alone, the live stream in a real browser, hostile and slow clients.
Run in a network namespace by tests/support/netns.sh:

    telemetry_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import csv
import http.server
import json
import os
import signal
import socket
import struct
import sys
import threading
import time
import unittest

from processes import HANG, SOURCE, UNLATCH, ProcessTest, run_tests

sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "tests/support"))
from browser import CHROMIUM, Browser  # noqa: E402
from xtce import Xtce, split  # noqa: E402

SCENARIO = SOURCE / "hil/scenarios/sensors/scenario.yaml"
UDP_PORT, TCP_PORT, LIVE_PORT, PAGE_PORT = 10015, 10016, 8765, 8080
FLIGHT = ["--pace", "realtime", "--set", "constants.fire=1 s", "--set", "timing.states.every=10", "--set", "requirements=[]",
          "--set", "timing.overruns=slip"]  # a State every 10 ms; a machine that stalls is no failure here


def connect(port):
    for _ in range(100 * HANG):
        try:
            return socket.create_connection(("127.0.0.1", port), 5)
        except ConnectionRefusedError:
            time.sleep(0.01)
    raise TimeoutError(port)


def read_all(connection, to):
    try:
        while data := connection.recv(1 << 16):
            to += data
    except OSError:
        pass


class TelemetryTest(ProcessTest):
    def open_telemetry(self, *options, transport="udp", **kinds):
        process = self.begin(UNLATCH, "telemetry", "--transport", transport, "--rate", 0, "--until-end", "--json", self.folder / "telemetry.json", *options, **kinds)
        self.wait_for(process, "waits for a session")
        return process

    def fly(self, until=3):
        return self.run_json(UNLATCH, "hil", SCENARIO, "--transport", "udp", "--log", self.folder / "flight.log", *FLIGHT, "--until", until, code=None)

    def close(self, process):
        self.finish(process)
        return json.loads((self.folder / "telemetry.json").read_text())

    def read_recording(self):
        """Values of the recording at each tick, by column: what the packets must have."""
        text = self.run_ok(UNLATCH, "export", self.folder / "flight.log", "--format", "csv", "--every", 10, "--outputs", "body.*,received.*", "--out", "-").stdout
        return {round(float(row["t [s]"]) * 1000): {key.split(" [")[0]: value for key, value in row.items()} for row in csv.DictReader(text.splitlines())}

    def listen(self):
        """Datagrams of the packets, in a thread."""
        datagrams, receiver = [], socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        receiver.bind(("127.0.0.1", UDP_PORT))
        receiver.settimeout(0.2)
        done = threading.Event()

        def run():
            while True:
                try:
                    datagrams.append(receiver.recv(1 << 16))
                except TimeoutError:
                    if done.is_set():
                        break
        thread = threading.Thread(target=run)
        thread.start()

        def end():
            done.set()
            thread.join()
            receiver.close()
            return datagrams
        self.addCleanup(lambda: done.set())
        return end

    def test_packets_decoded_by_the_xtce_file_alone_have_the_values_of_the_recording_to_the_bit(self):
        end = self.listen()
        telemetry = self.open_telemetry("--packets", f"127.0.0.1:{UDP_PORT}", "--packets-tcp", f"127.0.0.1:{TCP_PORT}", "--xtce", self.folder / "session.xml")
        stream, client = bytearray(), connect(TCP_PORT)
        self.addCleanup(client.close)
        reader = threading.Thread(target=read_all, args=(client, stream))
        reader.start()
        result = self.fly()
        report = self.close(telemetry)
        reader.join(HANG)
        datagrams, packets = end(), split(bytes(stream))
        self.assertEqual(sum(map(len, packets)), len(stream))  # whole packets, back to back
        self.assertEqual(packets, datagrams)
        self.assertEqual(report["packets"]["dropped"], 0)

        xtce = Xtce((self.folder / "session.xml").read_text())
        self.assertEqual(xtce.name, "sensors")
        decoded = [xtce.decode(packet) for packet in packets]
        recording = self.read_recording()
        states = [values for name, values in decoded if name == "State"]
        self.assertGreater(len(states), 250)
        for values in states:
            row = recording[values["State.tick"]]
            for column, text in row.items():
                body, _, what = column.partition(".")
                if column in values:  # satellite.x is its position; received.gyro1.x is a sensor's value
                    self.assertEqual(values[column], float(text), (values["State.tick"], column))
            for sensor in ("received.gyro1.x", "received.star_tracker1.w", "received.wire1"):
                self.assertIn(sensor, values)
                self.assertIn(sensor, row)
            seconds = values["time_seconds"] + values["time_fraction"] * 2.0**-24
            self.assertAlmostEqual(seconds, values["State.time_ns"] * 1e-9, delta=2.0**-24)
        self.assertEqual({values["State.status"] for values in states} - {"configured", "armed"}, {"running", "done"})
        self.assertEqual(states[-1]["State.status"], "done")
        happened = {values["Event.name"]: values["Event.time"] for name, values in decoded if name == "Event"}
        for event in result["events"]:
            self.assertEqual(happened[event["name"]], event["t"])
        self.assertTrue(any(name == "Health" for name, _ in decoded))
        self.assertEqual({xtce.get_unit(name) for name, alias in xtce.aliases.items() if alias == "satellite.vx"}, {"m/s"})
        counts = {}
        for name, values in decoded:  # of each identifier the count goes on by one
            if name in counts:
                self.assertEqual(values["ccsds_sequence_count"], (counts[name] + 1) % 2**14, name)
            counts[name] = values["ccsds_sequence_count"]

    def test_positions_of_bodies_are_those_of_the_recording(self):
        end = self.listen()
        telemetry = self.open_telemetry("--packets", f"127.0.0.1:{UDP_PORT}", "--xtce", self.folder / "session.xml")
        self.fly()
        self.close(telemetry)
        xtce, recording = Xtce((self.folder / "session.xml").read_text()), self.read_recording()
        compared = 0
        for name, values in map(xtce.decode, end()):
            if name == "State":
                for column in ("satellite.x", "satellite.qw", "satellite.vx", "satellite.wx", "stage.z"):
                    self.assertEqual(values[column], float(recording[values["State.tick"]][column]), column)
                    compared += 1
        self.assertGreater(compared, 1000)

    def test_the_xtce_file_of_a_scenario_is_the_same_in_every_session(self):
        texts = []
        for name in ("a.xml", "b.xml"):
            telemetry = self.open_telemetry("--xtce", self.folder / name)
            self.fly(until=0.2)
            self.close(telemetry)
            texts.append((self.folder / name).read_bytes())
        self.assertEqual(*texts)

    def test_the_description_of_check_is_that_of_the_session_with_names_of_modes(self):
        telemetry = self.open_telemetry("--xtce", self.folder / "session.xml")
        self.fly(until=0.2)
        self.close(telemetry)
        self.run_ok(UNLATCH, "check", SCENARIO, "--xtce", self.folder / "check.xml")
        session, check = (Xtce((self.folder / name).read_text()) for name in ("session.xml", "check.xml"))
        self.assertEqual(list(session.parameters), list(check.parameters))
        other = {name for name in session.parameters if session.parameters[name] != check.parameters[name]}
        self.assertEqual({check.aliases[name] for name in other}, {"clamp.mode"})
        kind = check.types[check.parameters[other.pop()]]
        labels = {one.get("label"): one.get("value") for one in kind.iter() if one.get("label") is not None}
        modes = {joint["name"]: list(joint["modes"]) for joint in self.run_json(UNLATCH, "check", SCENARIO)["joints"]}["clamp"]
        self.assertEqual(labels, {name: str(i) for i, name in enumerate(modes)})
        self.assertEqual({check.get_unit(name) for name, alias in check.aliases.items() if alias == "Command.value"}, {""})

    def test_a_session_whose_scenario_is_given_is_described_with_names_of_modes(self):
        self.run_ok(UNLATCH, "check", SCENARIO, "--xtce", self.folder / "check.xml")
        for scenario, named in ((SCENARIO, True), (SOURCE / "hil/scenarios/boosters/scenario.yaml", False)):
            telemetry = self.open_telemetry("--xtce", self.folder / "session.xml", "--scenario", scenario)
            self.fly(until=0.2)
            errors = self.finish(telemetry)
            self.assertEqual((self.folder / "session.xml").read_bytes() == (self.folder / "check.xml").read_bytes(), named)
            self.assertEqual("the session has other joints than" in errors, not named)
        refused = self.run_ok(UNLATCH, "telemetry", "--transport", "udp", "--packets", "127.0.0.1:10099", "--scenario", SCENARIO, code=2)
        self.assertIn("give that, too", refused.stderr)

    def test_addresses_rates_and_folders_that_cannot_be_are_refused_before_the_session(self):
        for option, value, reason in (("--live", "127.0.0.1", "write it like 127.0.0.1:10015"), ("--live", ":99999", "ports are 1 to 65535"), ("--packets", "127.0.0.1:0", "1 to 65535"),
                                      ("--packets-tcp", "nowhere:10015", "localhost:10015"), ("--rate", "nan", "no number from 0 on"), ("--rate", "-1", "no number from 0 on"), ("--rate", "1e999", "from 0 on")):
            arguments = [option, value] + (["--packets", "127.0.0.1:10015"] if option == "--rate" else [])
            result = self.run_ok(UNLATCH, "telemetry", "--transport", "udp", *arguments, code=2)
            self.assertIn(option, result.stderr)
            self.assertIn(reason, result.stderr)
            self.assertLess(max(map(len, result.stderr.split())), 60, result.stderr)
        result = self.run_ok(UNLATCH, "telemetry", "--transport", "udp", "--xtce", self.folder / "none/session.xml", "--for", 1, code=None)
        self.assertIn("none/session.xml", result.stderr)
        self.assertNotIn("waits for a session", result.stderr)
        self.assertNotEqual(result.returncode, 0)

    def test_localhost_is_an_address(self):
        self.open_telemetry("--live", f"localhost:{LIVE_PORT}", "--packets-tcp", f"localhost:{TCP_PORT}")
        for port in (LIVE_PORT, TCP_PORT):
            connect(port).close()

    # A program that is stopped over DDS, whose writer keeps 192 messages: it must say what it missed, and how much.
    def test_states_that_never_came_are_counted_by_their_numbers(self):
        telemetry = self.open_telemetry("--packets-tcp", f"127.0.0.1:{TCP_PORT}", "--xtce", self.folder / "session.xml", transport="dds")
        stream, client = bytearray(), connect(TCP_PORT)
        self.addCleanup(client.close)
        reader = threading.Thread(target=read_all, args=(client, stream))
        reader.start()
        flight = self.begin(UNLATCH, "hil", SCENARIO, "--transport", "dds", *FLIGHT, "--set", "timing.states.every=1", "--until", 6)
        while len(stream) < 100_000:
            time.sleep(0.01)
        telemetry.send_signal(signal.SIGSTOP)
        time.sleep(2)
        telemetry.send_signal(signal.SIGCONT)
        self.finish(flight, code=None)
        report = self.close(telemetry)
        reader.join(HANG)
        xtce = Xtce((self.folder / "session.xml").read_text())
        decoded = [values for name, values in map(xtce.decode, split(bytes(stream))) if name == "State"]
        numbers, counts = [values["State.sequence"] for values in decoded], [values["ccsds_sequence_count"] for values in decoded]
        missing = numbers[-1] - numbers[0] + 1 - len(set(numbers))  # a State that is resent keeps its number
        self.assertGreater(missing, 100)
        self.assertEqual(report["states_lost"], missing)
        self.assertGreaterEqual(report["lost"], missing)
        self.assertIn("never came here", telemetry.said.read_text())
        self.assertEqual([(b - a) % 2**14 for a, b in zip(counts, counts[1:])], [1] * (len(counts) - 1))  # they were lost before

    # States that the scenario leaves out have no number.
    def test_states_that_the_scenario_leaves_out_are_not_lost(self):
        end = self.listen()
        telemetry = self.open_telemetry("--packets", f"127.0.0.1:{UDP_PORT}", "--xtce", self.folder / "session.xml")
        self.fly(until=1)
        report = self.close(telemetry)
        xtce = Xtce((self.folder / "session.xml").read_text())
        states = [values for name, values in map(xtce.decode, end()) if name == "State"]
        numbers = [values["State.sequence"] for values in states]
        self.assertGreaterEqual(states[-1]["State.tick"], 9 * len(states) - 100)  # every tenth
        self.assertEqual(report["states_lost"], numbers[-1] - numbers[0] + 1 - len(set(numbers)))

    # Clients that send nonsense, half a request, or nothing; more than are served; one that stops reading.
    def test_hostile_and_stopped_clients_hinder_nobody(self):
        end = self.listen()
        telemetry = self.open_telemetry("--packets", f"127.0.0.1:{UDP_PORT}", "--packets-tcp", f"127.0.0.1:{TCP_PORT}", "--live", f"127.0.0.1:{LIVE_PORT}")
        random = os.urandom(200_000)
        idle = [connect(port) for port in (TCP_PORT, LIVE_PORT) for _ in range(12)]
        time.sleep(0.5)
        for client in idle:
            client.close()
        crowd = [connect(port) for port in (TCP_PORT, LIVE_PORT) for _ in range(8)]
        for i, client in enumerate(crowd):
            self.addCleanup(client.close)
            client.settimeout(1)
            try:
                client.sendall((random[:64_000], b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"GET /" + b"x" * 20_000, b"")[i % 4])
            except OSError:
                pass  # it has closed the connection
        self.fly()
        report = self.close(telemetry)
        self.assertGreater(len(end()), 250)
        self.assertGreaterEqual(report["packets"]["refused"], 4)
        self.assertGreaterEqual(report["live"]["refused"], 4)
        self.assertEqual(report["malformed"], 0)

    def handshake(self, origin=None, protocol="foxglove.websocket.v1"):
        client = connect(LIVE_PORT)
        self.addCleanup(client.close)
        client.settimeout(HANG)
        client.sendall(("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" + (f"Origin: {origin}\r\n" if origin else "") +
                        f"Sec-WebSocket-Protocol: {protocol}\r\n\r\n").encode())
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += client.recv(1)
        return client, answer.decode()

    def test_the_handshake_is_that_of_the_protocol_and_pages_of_strangers_are_refused(self):
        telemetry = self.open_telemetry("--live", f"127.0.0.1:{LIVE_PORT}", "--origin", "https://ground.example")
        for origin, status in ((None, 101), ("https://app.foxglove.dev", 101), ("http://localhost:8080", 101), ("https://ground.example", 101),
                               ("https://evil.example", 403), ("http://localhost.evil.example", 403), ("http://127.0.0.1@evil.example", 403), ("null", 403)):
            client, answer = self.handshake(origin)
            self.assertTrue(answer.startswith(f"HTTP/1.1 {status} "), (origin, answer))
            if status == 101:
                self.assertIn("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=", answer)  # RFC 6455, section 1.3
                self.assertIn("Sec-WebSocket-Protocol: foxglove.websocket.v1", answer)
            client.close()
        self.assertTrue(self.handshake(protocol="chat")[1].startswith("HTTP/1.1 426 "))
        telemetry.terminate()
        self.finish(telemetry, code=None)

    def test_what_a_client_sends_ends_at_most_its_own_connection(self):
        telemetry = self.open_telemetry("--live", f"127.0.0.1:{LIVE_PORT}")
        mask = b"\0\0\0\0"

        def frame(opcode, data, length=None):
            length = len(data) if length is None else length
            head = bytes([0x80 | opcode]) + (bytes([0x80 | length]) if length < 126 else b"\xfe" + struct.pack(">H", length) if length < 65536 else b"\xff" + struct.pack(">Q", length))
            return head + mask + data
        wrong = [b"{", b"[]", b"null", b'{"op": 3}', b'{"op": "subscribe"}', b'{"op": "subscribe", "subscriptions": [1, {"id": -1, "channelId": 2}, {"id": 1e30, "channelId": {}}]}',
                 b'{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 4294967297}]}', b'{"op": "unsubscribe", "subscriptionIds": ["x", 7]}', b"[" * 60_000, b"\xff\xfe"]
        for opcode in (1, 2, 9, 3):
            for data in wrong:
                client, _ = self.handshake()
                try:
                    client.sendall(frame(opcode, data[:100] if opcode == 9 else data))
                    client.sendall(frame(1, b"x", 1 << 40))  # a length beyond any
                except OSError:
                    pass
                client.close()
        client, answer = self.handshake()
        self.assertIn(" 101 ", answer)
        self.assertIn(b'"serverInfo"', client.recv(1 << 16))
        self.assertIsNone(telemetry.poll())
        telemetry.terminate()
        self.finish(telemetry, code=None)

    @unittest.skipUnless(CHROMIUM, "needs chromium")
    def test_a_browser_receives_the_running_session_over_the_foxglove_protocol(self):
        class Page(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.end_headers()
                self.wfile.write(b"<!doctype html><title>bench</title>")

            def log_message(self, *_):
                pass
        server = http.server.ThreadingHTTPServer(("127.0.0.1", PAGE_PORT), Page)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        telemetry = self.open_telemetry("--live", f"127.0.0.1:{LIVE_PORT}")
        connect(LIVE_PORT).close()
        with Browser() as browser:
            browser.call("Page.navigate", url=f"http://127.0.0.1:{PAGE_PORT}/")
            browser.wait_for("document.readyState === 'complete' && document.title === 'bench'")
            # A client written from the protocol's specification alone.
            browser.evaluate("""(() => {
                window.seen = { info: null, topics: {}, messages: {}, last: {} };
                const socket = new WebSocket('ws://127.0.0.1:%d/', 'foxglove.websocket.v1');
                socket.binaryType = 'arraybuffer';
                const names = new Map();
                socket.onmessage = ({ data }) => {
                    if (typeof data === 'string') {
                        const message = JSON.parse(data);
                        if (message.op === 'serverInfo') seen.info = message;
                        if (message.op !== 'advertise') return;
                        const subscriptions = message.channels.map((channel) => {
                            JSON.parse(channel.schema);
                            seen.topics[channel.topic] = channel.schemaName;
                            names.set(1000 + channel.id, channel.topic);
                            return { id: 1000 + channel.id, channelId: channel.id };
                        });
                        socket.send(JSON.stringify({ op: 'subscribe', subscriptions }));
                        return;
                    }
                    const view = new DataView(data), topic = names.get(view.getUint32(1, true));
                    if (view.getUint8(0) !== 1) return;
                    const value = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 13)));
                    (seen.messages[topic] ??= []).push([Number(view.getBigUint64(5, true)), value]);
                };
            })()""" % LIVE_PORT)
            browser.wait_for("window.seen.info !== null")
            result = self.fly()
            browser.wait_for("(window.seen.messages['/bodies/satellite'] ?? []).some(([t]) => t === 3e9)")
            seen = browser.evaluate("window.seen")
            self.assertEqual(browser.complaints, [])
        self.close(telemetry)
        self.assertEqual(seen["topics"]["/tf"], "foxglove.FrameTransforms")
        recording = self.read_recording()
        bodies = seen["messages"]["/bodies/satellite"]
        self.assertGreater(len(bodies), 200)
        for time_ns, body in bodies:
            row = recording[round(time_ns / 1e6)]
            self.assertEqual([body["p"][axis] for axis in "xyz"], [float(row[f"satellite.{axis}"]) for axis in "xyz"])
            self.assertEqual(body["q"], [float(row[f"satellite.{axis}"]) for axis in ("qw", "qx", "qy", "qz")])
        for time_ns, sensor in seen["messages"]["/received/gyro1"]:
            row = recording[round(time_ns / 1e6)]
            self.assertEqual(sensor["values"], [float(row[f"received.gyro1.{axis}"]) for axis in "xyz"])
        events = [value["message"] for _, value in seen["messages"]["/events"]]
        for event in result["events"]:
            self.assertTrue(any(text.startswith(event["name"]) for text in events), event)
        transform = seen["messages"]["/tf"][-1][1]["transforms"]
        self.assertEqual([one["child_frame_id"] for one in transform], ["stage", "satellite"])
        self.assertTrue({"/health", "/joints/clamp"} <= set(seen["messages"]))


if __name__ == "__main__":
    run_tests()
