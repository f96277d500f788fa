"""Do two sets of poses differ? Level and power of `two_sample_test` on recordings of people.

    python benchmarks/two_samples.py --cmu FOLDER_OF_CMU_FILES --hdm05 FOLDER_OF_HDM05_FILES [--quick]

All motions are on ball joints, at 12 Hz, on the mean skeleton of their database; recordings are permuted whole. A test
rejects at p ≤ 0.05. There are two statistics, and four metrics; "geodesic", of milliseconds a pair, has part in the
first table alone, at 1 Hz. Without folders the study runs on generated gait.

1. Named comparisons of CMU. Subject 35 has 23 walks and 10 runs, the four others 5 walks (two on uneven terrain) among
   them, so that this is one person against others. "odd, even" and "first, last" split the recordings of one person, by
   their order: a true null only if the person does not change from recording to recording.
2. One action of HDM05 by two of its three people, all 11 actions and 3 pairs; and one action by one person, odd against
   even, all 33. Counted are the tests whose least possible p is at most 0.05. Cuts of one take may be among the
   recordings, as HDM05 has them.
3. Level: ten recordings of one person and one action, drawn at random, and split at random into five and five: a true
   null by construction. The same frames permuted one by one show what that does: recordings whose frames are nearer to
   one another than to others' give far too small p, and whole cycles of a periodic motion too large ones, as they have
   each phase equally often, where frames drawn at random do not.
4. Power: n squats of one person of HDM05 against n of another, drawn at random; and n against n of which only half are
   of another person, the rest of the first one (no recording twice). With n = 3 no p is below 0.1.

A share of 200 draws has a standard error of 3.5 % at most, at a level of 5 % one of 1.5 %. The draws share recordings,
so that they say what happens to these people, not to others: of two people one can state that they differ, of three
not much about people in general.
"""

import common
import numpy as np

from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.statistics import two_sample_test

METRICS = ("angle", "position", "rotation", "spatial")
STATISTICS = ("energy", "mmd")
LEVEL = 0.05
FRAME_RATE, OF_GEODESICS = 12.0, 1.0  # Hz
N_LEVEL = 5  # recordings in each set
N_POWER = (3, 4, 6, 8)


def prepared(dataset, frame_rate=FRAME_RATE):
    """Return a dataset on ball joints, on one skeleton, at a frame rate."""
    dataset = dataset.to_rotvec().retarget(dataset.to_rotvec().skeleton)
    return dataset._with([motion.resample(frame_rate) for motion in dataset])


def of(dataset, subject=None, action=""):
    """Return the motions of a person, or of all but "not" one, whose action begins with a word."""
    chosen = np.char.startswith(dataset.actions, action)
    if subject is not None:
        without = subject.startswith("not ")
        chosen &= (dataset.subjects == subject.removeprefix("not ")) != without
    return list(dataset[chosen])


def drawn(rng, motions, n):
    return [motions[i] for i in rng.permutation(len(motions))[:n]]


def p_value(X, Y, metric, statistic, **options):
    return two_sample_test(X, Y, metric=metric, statistic=statistic, random_state=0, n_jobs=-1, **options).pvalue


def table(title, columns, rows):
    """Print a table of Markdown; rows are a name and one text a column."""
    print(f"\n{title}\n\n| | {' | '.join(columns)} |\n|{'---|' * (len(columns) + 1)}")
    for name, *cells in rows:
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def each_metric(function, metrics=METRICS):
    """Yield a row for every metric, with what a function of it and of the statistic returns."""
    for metric in metrics:
        yield metric, *(text for statistic in STATISTICS for text in function(metric, statistic))


# --- the four parts --------------------------------------------------------------------------------------------------


def named_comparisons(dataset, person, geodesics):
    """Print p-values of one person's walks against others, against runs, and against themselves."""
    slow = prepared(dataset, OF_GEODESICS) if geodesics else None
    motions = prepared(dataset)
    for statistic in STATISTICS:
        rows = []
        for metric in (*METRICS, "geodesic") if geodesics else METRICS:
            source = slow if metric == "geodesic" else motions
            walks, runs = of(source, person, "walk"), of(source, person, "run")
            half = len(walks) // 2
            cells = [
                p_value(walks, of(source, f"not {person}", "walk"), metric, statistic),
                p_value(walks, runs, metric, statistic),
                p_value(walks[::2], walks[1::2], metric, statistic),
                p_value(walks[:half], walks[half:], metric, statistic),
                p_value(runs[::2], runs[1::2], metric, statistic),
            ]
            rows.append((metric, *(f"{p:.3f}" for p in cells)))
        columns = ("walks: others'", "walks, runs", "walks: odd, even", "walks: first, last", "runs: odd, even")
        table(f"p-values of subject {person}, {statistic}", columns, rows)
    return rows


def people_and_halves(motions):
    """Print how many pairs of people, and of halves of one person's recordings, are found to differ."""
    actions, people = sorted(set(motions.actions)), sorted(set(motions.subjects))
    own = {(person, action): of(motions, person, action) for person in people for action in actions}
    pairs = [
        (own[one, action], own[other, action])
        for action in actions
        for one in people
        for other in people
        if one < other
    ]
    halves = [(recordings[::2], recordings[1::2]) for recordings in own.values()]
    shares = {}

    def cells(metric, statistic):
        for name, sets in (("people", pairs), ("halves", halves)):
            tests = [
                two_sample_test(X, Y, metric=metric, statistic=statistic, random_state=0, n_jobs=-1)
                for X, Y in sets
                if len(X) + len(Y) > 2
            ]
            p = np.array([test.pvalue for test in tests if test.least_pvalue <= LEVEL])
            shares[name, metric, statistic] = np.mean(p <= LEVEL)
            yield f"{np.sum(p <= LEVEL)} of {len(p)}"

    columns = [f"{name}, {statistic}" for statistic in STATISTICS for name in ("two people", "odd, even")]
    table("One action: tests with p at most 0.05", columns, each_metric(cells))
    return shares


def level(recordings, name, n_draws):
    """Print the share of true nulls that are rejected, recordings permuted whole and frames one by one."""
    shares = {}

    def cells(metric, statistic):
        rng, rejected = np.random.default_rng(0), []
        for _ in range(n_draws):
            ten = drawn(rng, recordings, 2 * N_LEVEL)
            X, Y = ten[:N_LEVEL], ten[N_LEVEL:]
            a, b = (rng.permutation(np.concatenate([motion.angles for motion in one])) for one in (X, Y))
            of_frames = p_value(a, b, metric, statistic, skeleton=X[0].skeleton, n_permutations=199)
            rejected.append([p_value(X, Y, metric, statistic) <= LEVEL, of_frames <= LEVEL])
        shares[metric, statistic] = np.mean(rejected, axis=0)
        yield from (f"{share:.1%}" for share in shares[metric, statistic])

    columns = [f"{name}, {statistic}" for statistic in STATISTICS for name in ("recordings", "frames")]
    table(
        f"Level: {N_LEVEL} against {N_LEVEL} of {len(recordings)} recordings, {name}, rejected",
        columns,
        each_metric(cells),
    )
    return shares


def power(of_people, n_draws):
    """Print the share of differences between people that are found, by the number of recordings."""
    shares = {}

    def cells_of(n):
        def cells(metric, statistic):
            rng, rejected = np.random.default_rng(n), []
            for _ in range(n_draws):
                first, second = rng.permutation(len(of_people))[:2]
                one, other = drawn(rng, of_people[first], 2 * n), drawn(rng, of_people[second], n)
                mixed = [*other[: n // 2], *one[n : n + n - n // 2]]
                X = one[:n]
                rejected.append([p_value(X, Y, metric, statistic) <= LEVEL for Y in (other, mixed)])
            shares[n, metric, statistic] = np.mean(rejected, axis=0)
            yield from (f"{share:.0%}" for share in shares[n, metric, statistic])

        return cells

    columns = [f"{name}, {statistic}" for statistic in STATISTICS for name in ("all of Y", "half of Y")]
    for n in [n for n in N_POWER if 2 * n - n // 2 <= min(map(len, of_people))]:
        table(f"Power: {n} against {n}, of another person", columns, each_metric(cells_of(n)))
    return shares


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    quick = options.quick
    n_draws = 20 if quick else 200
    if quick or not (options.cmu or options.hdm05):
        gait = make_gait(3, 10, duration=2.0, frame_rate=FRAME_RATE, random_state=0)
        named_comparisons(gait, "01", geodesics=False)
        motions = prepared(gait)
        found = people_and_halves(motions)
        rejected = level(of(motions, "01", "walk"), "one person's walks", n_draws)
        powers = power([of(motions, subject, "walk") for subject in ("01", "02", "03")], n_draws)
        # The answers: people differ, halves of one person do not; frames permuted one by one reject far too often.
        assert all(found["people", m, s] == 1.0 and found["halves", m, s] <= 0.5 for m in METRICS for s in STATISTICS)
        assert all(share[0] <= 0.25 for share in rejected.values())
        assert all(rejected["angle", s][1] > 0.4 for s in STATISTICS)
        assert all(powers[3, m, s][0] == 0.0 and powers[6, m, s][0] > 0.9 for m in METRICS for s in STATISTICS)
        return
    if options.cmu:
        cmu = load_cmu(options.cmu)
        named_comparisons(cmu, "35", geodesics=True)
        level(of(prepared(cmu), "35", "walk"), "walks of subject 35 of CMU", n_draws)
    if options.hdm05:
        hdm05 = prepared(load_hdm05(options.hdm05))
        people_and_halves(hdm05)
        level(of(hdm05, "bd", "squat"), "squats of bd of HDM05", n_draws)
        level(of(hdm05, "bd", "hop"), "hops of bd of HDM05", n_draws)
        power([of(hdm05, subject, "squat") for subject in sorted(set(hdm05.subjects))], n_draws)


if __name__ == "__main__":
    main()
