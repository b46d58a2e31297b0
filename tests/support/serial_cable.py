"""A serial cable between two programs: two pseudo-terminals whose masters are joined by a thread, which may disturb what passes."""
import os
import select
import threading
import tty


class SerialCable:
    def __init__(self, disturb=None):
        """`disturb(bytes)`: what arrives instead."""
        self.masters, self.ends = [], []
        self.slaves = []  # held open, so that an end that closes is no hang-up
        for _ in range(2):
            master, slave = os.openpty()
            tty.setraw(slave)
            self.masters.append(master)
            self.slaves.append(slave)
            self.ends.append(os.ttyname(slave))
        self.disturb = disturb or (lambda data: data)
        self.carried = 0
        self.stop_read, self.stop_write = os.pipe()
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    def carry(self):
        while True:
            ready = select.select([*self.masters, self.stop_read], [], [])[0]
            if self.stop_read in ready:
                return
            for master in ready:
                data = os.read(master, 4096)
                self.carried += len(data)
                data = self.disturb(data)
                other = self.masters[1 - self.masters.index(master)]
                while data:
                    data = data[os.write(other, data):]

    def close(self):
        os.write(self.stop_write, b"x")
        self.thread.join()
        for file in (*self.masters, *self.slaves, self.stop_read, self.stop_write):
            os.close(file)
