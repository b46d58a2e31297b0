"""A headless Chromium on a pipe: the DevTools protocol over two file descriptors, so no port is opened and no library
is needed. Messages are JSON, each ended by a zero byte."""

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

CHROMIUM = shutil.which("chromium")
# Software WebGL, and all other drawing without it, which is ten times as fast; no sandbox, because tests may run as root in a
# container; no access to the network.
FLAGS = [
    "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe",
    "--disable-accelerated-2d-canvas", "--disable-gpu-rasterization", "--disable-gpu-compositing",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic",
    "--disable-default-apps", "--disable-extensions", "--hide-scrollbars", "--force-color-profile=srgb",
    "--disable-dev-shm-usage", "--metrics-recording-only", "--no-default-browser-check",
    "--disable-features=Translate,OptimizationHints,MediaRouter,DialMediaRouteProvider",
]
READ_BACK = "GPU stall due to ReadPixels"  # a cost of drawing WebGL in software, not of the page
HANG = 240  # s; far longer than any step here, also where other tests keep both processors busy


class BrowserError(Exception):
    pass


class Browser:
    def __init__(self, width=1600, height=1000, flags=()):
        self.profile = tempfile.mkdtemp(prefix="unlatch_chromium_")
        to_read, self.to_browser = os.pipe()
        self.from_browser, to_write = os.pipe()

        # Chromium expects them as 3 and 4; these numbers may already be in use, so both ends are moved first.
        def place():
            high = [os.dup(fd) for fd in (to_read, to_write)]
            high = [os.dup(fd) if fd in (3, 4) else fd for fd in high]
            high = [os.dup(fd) if fd in (3, 4) else fd for fd in high]
            for fd, number in zip(high, (3, 4)):
                os.dup2(fd, number, inheritable=True)

        self.process = subprocess.Popen(
            [CHROMIUM, *FLAGS, *flags, f"--user-data-dir={self.profile}", f"--window-size={width},{height}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=False, preexec_fn=place,
            start_new_session=True)
        os.close(to_read)
        os.close(to_write)
        self.buffer, self.number, self.complaints, self.requests, self.session = b"", 0, [], [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def close(self):
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.to_browser)
        os.close(self.from_browser)
        shutil.rmtree(self.profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def receive(self):
        while b"\0" not in self.buffer:
            if not select.select([self.from_browser], [], [], HANG)[0]:
                raise BrowserError("the browser says nothing")
            data = os.read(self.from_browser, 1 << 20)
            if not data:
                raise BrowserError("the browser has gone")
            self.buffer += data
        text, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(text)
        self.note(message)
        return message

    def note(self, message):
        """Handles events of a page: errors, and its requests."""
        method, params = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(part.get("value", part.get("description"))) for part in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            if READ_BACK not in params["entry"]["text"]:
                self.complaints.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])

    def call(self, method, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to_browser, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise BrowserError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def open(self, path):
        self.complaints.clear()
        self.requests.clear()
        self.call("Page.navigate", url=path.resolve().as_uri())
        self.wait_for("document.readyState === 'complete' && (window.unlatchReport !== undefined || document.querySelector('.banner'))")

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise BrowserError(details.get("exception", {}).get("description") or details["text"])
        return result["result"].get("value")

    def wait_for(self, expression):
        until = time.monotonic() + HANG
        while time.monotonic() < until:
            if self.evaluate(expression):
                return
            time.sleep(0.02)
        raise BrowserError(f"never true: {expression}")

    def settle(self):
        """Waits until the requested changes have been drawn."""
        self.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    def press(self, key, shift=False):
        names = {" ": ("Space", 32), "ArrowRight": ("ArrowRight", 39), "ArrowLeft": ("ArrowLeft", 37), "Home": ("Home", 36), "End": ("End", 35)}
        code, number = names[key]
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, modifiers=8 if shift else 0)

    def click(self, selector, x=0.5, y=0.5):
        """Clicks at a fraction of the element's width and height."""
        box = self.evaluate(f"(() => {{ const node = document.querySelector({json.dumps(selector)}); node.scrollIntoView({{block: 'center'}});"
                            " const r = node.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()")
        at = {"x": box[0] + x * box[2], "y": box[1] + y * box[3], "button": "left", "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=at["x"], y=at["y"])
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, **at)

    # Plots of the pages of studies (tools/pages/web/plot.js).

    def find_layers(self, place, name):
        """Returns the layers of this name of the plot there."""
        return self.evaluate(f"unlatchReport.plots['{place}'].layers.filter((layer) => layer.name === '{name}')")

    def click_point(self, place, x, y):
        """Clicks at a point of a plot, given in units of its axes."""
        left, top = self.evaluate(f"(() => {{ const plot = unlatchReport.plots['{place}'], box = plot.over.getBoundingClientRect();"
                                  f" return [plot.valToPos({x}, 'x') / box.width, plot.valToPos({y}, 'y') / box.height]; }})()")
        self.click(f"#{place} .u-over", left, top)

    def count_pixels(self, place):
        """Returns how many pixels of a plot have a colour of its own, neither grey nor transparent."""
        self.settle()
        return self.evaluate(f"(() => {{ const canvas = document.querySelector('#{place} canvas'), context = canvas.getContext('2d');"
                             " const { data } = context.getImageData(0, 0, canvas.width, canvas.height); let count = 0;"
                             " for (let i = 0; i < data.length; i += 4)"
                             " if (data[i + 3] > 100 && Math.abs(data[i] - data[i + 2]) > 60) ++count; return count; })()")

    def screenshot(self, path):
        self.settle()
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))
