"""What tests of the scripts that compute share: a page with these scripts alone, skeletons of all kinds, poses."""

import json

import numpy as np
from conftest import ANGLES, MIXED, SKELETONS, random_tree, weighted

from skpose.view._page import asset
from skpose.view._skeleton import NUMBERS, skeleton_data

TREES = SKELETONS | {
    f"{kind} {seed}": weighted(tree, seed) if seed == 11 else tree
    for seed in (10, 11)
    for kind, kinds in {"angles": ANGLES, "mixed": MIXED, "balls": ("rotvec", "", "rotvec")}.items()
    for tree in [random_tree(seed, 14, "parent" if seed % 2 else "own", kinds)]
}
DOCUMENT = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>numbers</title></head><body><script type="module">
{scripts}
const skeletons = {{}};
const floats = (rows) => rows.map((row) => Float64Array.from(row));
const arrays = (rows) => rows.map((row) => Array.from(row));
const chart = (name, ends) => new Chart(skeletons[name], ...floats(ends));
window.numbers = {{
  add: (name, data) => {{ skeletons[name] = new Skeleton(data); }},
  positions: (name, X) => floats(X).map((x) => Array.from(skeletons[name].positions(x))),
  orientations: (name, X) => floats(X).map((x) => Array.from(skeletons[name].orientations(x))),
  between: (name, [a, b], parts) => parts.map((t) => Array.from(skeletons[name].between(...floats([a, b]), t))),
  geodesic: async (name, [a, b], options) => {{
    const {{ length, poses, converged }} = await geodesic(skeletons[name], ...floats([a, b]), options);
    return {{ length, poses: poses.map((pose) => Array.from(pose)), converged }};
  }},
  events: async (name, X) => {{
    let [events, last, longest] = [0, performance.now(), 0];
    const count = () => {{
      events++;
      longest = Math.max(longest, performance.now() - last);
      last = performance.now();
    }};
    const [timer, start] = [setInterval(count, 1), last];
    await numbers.geodesic(name, X);
    count();
    clearInterval(timer);
    return {{ events, longest, duration: performance.now() - start }};
  }},
  angles: (_, q, axes, intrinsic, near) => q.map((one, i) => rotations.toAngles(one, axes, intrinsic, near[i])),
  curve: (name, ends, X, parts) => {{
    const one = chart(name, ends);
    return curveLength(one, floats(X).map((x) => one.coordinates(x)), parts);
  }},
  energies: (name, ends, paths, substeps) => paths.map((nodes) => {{
    const path = new Path(chart(name, ends), floats(nodes), substeps);
    const positions = path.placed.map((one) => Array.from(one.positions));
    return {{ half: path.half, gradient: arrays(path.equations().gradient.slice(1, -1)), positions }};
  }}),
  matrix: (name, ends, nodes, substeps, whole) => {{
    const path = new Path(chart(name, ends), floats(nodes), substeps);
    const equations = path.equations();
    if (whole) path.addSecondDerivatives(equations);
    return {{ diagonal: arrays(equations.diagonal), between: arrays(equations.between) }};
  }},
  solved: (name, diagonal, between, gradient, branches, damping) => {{
    const equations = {{ diagonal: floats(diagonal), between: floats(between), gradient: floats(gradient) }};
    const step = solveBand(equations, branches, gradient[0].length, damping);
    return step && arrays(step);
  }},
  distances: (name, X, Y, n) => floats(X).map((x, i) => distances(skeletons[name], x, floats(Y)[i], n)),
}};
</script></body></html>
"""


class Numbers:
    """The scripts in a page: `numbers.positions(skeleton, X)` calls the function of this name."""

    def __init__(self, browser):
        self.browser = browser
        browser.open(DOCUMENT.format(scripts="\n".join(map(asset, NUMBERS))))
        assert browser.problems() == []
        self.names = {}

    def __getattr__(self, function):
        def call(skeleton, *arguments):
            if skeleton not in self.names:
                self.names[skeleton] = str(len(self.names))
                data = json.loads(json.dumps(skeleton_data(skeleton), allow_nan=False))
                self.browser.js("numbers.add(...arguments)", self.names[skeleton], data)
            plain = [one if isinstance(one, dict) else np.asarray(one).tolist() for one in arguments]
            return self.browser.js(f"numbers.{function}(...arguments)", self.names[skeleton], *plain)

        return call


def poses_of(skeleton, n, seed=0, extent=3.0):
    return np.random.default_rng(seed).uniform(-extent, extent, (n, skeleton.n_dofs))
