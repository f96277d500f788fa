"""How large is the explorer of 10,000 poses, how soon is it drawn, and how many frames a second does it draw?

    pip install "skpose[test]"
    python benchmarks/explorer.py [--cmu FOLDER] [--quick]

The motions are resampled such that there are 10,000 poses. The page is opened in Chromium without a window, on its
software renderer, 1,300 × 860 px: once in each of three new browsers, and three times more in each. Then, for some
seconds each, every frame of the display moves the view, zooms, moves the pointer to another place, plays a motion, or
does three of these at once; frame times are the differences of the time stamps of the frames, which are 1/60 s apart at
least. Last, the search for the shortest path between poses that are far apart, and the frames meanwhile.
Needs Chromium and chromedriver; without them sizes and times of Python alone are printed.
"""

import shutil
import statistics
import tempfile
import time
from pathlib import Path

import common
import numpy as np
import pages

from skpose import forward_kinematics
from skpose.datasets import MotionDataset
from skpose.view import explorer

N_POSES = 10_000
METRICS = "spatial", "position", "rotation", "angle"
FRAMES = """
const [n, what, done] = arguments, canvas = skpose.stage.canvas, stamps = [];
const box = canvas.getBoundingClientRect();
const key = (key, shiftKey) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey }));
const point = (i) => canvas.dispatchEvent(new PointerEvent("pointermove", { pointerType: "mouse",
  clientX: box.x + box.width * (0.5 + 0.4 * Math.sin(0.11 * i)),
  clientY: box.y + box.height * (0.5 + 0.4 * Math.cos(0.07 * i)) }));
const turns = {
  moving: (i) => key(i % 60 < 30 ? "ArrowRight" : "ArrowLeft", true),
  zooming: (i) => canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: i % 60 < 30 ? -60 : 60,
    clientX: box.x + 300, clientY: box.y + 300, cancelable: true })),
  hovering: point,
  playing: () => {},
  "all at once": (i) => (turns.moving(i), point(i)),
};
if (what === "playing" || what === "all at once") key("Enter");
const frame = (now) => {
  stamps.push(now);
  if (stamps.length > n) return skpose.state.playing && key(" "), done(stamps);
  turns[what](stamps.length);
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""
SEARCH = """
const [first, second, done] = arguments, canvas = skpose.stage.canvas, stamps = [];
const { state } = skpose;
const enter = (row, shiftKey) => ((state.hover = row),
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", shiftKey })));
enter(first, false);
const begin = performance.now();
enter(second, true);
const frame = (now) => {
  stamps.push(now);
  if (!state.comparison.geodesic && !state.comparison.failure) return requestAnimationFrame(frame);
  done([performance.now() - begin, stamps]);
};
requestAnimationFrame(frame);
"""


def ten_thousand(folder, n):
    """Return motions with exactly n poses at some rate, and the rate."""
    motions = common.motions(folder, 10, 10)
    duration = sum(motion.times[-1] for motion in motions)
    rate = np.ceil(n / duration)
    while sum(len(motion.resample(rate)) for motion in motions) < n:
        rate += 1
    kept, left = [], n
    for motion in motions:
        part = motion.resample(rate)[:left]
        left -= len(part)
        kept.append(part)
    return MotionDataset(kept, motions.subjects, motions.trials, motions.actions), rate


def frame_times(stamps):
    """Return the median and the 95 % point of the times between frames, ms."""
    return np.percentile(np.diff(stamps), [50, 95])


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--cmu", help="CMU files, see load_cmu; default: generated gait")
    options = arguments.parse_args()
    common.print_machine()
    dataset, rate = ten_thousand(options.cmu, 600 if options.quick else N_POSES)
    explorer(dataset[:1], frame_rate=None, metrics=METRICS)  # compile before the clock starts
    start = time.perf_counter()
    page = explorer(dataset, frame_rate=None, metrics=METRICS)
    made = time.perf_counter() - start
    X, _ = dataset.poses()
    print(
        f"{len(X):,} poses at {rate:g} Hz of {len(dataset)} motions, {X.shape[1]} numbers each; {len(METRICS)} metrics"
    )
    raw = 4 * 3 * dataset.skeleton.n_joints * len(X)
    print(f"{page.n_bytes / 1e6:.2f} MB, {page.n_bytes / raw:.2f} × the positions as float32; made in {made:.1f} s")
    print(f"of it markup, styles and scripts: {pages.bytes_without_data(page) / 1e3:.0f} kB; {page.note}")
    if not shutil.which("chromedriver"):
        print("There is no chromedriver: the page is not opened.")
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "explore.html"
        page.save(path)
        in_chromium(path.as_uri(), dataset.skeleton, X, options.quick)


def in_chromium(url, skeleton, X, quick):
    cold, warm = [], []
    for _ in range(1 if quick else 3):
        driver = pages.browser()
        driver.get("about:blank")
        cold.append(pages.start_up(driver, url))
        warm += [pages.start_up(driver, url) for _ in range(1 if quick else 3)]
        if len(cold) < (1 if quick else 3):
            driver.quit()
    driver.set_script_timeout(120)
    version = driver.capabilities["browserVersion"]
    print(f"Chromium {version}, first picture after: {statistics.median(cold):.0f} ms in a new browser, ", end="")
    print(f"{statistics.median(warm):.0f} ms ({min(warm):.0f} to {max(warm):.0f}) in one that runs\n")
    print(f"{'':<24}{'median frame, ms':>18}{'95 % of frames, ms':>20}{'frames a second':>17}")
    for what in ("moving", "zooming", "hovering", "playing", "all at once"):
        stamps = driver.execute_async_script(FRAMES, 60 if quick else 480, what)
        median, most = frame_times(stamps)
        rate = 1e3 * (len(stamps) - 1) / (stamps[-1] - stamps[0])
        print(f"{what:<24}{median:>18.1f}{most:>20.1f}{rate:>17.1f}")
    rng = np.random.default_rng(0)
    searched, stamps = [], []
    for _ in range(2 if quick else 10):
        seconds, seen = driver.execute_async_script(SEARCH, *map(int, rng.choice(len(X), 2, replace=False)))
        searched.append(seconds)
        stamps += np.diff(seen).tolist()
    median, most = np.percentile(stamps, [50, 95])
    print(
        f"\n{len(searched)} shortest paths between random poses: {statistics.median(searched):.0f} ms in the median, ",
        end="",
    )
    print(f"{max(searched):.0f} ms at most; frames meanwhile {median:.1f} ms, 95 % {most:.1f} ms")
    draws = driver.execute_script(
        "const times = []; for (let i = 0; i < 50; i++) { const t = performance.now(); skpose.stage.draw();"
        " times.push(performance.now() - t); } return times"
    )
    print(f"to draw all points: {statistics.median(draws):.1f} ms")
    shown = driver.execute_script("return skpose.poses.points(skpose.poses.pose(7))")
    up = driver.execute_script("return skpose.poses.data.up")
    expected = forward_kinematics(X[[7]], skeleton)[0][:, up["order"]] * up["signs"]
    np.testing.assert_allclose(shown[1:], expected, atol=1e-3)
    driver.quit()


if __name__ == "__main__":
    main()
