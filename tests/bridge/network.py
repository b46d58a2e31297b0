"""Two hosts on a separate network, made of namespaces: a cable that can be unplugged, or a line that loses, delays, reorders
and duplicates frames. The namespaces end with the processes that hold them, so that nothing remains."""
import ctypes
import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import threading
import time

CLONE_NEWNET = 0x40000000
TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
ADDRESSES = {"sim": "10.77.0.1", "fsw": "10.77.0.2"}


def ip(prefix, line):
    subprocess.run([*prefix, "ip", *line.split()], check=True)


class Host:
    """A network namespace; all traffic in it uses `interface`."""

    def __init__(self, name):
        self.name, self.interface = name, f"{name}0"
        self.holder = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo; exec sleep 1000"], stdout=subprocess.PIPE)
        self.holder.stdout.read(1)  # it is there
        self.inside = ["nsenter", "-t", str(self.holder.pid), "-n"]

    def configure(self):
        ip(self.inside, f"addr add {ADDRESSES[self.name]}/24 dev {self.interface}")
        ip(self.inside, "link set lo up")
        self.up()

    def up(self):
        ip(self.inside, f"link set {self.interface} up")
        ip(self.inside, f"route replace 224.0.0.0/4 dev {self.interface}")  # removed when the link goes down

    def down(self):
        ip(self.inside, f"link set {self.interface} down")

    def open_tap(self):
        """The interface as a file of Ethernet frames."""
        libc = ctypes.CDLL(None, use_errno=True)
        with open("/proc/self/ns/net") as ours, open(f"/proc/{self.holder.pid}/ns/net") as theirs:
            if libc.setns(theirs.fileno(), CLONE_NEWNET) != 0:
                raise OSError(ctypes.get_errno(), "setns")
            try:
                tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
                fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH", self.interface.encode(), IFF_TAP | IFF_NO_PI))
            finally:
                libc.setns(ours.fileno(), CLONE_NEWNET)
        return tap

    def close(self):
        self.holder.kill()
        self.holder.wait()
        self.holder.stdout.close()


class Cable:
    """Two hosts joined by a veth pair."""

    def __init__(self):
        self.hosts = [Host("sim"), Host("fsw")]
        first, second = self.hosts
        ip(first.inside, f"link add {first.interface} type veth peer name {second.interface} netns {second.holder.pid}")
        for host in self.hosts:
            host.configure()

    def close(self):
        for host in self.hosts:
            host.close()


class BadLine(threading.Thread):
    """Two hosts joined by this thread, which forwards frames with the configured faults."""

    def __init__(self, seed, loss, duplicates, delay_s):
        super().__init__()
        self.hosts = [Host("sim"), Host("fsw")]
        self.taps = [host.open_tap() for host in self.hosts]
        for host in self.hosts:
            host.configure()
        self.random = random.Random(seed)
        self.loss, self.duplicates, self.delay_s = loss, duplicates, delay_s
        self.stopping = False
        self.forwarded = self.lost = self.doubled = self.overtaken = 0
        self.start()

    def run(self):
        waiting = []  # (when, number, to, frame): each frame has its own delay, so that frames overtake one another
        number = latest = 0
        while not self.stopping:
            patience = max(0, min(0.05, waiting[0][0] - time.monotonic())) if waiting else 0.05
            for tap in select.select(self.taps, [], [], patience)[0]:
                frame = os.read(tap, 65536)
                to = self.taps[1 - self.taps.index(tap)]
                copies = 0 if self.random.random() < self.loss else 2 if self.random.random() < self.duplicates else 1
                self.lost += copies == 0
                self.doubled += copies == 2
                for _ in range(copies):
                    number += 1
                    when = time.monotonic() + self.random.uniform(0, self.delay_s)
                    heapq.heappush(waiting, (when, number, to, frame))
            while waiting and waiting[0][0] <= time.monotonic():
                _, sent, to, frame = heapq.heappop(waiting)
                self.overtaken += sent < latest
                latest = max(latest, sent)
                self.forwarded += 1
                try:
                    os.write(to, frame)
                except OSError:
                    pass  # its interface is down

    def close(self):
        self.stopping = True
        self.join()
        for tap in self.taps:
            os.close(tap)
        for host in self.hosts:
            host.close()
