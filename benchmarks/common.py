"""What every benchmark starts from: arguments, a line about the processor, poses, timing in turns, memory."""

import argparse
import os
import platform
import re
import statistics
import time
from importlib.metadata import version
from pathlib import Path

from llvmlite import binding
from numba import config

from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait

REPEATS = 5
PAUSE = 0.1  # s, in which the threads of the contestant before, which wait for work by spinning, go to sleep
INSTRUCTION_SETS = ("avx512f", "avx2", "sve", "neon", "sse2")  # the widest first
STATUS = Path("/proc/self/status")


def parser(doc, *, folder=True):
    """Arguments of every benchmark: a folder of CMU files where it takes poses, and `--quick`."""
    arguments = argparse.ArgumentParser(description=doc.splitlines()[0])
    if folder:
        arguments.add_argument("folder", nargs="?", help="CMU files, see load_cmu; default: generated gait")
    arguments.add_argument("--quick", action="store_true", help="check the answers in seconds; times mean nothing")
    return arguments


def parser_of_both(doc):
    """Arguments of a benchmark of both CMU and HDM05."""
    arguments = parser(doc, folder=False)
    arguments.add_argument("--cmu", help="CMU files, see load_cmu")
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05")
    return arguments


def start(doc):
    """Parse the arguments of a benchmark without others, and print the machine."""
    options = parser(doc).parse_args()
    print_machine()
    return options


def print_machine():
    """Print processor, instruction set, and versions: what the figures depend on."""
    features = binding.get_host_cpu_features()
    widest = next((name for name in INSTRUCTION_SETS if features.get(name)), "no vectors")
    if config.CPU_NAME:  # by NUMBA_CPU_NAME; "haswell" has AVX2 and no AVX-512
        widest += f", compiled for {config.CPU_NAME}"
    versions = ", ".join(f"{name} {version(name)}" for name in ("numba", "numpy", "scipy", "scikit-learn"))
    print(f"{processor()}, {widest}, {os.cpu_count()} cores; Python {platform.python_version()}, {versions}")


def processor():
    """Return the processor's name, where the operating system has one, and its model, as names may say little."""
    cpuinfo = Path("/proc/cpuinfo")
    text = cpuinfo.read_text() if cpuinfo.exists() else ""
    name, model = re.search(r"model name\s*: (.+)", text), re.search(r"model\s*: (\d+)", text)
    if name and model:
        return f"{name[1]}, model {model[1]}"
    return platform.processor() or platform.machine()


def motions(folder, n_subjects=10, n_sequences=10):
    """Return the CMU motions of a folder, or generated gait without one."""
    if folder:
        return load_cmu(folder, rotations="file")
    return make_gait(n_subjects, n_sequences, rotations="file", random_state=0)


def resampled(dataset, rate):
    """The dataset at another frame rate."""
    motions = [motion.resample(rate) for motion in dataset]
    return MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions, rotations="file")


def datasets(options):
    """Return the collections of motions of a benchmark of both CMU and HDM05, by name; else generated gait."""
    loads = {"CMU": (load_cmu, options.cmu), "HDM05": (load_hdm05, options.hdm05)}
    found = {name: load(folder, rotations="file") for name, (load, folder) in loads.items() if folder}
    return found or {"gait": make_gait(5, 2, rotations="file", random_state=0)}


def medians(contestants, repeats=REPEATS, clock=time.perf_counter):
    """Median seconds of each function, all of them taking turns."""
    for function in contestants.values():
        function()
    seconds = {name: [] for name in contestants}
    for _ in range(repeats):
        for name, function in contestants.items():
            time.sleep(PAUSE)
            start = clock()
            function()
            seconds[name].append(clock() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}


def memory(name):
    """Memory of this process, MB: resident (VmRSS), at most resident (VmHWM), reserved (VmSize); Linux only."""
    return int(re.search(rf"{name}:\s+(\d+) kB", STATUS.read_text())[1]) / 1e3


def forget_peak_memory():
    """Make VmHWM start again from what is resident now; Linux only."""
    Path("/proc/self/clear_refs").write_text("5")
