#!/usr/bin/python3
"""Uses a page of `forefeel show` with a real mouse, through Chromium's DevTools, and prints what it found as JSON.
Exit 77 where Chromium is absent or draws no WebGL. usage: use_page.py PAGE.html"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time


class Browser:
    """Chromium without a window; messages go through two pipes, each ended by a zero byte."""

    def __init__(self, page, profile):
        to_read, self.to = os.pipe()
        self.back, back_write = os.pipe()
        # Chromium reads from descriptor 3 and writes to 4.
        high = [os.dup(to_read), os.dup(back_write)]
        shell = f"exec {shutil.which('chromium')} --headless --no-sandbox --use-angle=swiftshader " \
            "--enable-unsafe-swiftshader --window-size=1200,800 --remote-debugging-pipe " \
            f"--user-data-dir={profile} about:blank 3<&{high[0]} 4>&{high[1]}"
        self.process = subprocess.Popen(["bash", "-c", shell], pass_fds=high, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL, start_new_session=True)
        for descriptor in (to_read, back_write, *high):
            os.close(descriptor)
        self.number, self.buffer, self.session = 0, b"", None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.ask("Page.navigate", url=pathlib.Path(page).resolve().as_uri())
        while not self.value("location.protocol === 'file:' && document.readyState === 'complete'"):
            time.sleep(0.05)

    def ask(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.buffer:
                more = os.read(self.back, 1 << 16)
                if not more:
                    sys.exit("chromium ended")
                self.buffer += more
            text, self.buffer = self.buffer.split(b"\0", 1)
            answer = json.loads(text)
            if answer.get("id") == self.number:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]

    def value(self, expression):
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            sys.exit(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def mouse(self, kind, at, **more):
        self.ask("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], **more)

    def drag(self, start, end, steps=8):
        self.mouse("mouseMoved", start)
        self.mouse("mousePressed", start, button="left", buttons=1, clickCount=1)
        for i in range(1, steps + 1):
            at = [a + (b - a) * i / steps for a, b in zip(start, end)]
            self.mouse("mouseMoved", at, button="left", buttons=1)
        self.mouse("mouseReleased", end, button="left", clickCount=1)

    def place(self, element, across=0.5):
        """Where an element is on the screen."""
        return self.value(f"(() => {{ const r = document.getElementById('{element}').getBoundingClientRect();"
                          f"return [r.left + {across} * r.width, r.top + r.height / 2]; }})()")


def use(browser):
    if browser.value("getComputedStyle(document.getElementById('failure')).display") != "none":
        sys.exit(77)
    found = {}
    camera = "camera.position.toArray()"
    moved = "Math.max(...Array.from(bodyGeometry.attributes.position.array, (v, i) => Math.abs(v - scene.body.nodes[i])))"
    found["target"] = browser.value("controls.target.toArray()")
    found["before"] = {"camera": browser.value(camera), "moved": browser.value(moved), "now": browser.value("now")}
    browser.drag([700, 250], [800, 300])
    found["turned"] = browser.value(camera)
    browser.mouse("mouseWheel", [700, 250], deltaX=0, deltaY=400)
    found["zoomed"] = browser.value(camera)
    browser.drag(browser.place("clock", 0.01), browser.place("clock", 0.5))
    found["later"] = {"moved": browser.value(moved), "now": browser.value("now"),
                      "text": browser.value("document.getElementById('now').textContent")}
    found["tip"] = None
    for x in range(300, 1150, 25):
        for y in range(60, 640, 25):
            if found["tip"] is None and browser.value(f"readOff({x}, {y}) || ''").startswith("node"):
                browser.mouse("mouseMoved", [x, y])
                browser.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
                found["tip"] = browser.value("tip.style.display === 'block' ? tip.textContent : ''")
    edges = "layers.edges.visible"
    found["edges"] = [browser.value(edges)]
    at = browser.place("layer-edges")
    browser.mouse("mousePressed", at, button="left", buttons=1, clickCount=1)
    browser.mouse("mouseReleased", at, button="left", clickCount=1)
    found["edges"].append(browser.value(edges))
    return found


if not shutil.which("chromium"):
    sys.exit(77)
with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:   # its helpers may write until they are dead
    opened = Browser(sys.argv[1], folder)
    try:
        result = use(opened)
    finally:
        os.killpg(opened.process.pid, signal.SIGKILL)
        opened.process.wait()
print(json.dumps(result))
