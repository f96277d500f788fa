"""Small figures among the points of an explorer, its planes, and the forms of its points."""

import itertools

import numpy as np
import pytest
from browser import changed
from explorer_page import places
from pages import data_of

from skpose import SpatialMDS
from skpose.datasets import MotionDataset, make_actions
from skpose.view import explorer
from skpose.view._pack import unpack
from skpose.view._page import asset

pytestmark = pytest.mark.slow
BOXES = "skpose.state.figures.map(({ row, x, y, width, height }) => [row, x, y, width, height])"
GAP = 4  # px between two figures


@pytest.fixture(scope="module")
def actions():
    return make_actions(2, 1, actions=["kick", "squat", "wave"], random_state=0)


@pytest.fixture(scope="module")
def page(actions):
    return explorer(actions, frame_rate=6, metrics=["spatial", "angle"], embeddings=["mds", "tsne", "isomap"])


def rows_of(data, group):
    of_motion = next(groups for groups in data["groups"] if groups["by"] == group)
    motion_of = np.repeat(np.arange(len(data["counts"])), data["counts"])
    return np.array(of_motion["of"])[motion_of], of_motion["names"]


def test_a_page_opens_coloured_by_action_and_plays(browser, page):
    browser.open(page, still=False)
    assert browser.find("#colour").get_attribute("value") == "action"
    assert browser.find("#play").text == "Pause"


def test_figures_stand_for_the_actions(browser, page):
    """Each is a pose of its action, in the middle of it; all have a label, and none lies over another."""
    browser.open(page)
    where, (of, names) = places(browser), rows_of(data_of(page), "action")
    shown = browser.js(BOXES)
    assert len(shown) == len(names)
    check_apart(browser, shown)
    for row, *_ in shown:
        members = where[of == of[row]]
        far = np.linalg.norm(members - np.median(members, axis=0), axis=1)
        assert np.linalg.norm(where[row] - np.median(members, axis=0)) <= np.median(far)
    assert len({of[row] for row, *_ in shown}) == len(shown)


def check_apart(browser, shown):
    """No figure lies over another one, or outside of the canvas, and each is drawn."""
    boxes = np.array(shown).reshape(-1, 5)[:, 1:]
    for a, b in itertools.combinations(boxes, 2):
        apart = np.abs(a[:2] + a[2:] / 2 - b[:2] - b[2:] / 2)
        assert (apart >= (a[2:] + b[2:]) / 2 + GAP - 1e-6).any()
    size = browser.js("[skpose.stage.width, skpose.stage.height]")
    assert (boxes[:, :2] >= 0).all()
    assert (boxes[:, :2] + boxes[:, 2:] <= size).all()
    assert (boxes[:, 3] >= 30).all()  # as high as a person's


@pytest.mark.parametrize(("size", "zoom"), [((1300, 900), 1), ((420, 900), 1), ((1300, 900), 3)], ids=str)
def test_a_label_has_a_figure_with_sides_and_an_edge(browser, page, size, zoom):
    """Its box has the group's colour and two tones of it; around the figure there is paper over the points."""
    browser.open(page, size=size)
    browser.driver.execute_script("skpose.stage.zoomBy(arguments[0])", zoom)
    browser.press("+", "-", css="#canvas")
    shown = browser.js(BOXES)
    assert shown
    check_apart(browser, shown)
    picture = browser.picture("#points")
    for _, x, y, width, height in shown:
        inside = picture[int(y) : int(y + height), int(x) : int(x + width)].reshape(-1, 3)
        lightness = inside.sum(axis=1)[np.ptp(inside, axis=1) > 30]  # of what is coloured
        assert np.percentile(lightness, 90) - np.percentile(lightness, 10) > 100


def test_lines_of_labels_rarely_cross(browser, actions):
    """Ten groups lie over each other, their middles near to one another; figures in each other's places cross."""
    rng = np.random.default_rng(0)
    browser.open(explorer(actions, frame_rate=60, metrics=["angle"]), size=(1300, 900))
    n = browser.js("skpose.poses.count")
    of = np.arange(n) % 10
    found = []
    for _ in range(8):
        at = rng.normal(scale=0.2, size=(10, 2))[of] + rng.normal(scale=0.7, size=(n, 2))
        browser.driver.execute_script(
            "const { stage, small } = skpose; const [of, x, y] = arguments; stage.x.set(x); stage.y.set(y);"
            "stage.grid = new stage.grid.constructor(stage.x, stage.y); stage.home();"
            "small.group(stage, { names: Array.from({ length: 10 }, (_, group) => `group ${group}`), of });",
            of.tolist(),
            *at.T.tolist(),
        )
        browser.press("+", "-", css="#canvas")
        browser.settle()
        shown = browser.js(BOXES)
        check_apart(browser, shown)
        starts = np.array([browser.js(f"skpose.stage.at({row})") for row, *_ in shown])
        boxes = np.array(shown)[:, 1:]
        ends = boxes[:, :2] + boxes[:, 2:] / 2
        by_chance = np.mean([count_crossings(starts, rng.permutation(ends)) for _ in range(20)])
        found.append((len(shown), count_crossings(starts, ends), by_chance))
    n_shown, n_crossings, n_by_chance = np.sum(found, axis=0)
    assert n_shown == 80
    assert n_crossings <= 6  # 5; 15 where lines may pass through the points of others
    assert n_by_chance > 80


def test_labels_whose_lines_are_in_each_others_way_are_placed_anew(browser):
    """Twelve points near to one another: each label placed alone, ten lines of 360 cross or pass through a point."""
    scripts = "\n".join(map(asset, ("shape.js", "small_figures.js", "labels.js")))
    browser.open(f"<!DOCTYPE html><script type='module'>{scripts}\nwindow.placeLabels = placeLabels;</script>")
    browser.wait("Boolean(window.placeLabels)")
    rng = np.random.default_rng(0)
    n_shown, n_crossings = 0, 0
    for _ in range(30):
        points = []
        while len(points) < 12:
            point = rng.normal(scale=0.04, size=2)
            if all(np.linalg.norm(point - other) > 0.028 for other in points):
                points.append(point)
        x, y = np.transpose(points)
        size = {"width": 900, "height": 700, "scale": 900, "zoom": 1, "middle": [0, 0], "count": 12}
        labels = [{"row": row, "width": 70, "height": 90} for row in range(12)]
        shown = browser.js("placeLabels(...arguments)", size | {"x": x.tolist(), "y": y.tolist()}, labels, 1)
        starts = np.array([one["at"] for one in shown])
        n_shown += len(shown)
        n_crossings += count_crossings(starts, starts + [one["offset"] for one in shown])
    assert n_shown == 360
    assert n_crossings == 0


def count_crossings(starts, ends):
    """Return how many lines cross another one, or pass within 10 px of its point."""
    lengths = np.linalg.norm(starts - ends, axis=1, keepdims=True)
    starts = starts + 10 * (starts - ends) / np.maximum(lengths, 10)

    def side(a, b, point):
        (x, y), (u, v) = b - a, point - a
        return np.sign(x * v - y * u)

    lines = list(zip(starts, ends, strict=True))
    return sum(
        side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
        for (a, b), (c, d) in itertools.combinations(lines, 2)
    )


def test_labels_stay_while_one_moves(browser, page):
    """From their points they are as far as before, until the zoom has doubled."""
    browser.open(page, size=(1300, 900))
    start = {row: np.subtract(place, browser.js(f"skpose.stage.at({row})")) for row, *place in short(browser)}
    browser.press("+", css="#canvas")
    for row, *place in short(browser):
        np.testing.assert_allclose(np.subtract(place, browser.js(f"skpose.stage.at({row})")), start[row], atol=1e-6)


def short(browser):
    return [box[:3] for box in browser.js(BOXES)]


def test_dense_places_are_not_flat(browser):
    """Points that lie over each other are smaller and paler, single ones as they are, at the zoom at which they do."""
    rng = np.random.default_rng(0)
    motion = make_actions(1, 1, actions=["kick"], random_state=0).motions[0].resample(30)
    browser.open(explorer(MotionDataset([motion] * 12), metrics=["angle"], frame_rate=None))
    n = browser.js("skpose.poses.count")
    x = np.concatenate([rng.normal(size=n - 2), [40.0, -40.0]])  # a dense place, and two far from it
    browser.driver.execute_script(
        "const s = skpose.stage; arguments[0].forEach((x, i) => ((s.x[i] = x), (s.y[i] = arguments[1][i])));"
        "s.grid = new s.grid.constructor(s.x, s.y); s.home();",
        x.tolist(),
        rng.normal(size=n).tolist(),
    )
    whole = np.array(browser.js("Array.from(skpose.stage.crowding())"))
    assert (whole[-2:] == 0).all()
    assert np.median(whole[:-2]) > 3
    inner, outer = np.abs(x[:-2]) < 0.5, np.abs(x[:-2]) > 2
    assert np.median(whole[:-2][inner]) > np.median(whole[:-2][outer])
    browser.driver.execute_script("skpose.stage.zoomTo(100, [0, 0])")
    assert np.median(browser.js("Array.from(skpose.stage.crowding())")) == 0
    assert changed_by_moving(browser) == 0


def changed_by_moving(browser):
    """Return how many points change as the view moves by a part of a cell."""
    return browser.js(
        "(() => { const s = skpose.stage; s.zoomTo(2, [0, 0]); const before = s.crowding().slice(); s.pan(3.3, 1.7);"
        " return s.crowding().filter((level, i) => level !== before[i]).length; })()"
    )


def test_more_figures_appear_where_there_is_space(browser, page):
    browser.open(page)
    counts = [len(browser.js(BOXES))]
    for _ in range(6):
        browser.press("+", "+", css="#canvas")
        browser.settle()
        shown = browser.js(BOXES)
        check_apart(browser, shown)
        counts.append(len(shown))
    assert max(counts) > counts[0]
    browser.find("#figures").click()
    browser.settle()
    assert browser.js(BOXES) == []


def test_figures_of_other_groups_are_not_shown(browser, page):
    browser.open(page)
    of, _ = rows_of(data_of(page), "action")
    browser.driver.find_elements("css selector", "#groups button")[1].click()
    browser.settle()
    assert {of[row] for row, *_ in browser.js(BOXES)} <= {1}


def test_the_label_of_a_group_that_is_seen_alone_stays(browser, page):
    browser.open(page)
    of, _ = rows_of(data_of(page), "action")
    before = {of[row]: place for row, *place in browser.js(BOXES)}
    browser.driver.find_elements("css selector", "#groups button")[1].click()
    browser.settle()
    assert {of[row]: place for row, *place in browser.js(BOXES)} == {1: before[1]}


def test_planes_are_those_of_the_methods(browser, page, actions):
    X, _ = actions.poses(frame_rate=6)
    of, _ = rows_of(data_of(page), "action")
    held = data_of(page)["embeddings"]
    assert [(one["metric"], one["method"]) for one in held] == [
        (metric, method) for metric in ("spatial", "angle") for method in ("mds", "tsne", "isomap")
    ]
    mds = SpatialMDS(actions.skeleton, n_components=2).fit_transform(X)
    np.testing.assert_allclose(np.abs(unpack(held[0]["points"])), np.abs(mds), atol=1e-5 * np.ptp(mds))
    browser.open(page)
    for method in ("mds", "tsne", "isomap"):
        browser.choose("#method", method)
        where = places(browser)
        points = unpack(next(o for o in held if (o["metric"], o["method"]) == ("spatial", method))["points"])
        turned, seen = (points - points.mean(axis=0)) * [1, -1], where - where.mean(axis=0)
        scale = (turned * seen).sum() / (turned**2).sum()
        np.testing.assert_allclose(seen, scale * turned, atol=1e-6 * np.ptp(where))
        nearest = np.linalg.norm(points[:, None] - points, axis=2) + np.diag(np.full(len(points), np.inf))
        near = nearest.argmin(axis=1)
        assert (of[near] == of).mean() > 0.8
        assert (np.random.default_rng(0).permutation(of)[near] == of).mean() < 0.5  # by chance a third


def test_lengths_are_shown_where_they_mean_something(browser, page):
    browser.open(page)
    for method, unit in (("mds", "m"), ("tsne", None), ("isomap", "m")):
        browser.choose("#method", method)
        assert browser.js("skpose.state.unit") == unit


def test_colours_with_their_forms_do_not_repeat_within_twenty(browser):
    motion = make_actions(1, 1, actions=["kick"], random_state=0).motions[0].resample(4)
    names = [f"person {i:02}" for i in range(20)]
    browser.open(explorer(MotionDataset([motion] * 20, subjects=names), metrics=["angle"], frame_rate=None))
    looks = browser.js(
        "Array.from({ length: skpose.poses.count }, (_, i) => `${skpose.stage.colours[i]} ${skpose.stage.forms[i]}`)"
    )
    assert len(set(looks)) == 20
    swatches = browser.js(
        "[...document.querySelectorAll('.swatch')].map((e) => `${e.style.background} ${e.dataset.form}`)"
    )
    assert len(set(swatches)) == 20


@pytest.mark.parametrize(
    ("options", "words"),
    [({"embeddings": []}, "at least one of"), ({"embeddings": ["pca"]}, "pca"), ({"embeddings": "mds"}, "a list")],
)
def test_other_embeddings_are_refused(actions, options, words):
    with pytest.raises(ValueError, match=words):
        explorer(actions, frame_rate=6, metrics=["angle"], **options)


def test_isomap_of_many_poses_is_refused(actions, monkeypatch):
    from skpose.view import _embeddings

    monkeypatch.setattr(_embeddings, "MOST_OF_ISOMAP", 10)
    with pytest.raises(ValueError, match="10 poses at most"):
        explorer(actions, frame_rate=6, metrics=["angle"], embeddings=["isomap"])


def test_small_figures_turn_with_the_large_one(browser, page):
    browser.open(page)
    before = browser.picture("#points")
    browser.press(*["ARROW_LEFT"] * 6, css="#figure")
    browser.wait("!skpose.small.late && skpose.small.seen === skpose.small.asked")
    assert changed(before, browser.picture("#points")) > 300
    browser.press("0", css="#figure")
    browser.wait("!skpose.small.late && skpose.small.seen === skpose.small.asked")
    assert changed(before, browser.picture("#points")) == 0


def test_no_figure_is_drawn_before_it_is_measured(browser, page):
    """A picture that was made for the room that a pose may need would be squeezed into the box of the pose later."""
    browser.open(page)
    late, unknown, kept, known = browser.js("""(({ small }) => {
      const [row, context] = [7, document.createElement("canvas").getContext("2d")];
      small.figures.delete(row);
      small.pictures.clear();
      small.until = -1;
      const box = { row, side: 80, x: 0, y: 0, ...small.measured(row, 80) };
      small.until = Infinity; // as where a clock has other steps
      small.late = false;
      small.put(context, box, "#123456");
      const found = [small.late, box.width, small.pictures.size];
      return [...found, small.measured(row, 80).width];
    })(skpose)""")
    assert late
    assert (unknown, kept) == (80, 0)
    assert known < 80


def test_what_was_not_used_for_long_is_forgotten(browser, page):
    """Pictures of what is drawn stay, so that no frame makes them again, however many there are."""
    browser.open(page)
    before, after, same, figures = browser.js("""(({ small, stage }) => {
      const context = document.createElement("canvas").getContext("2d");
      const draw = () => small.draw(context, stage, { colourOf: () => "#123456", hidden: () => false, all: true });
      for (const table of [small.figures, small.pictures]) table.clear();
      const n = draw().length;
      const made = [...small.pictures];
      for (let i = 0; i < 9000; i++) {
        small.pictures.set(`other ${i}`, null);
        small.figures.set(`other ${i}`, null);
      }
      draw();
      const kept = made.filter(([key, picture]) => small.pictures.get(key) === picture).length;
      return [n, small.pictures.size - n, kept === made.length, small.figures.size - n];
    })(skpose)""")
    assert before > 1
    assert same
    assert (after, figures) == (500, 4000)
