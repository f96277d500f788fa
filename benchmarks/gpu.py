"""How fast are distances of torch's arrays on a GPU, against the compiled kernels on all cores of the processor?

    python benchmarks/gpu.py [--gradients] [--cpu] [--quick]

Random poses of 22 ball joints (48 dofs), float32, ten steps: pairs per second of each metric, "spatial" also with
`torch.compile` and with gradients, and poses per second of the forward kinematics. First the largest difference of
distances and positions to the compiled kernels in float64 is printed, at the end also those of CuPy and JAX where they
are installed. Without torch nothing is measured.
"""

import importlib
import os
import time
from functools import partial

import common
import numpy as np
from sklearn import config_context

from skpose import Skeleton, forward_kinematics, pose_distances
from skpose.datasets import humanoid

METRICS = ("position", "rotation", "spatial")
os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")  # JAX would take most of the memory
WHOLE = 2.0**20  # MiB: no tiles
REPEATS = 3


def random_poses(skeleton, n, seed):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (n, skeleton.n_dofs)).astype(np.float32)


def largest_differences(arrays, numpy, skeleton, n):
    """Print the largest differences to the compiled kernels, given functions from and to numpy's arrays."""
    X, Y = (random_poses(skeleton, n, seed) for seed in (0, 1))
    A, B, double = arrays(X), arrays(Y), (X.astype(float), Y.astype(float))
    pairs = {"positions": (forward_kinematics(A, skeleton), forward_kinematics(double[0], skeleton))}
    for metric in METRICS:
        D = pose_distances(A, B, skeleton=skeleton, metric=metric)
        pairs[metric] = D, pose_distances(*double, skeleton=skeleton, metric=metric)
    for name, (found, expected) in pairs.items():
        difference = np.abs(numpy(found) - expected).max()
        assert difference < 1e-5, name
        print(f"  {name:<12}{difference:.1e} m, of values up to {np.abs(expected).max():.1f} m", flush=True)


def report(name, count, functions, seconds_to_compile=None):
    """Print how many a second each function does."""
    medians = common.medians(functions, REPEATS)
    for how, seconds in medians.items():
        compiled = f"   compiled in {seconds_to_compile:.0f} s" if seconds_to_compile is not None else ""
        print(f"{name:<24}{how:<24}{count / seconds:>16,.0f}/s{compiled}", flush=True)


def first_call(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def main():
    options = common.parser(__doc__, folder=False)
    options.add_argument("--cpu", action="store_true", help="torch on the processor, with fewer poses")
    options.add_argument("--gradients", action="store_true", help="also compile gradients, which may take minutes")
    options = options.parse_args()
    common.print_machine()
    try:
        import torch
    except ImportError:
        print("torch is not installed")
        return
    on_gpu = torch.cuda.is_available() and not options.cpu
    device = torch.device("cuda" if on_gpu else "cpu")
    print(f"torch {torch.__version__} on {torch.cuda.get_device_name() if on_gpu else 'the processor'}")
    small = options.quick or not on_gpu
    skeleton = Skeleton.chain(2).to_rotvec() if options.quick else humanoid().to_rotvec()
    backend = "aot_eager" if options.quick else "inductor"
    # Poses of the compiled kernels, of tiles, of gradients, and of forward kinematics.
    n_kernels, n_eager, n_tile, n_slopes, n_forward = (50, 60, 60, 20, 500) if small else (2000, 4096, 1024, 512, 10**6)

    def arrays(X):
        return torch.asarray(X, device=device)

    def synchronized(function):
        def call():
            function()
            if on_gpu:
                torch.cuda.synchronize()

        return call

    print(f"{skeleton}, float32; largest differences to the compiled kernels")
    largest_differences(arrays, lambda X: X.cpu().numpy(), skeleton, 20 if small else 300)
    print()

    X, Y = (random_poses(skeleton, n_kernels, seed) for seed in (0, 1))
    for metric in METRICS:
        kernels = partial(pose_distances, X, Y, skeleton=skeleton, metric=metric, n_jobs=-1)
        report(f"{metric}, pairs", len(X) * len(Y), {"kernels, all cores": kernels})
    many = random_poses(skeleton, n_forward, 0)
    kinematics = partial(forward_kinematics, many, skeleton, n_jobs=-1)
    report("forward, poses", n_forward, {"kernels, all cores": kinematics})

    A, B = (arrays(random_poses(skeleton, n_eager, seed)) for seed in (0, 1))
    for metric in METRICS:
        eager = synchronized(partial(pose_distances, A, B, skeleton=skeleton, metric=metric))
        report(f"{metric}, pairs", n_eager**2, {"eager, tiles": eager})
    F = arrays(many)
    report("forward, poses", n_forward, {"eager": synchronized(lambda: forward_kinematics(F, skeleton))})

    def distances(A, B):
        return pose_distances(A, B, skeleton=skeleton, metric="spatial")

    def slope(function, A, B):
        A = A.detach().requires_grad_()
        return torch.autograd.grad(function(A, B).sum(), A)[0]

    G, H, S, T = A[:n_tile], B[:n_tile], A[:n_slopes], B[:n_slopes]
    with config_context(working_memory=WHOLE):
        eager = synchronized(partial(slope, distances, S, T))
        report("spatial, pairs", n_slopes**2, {"eager, with gradients": eager})
        kinematics = torch.compile(lambda X: forward_kinematics(X, skeleton), backend=backend)
        call = synchronized(lambda: kinematics(F))
        report("forward, poses", n_forward, {"torch.compile": call}, first_call(call))
        compiled = torch.compile(distances, backend=backend)
        call = synchronized(partial(compiled, G, H))
        report("spatial, pairs", n_tile**2, {"torch.compile": call}, first_call(call))
        difference = (compiled(G, H) - distances(G, H)).abs().max().item()
        print(f"largest difference of compiled and eager distances {difference:.1e} m", flush=True)
        if options.gradients or options.quick:
            call = synchronized(partial(slope, compiled, S, T))
            report("spatial, pairs", n_slopes**2, {"torch.compile, gradients": call}, first_call(call))
        if on_gpu:
            print(f"largest memory {torch.cuda.max_memory_allocated() / 1e9:.1f} GB")
    for name, numpy in {"cupy": lambda X: X.get(), "jax.numpy": np.asarray}.items():
        try:
            library = importlib.import_module(name)
        except ImportError:
            continue
        print(f"largest differences of {name}")
        largest_differences(library.asarray, numpy, skeleton, 20)


if __name__ == "__main__":
    main()
