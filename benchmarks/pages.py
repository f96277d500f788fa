"""How large are the pages, how soon are they drawn in Chromium, and how many frames a second does the explorer draw?

    pip install "skpose[test]"
    python benchmarks/pages.py [--cmu FOLDER] [--quick]

The player shows a minute of motion at 30 Hz, the explorer 10,000 poses. Times are from the start of navigation to the
first picture, by the browser's clock: in a new browser and in one that runs. Frame times of the explorer are
differences of the time stamps of frames while the view moves, zooms, follows the pointer and plays. Without Chromium
and chromedriver only sizes are printed.
"""

import os
import re
import shutil
import statistics
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import common
import numpy as np

from skpose import Motion
from skpose.view import explorer, player

RATE, SECONDS, N_POSES = 30.0, 60.0, 10_000
MARK = "performance.getEntriesByName('skpose: first frame drawn')[0]?.startTime"
FRAMES = """
const [n, what, done] = arguments, canvas = skpose.stage.canvas, stamps = [];
const box = canvas.getBoundingClientRect();
const key = (key, shiftKey) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey }));
const turns = {
  moving: (i) => key(i % 60 < 30 ? "ArrowRight" : "ArrowLeft", true),
  zooming: (i) => canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: i % 60 < 30 ? -60 : 60,
    clientX: box.x + 300, clientY: box.y + 300, cancelable: true })),
  hovering: (i) => canvas.dispatchEvent(new PointerEvent("pointermove", { pointerType: "mouse",
    clientX: box.x + box.width * (0.5 + 0.4 * Math.sin(0.11 * i)),
    clientY: box.y + box.height * (0.5 + 0.4 * Math.cos(0.07 * i)) })),
  playing: () => {},
};
if (what === "playing") key("Enter");
const frame = (now) => {
  stamps.push(now);
  if (stamps.length > n) return skpose.state.playing && key(" "), done(stamps);
  turns[what](stamps.length);
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


def browser():
    from selenium.webdriver import Chrome, ChromeOptions, ChromeService

    options = ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome")
    root = ["--no-sandbox"] if os.geteuid() == 0 else []
    for argument in ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=1300,860", *root]:
        options.add_argument(argument)
    driver = Chrome(options, ChromeService(shutil.which("chromedriver")))
    driver.set_script_timeout(120)
    return driver


def start_up(driver, url):
    """Milliseconds from the start of navigation to the first picture."""
    driver.get("about:blank")
    driver.get(url)
    while (drawn := driver.execute_script(f"return {MARK}")) is None:
        time.sleep(0.01)
    return drawn


def minute(motions):
    """A minute of one person, recordings one after another."""
    motions = [motion.resample(RATE) for motion in motions]
    first, n = max(motions, key=len), int(SECONDS * RATE)
    joined = [first]
    for motion in motions * n:
        if sum(map(len, joined)) >= n:
            break
        if motion.skeleton == first.skeleton:
            shift = joined[-1].root_positions[-1] - motion.root_positions[0]
            joined.append(replace(motion, root_positions=motion.root_positions + shift))
    return Motion.concatenate(joined)[:n]


def size_of(name, page, seconds):
    """Print the size of a page, and of what is not data."""
    markup = page.n_bytes - len(re.search(r'id="data">([^<]*)<', page.html)[1].encode())
    print(f"{name}: {page.n_bytes / 1e3:.0f} kB, {markup / 1e3:.0f} kB without data, written in {seconds:.1f} s")


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--cmu", help="CMU files, see load_cmu; default: generated gait")
    options = arguments.parse_args()
    common.print_machine()
    dataset = common.motions(options.cmu, 3, 5)
    rate = np.ceil((600 if options.quick else N_POSES) / sum(motion.times[-1] for motion in dataset))
    dataset = common.resampled(dataset, rate)
    explorer(dataset[:1], frame_rate=None)  # compiles
    pages = {}
    makers = {"player": lambda: player(minute(list(dataset))), "explorer": lambda: explorer(dataset, frame_rate=None)}
    for name, make in makers.items():
        start = time.perf_counter()
        pages[name] = make()
        size_of(name, pages[name], time.perf_counter() - start)
    if not shutil.which("chromedriver"):
        print("chromedriver is not installed: the pages are not opened")
        return
    repeats, n_frames = (1, 30) if options.quick else (5, 480)
    with tempfile.TemporaryDirectory() as folder:
        for name, page in pages.items():
            path = Path(folder) / f"{name}.html"
            page.save(path)
            cold, warm = [], []
            for _ in range(repeats):
                driver = browser()
                cold.append(start_up(driver, path.as_uri()))
                warm += [start_up(driver, path.as_uri()) for _ in range(repeats)]
                if name == "explorer" and len(cold) == repeats:
                    frames(driver, n_frames)
                driver.quit()
            print(f"{name}: first picture after {statistics.median(cold):.0f} ms in a new browser, ", end="")
            print(f"{statistics.median(warm):.0f} ms in one that runs")


def frames(driver, n):
    """Print frame times of the explorer."""
    for what in ("moving", "zooming", "hovering", "playing"):
        stamps = driver.execute_async_script(FRAMES, n, what)
        median, most = np.percentile(np.diff(stamps), [50, 95])
        rate = 1e3 * (len(stamps) - 1) / (stamps[-1] - stamps[0])
        print(f"explorer, {what}: {median:.1f} ms a frame, 95 % within {most:.1f} ms, {rate:.1f} frames a second")


if __name__ == "__main__":
    main()
