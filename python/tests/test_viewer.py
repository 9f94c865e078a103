"""The page that plays a run, in headless Chromium."""

import re
import shutil
import subprocess

import numpy as np
import pullback as pb
import pytest
from test_studies import PENDULUM

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars"]


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_it_plays(tmp_path):
    pb.Model.from_toml(PENDULUM + "[units]\ntime = 's'\n").write(tmp_path / "out")
    page = (tmp_path / "out" / "deformed.html").as_uri()

    def browser(address, *flags):
        command = [CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", *flags, address]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)

    def seen(address):
        """Button and time after some seconds, of which the browser shows what it can."""
        found = browser(address, "--enable-logging=stderr", "--virtual-time-budget=5000", "--dump-dom")
        assert "Uncaught" not in found.stderr
        texts = re.search(r'<button id="play">(\w+)<.*<output id="time">time \[s\] = ([\d.]+)<', found.stdout, re.S)
        return texts[1], float(texts[2])

    playing, time = seen(page)
    assert playing == "Pause" and 0 < time < 1
    assert seen(f"{page}#t=0.5") == ("Play", 0.5)

    image = tmp_path / "picture.png"
    browser(f"{page}#t=0.5", "--virtual-time-budget=2000", "--window-size=800,600", f"--screenshot={image}")
    pixels = pytest.importorskip("matplotlib.image").imread(image)
    assert pixels.shape[:2] == (600, 800)
    # The orange box of the body.
    red, green, blue = (pixels[..., k] for k in range(3))
    assert np.count_nonzero((red > 2 * blue) & (red > 1.2 * green)) > 100
