"""How large is the player of a minute of motion, how much does rounding move the joints, and how soon is it drawn?

    pip install "skpose[test]"
    python benchmarks/player.py [--cmu FOLDER] [--quick]

A minute at 30 Hz: walks and runs of one person one after another where no recording is that long. The page is opened in
Chromium without a window, from a file: once in each of five new browsers, and nine times more in each. The medians are
of the time from the start of navigation to the first picture, by the browser's own clock.
Needs Chromium and chromedriver; without them the size alone is printed.
"""

import shutil
import statistics
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import common
import numpy as np
import pages

from skpose import Motion, forward_kinematics
from skpose.skeleton._root import root_orientations
from skpose.view import player
from skpose.view._pack import unpack
from skpose.view._scene import motion_data

RATE, SECONDS = 30.0, 60.0


def minute(folder, seconds):
    """Return the longest recording at 30 Hz, joined with others of its skeleton as needed, and how many they are."""
    motions = [motion.resample(RATE) for motion in common.motions(folder, 2, 20)]
    first = max(motions, key=len)
    joined, n = [first], int(seconds * RATE)
    for motion in motions:
        if sum(map(len, joined)) >= n:
            break
        if motion is not first and motion.skeleton == first.skeleton:
            shift = joined[-1].root_positions[-1] - motion.root_positions[0]
            joined.append(replace(motion, root_positions=motion.root_positions + shift))
    while sum(map(len, joined)) < n:  # too few of one person: once more from the start
        joined += joined
    return Motion.concatenate(joined)[:n], len(joined)


def check(motion):
    """Compare the positions in the page with forward kinematics."""
    data = motion_data(motion, "")
    found = unpack(data["joints"]).reshape(len(motion), -1, 3)
    turned = root_orientations(motion.root_angles, motion.root_axes).as_matrix()
    expected = np.einsum("fij,fkj->fki", turned, forward_kinematics(motion.angles, motion.skeleton))
    np.testing.assert_allclose(
        found, expected[..., {"x": [2, 0, 1], "y": [0, 1, 2], "z": [1, 2, 0]}[motion.up]], atol=1e-4
    )
    return data["error"]


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--cmu", help="CMU files, see load_cmu; default: generated gait")
    options = arguments.parse_args()
    common.print_machine()
    motion, n_recordings = minute(options.cmu, 4.0 if options.quick else SECONDS)
    error = check(motion)
    start = time.perf_counter()
    page = player(motion, labels=["a minute"])
    made = time.perf_counter() - start
    print(
        f"{len(motion)} frames at {motion.frame_rate:g} Hz of {n_recordings} recordings, "
        f"{motion.skeleton.n_joints} joints"
    )
    raw = 12 * motion.skeleton.n_joints * len(motion)
    print(f"{page.n_bytes / 1e3:.0f} kB, {page.n_bytes / raw:.2f} × the positions as float32; written in {made:.2f} s")
    markup = pages.bytes_without_data(page)
    print(f"of it markup, styles and scripts: {markup / 1e3:.0f} kB; largest error of a joint: {error:.3f} mm")
    if not shutil.which("chromedriver"):
        print("There is no chromedriver: start-up is not measured.")
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "view.html"
        page.save(path)
        n = 2 if options.quick else 9
        cold, warm = [], []
        for _ in range(2 if options.quick else 5):
            driver = pages.browser()
            driver.get("about:blank")
            cold.append(pages.start_up(driver, path.as_uri()))
            warm += [pages.start_up(driver, path.as_uri()) for _ in range(n)]
            version = driver.capabilities["browserVersion"]
            driver.quit()
    print(f"Chromium {version}, first picture after: {statistics.median(cold):.0f} ms in a new browser, ", end="")
    print(f"{statistics.median(warm):.0f} ms ({min(warm):.0f} to {max(warm):.0f}) in one that runs")


if __name__ == "__main__":
    main()
