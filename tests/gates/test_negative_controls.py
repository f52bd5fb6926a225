"""Planted errors in fabricated images: each gets the right verdict in 95 of 100 repeats or more.

A repeat draws new noise for everything: the truth's batches, the images and the baseline's. The
levels are those of a run of six scenes, three models and four tracers.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from harness.agreement import compare_images, worst
from harness.bounds import TESTS, Bound, GateSettings
from harness.regression import judge_change
from harness.snapshot import Snapshot, make_snapshot
from harness.statistics.bias import Verdict
from harness.statistics.change import Speed, judge_speed
from harness.statistics.estimate import combine, mean_of
from harness.statistics.metrics import Truth, make_truth

Images = NDArray[np.float64]

REPEATS = 100
EDGE = 24
SEEDS = 16
SPP = 512
SUBJECTS = 6 * 3 * 4
SETTINGS = GateSettings()


def bound(subjects: int) -> tuple[Bound, float]:
    """The levels of a run of so many images, and that of its tiles."""
    tiles = subjects * (EDGE // SETTINGS.tile) ** 2
    strict = SETTINGS.strict(TESTS * subjects)
    return Bound(SETTINGS.delta, strict, SETTINGS.tile), SETTINGS.tile_level(2 * tiles)


@cache
def room(shift: float = 0.0) -> Images:
    """A box with coloured walls, a ball, a light and its glow: [EDGE, EDGE, 3].

    Drawn at eight times the size and box-filtered; shift: to the right, in pixels.
    """
    fine = 8 * EDGE
    y, x = np.mgrid[0:fine, 0:fine] / fine
    image = np.stack([0.25 + 0.2 * y, 0.25 + 0.15 * y, 0.22 + 0.1 * y], axis=-1)
    image[x < 0.2] = [0.5, 0.06, 0.05]
    image[x > 0.8] = [0.08, 0.35, 0.07]
    image[(x - 0.5) ** 2 + (y - 0.65) ** 2 < 0.03] *= 1.7
    image += 0.4 * np.exp(-((x - 0.3) ** 2 + (y - 0.3) ** 2) / 0.01)[..., None]
    image[y > 0.94] = 0.0
    image[(y < 0.1) & (abs(x - 0.5) < 0.15)] = 4.0
    moved = ndimage.shift(image, (0.0, 8.0 * shift, 0.0), order=1, mode="nearest")
    return moved.reshape(EDGE, 8, EDGE, 8, 3).mean(axis=(1, 3))


def render(random: np.random.Generator, mean: Images, count: int, spp: float) -> Images:
    """Images of gamma-distributed samples whose standard deviation is their mean's."""
    return random.gamma(spp, np.maximum(mean, 0.0) / spp, (count, *mean.shape))


def snapshot(images: Images, truth: Truth, seeds: int = 0) -> Snapshot:
    numbers = tuple(range(seeds, seeds + len(images)))
    return make_snapshot(
        ("room", "path", "embree"),
        images,
        truth,
        spp=SPP,
        seeds=numbers,
        log_seconds=np.zeros(0),
        timed_on="a processor",
        tile=SETTINGS.tile,
    )


def verdict_of(
    random: np.random.Generator, images: Images, subjects: int = SUBJECTS
) -> tuple[Verdict, str]:
    """The verdict of the whole check on images of the room, and the words that go with it."""
    held, level = bound(subjects)
    truth = make_truth(render(random, room(), 16, 4 * SPP))
    before = snapshot(render(random, room(), SEEDS, SPP), truth)
    agreement = compare_images(images, SPP, truth, held)
    change = judge_change(snapshot(images, truth), before, SETTINGS, held, level)
    words = f"{agreement.bias.bias}, smallest tile {agreement.tiles.smallest}, {agreement.note}"
    return worst({agreement.verdict(level), change.verdict}), f"{words}, {change}"


def brighter(random: np.random.Generator) -> Images:
    return 1.01 * render(random, room(), SEEDS, SPP)


def one_tile(random: np.random.Generator) -> Images:
    mean = room().copy()
    mean[8:16, 8:16] *= 1.1
    return render(random, mean, SEEDS, SPP)


def without_a_light(random: np.random.Generator) -> Images:
    """The glow of one of the lights is missing."""
    y, x = np.mgrid[0:EDGE, 0:EDGE] / EDGE
    glow = 0.4 * np.exp(-((x - 0.3) ** 2 + (y - 0.3) ** 2) / 0.01)[..., None]
    return render(random, room() - glow, SEEDS, SPP)


def half_a_pixel(random: np.random.Generator) -> Images:
    return render(random, room(0.5), SEEDS, SPP)


def shared_samples(random: np.random.Generator) -> Images:
    """Every image takes half of its samples from the next seed's."""
    halves = render(random, room(), SEEDS + 1, SPP / 2)
    return 0.5 * (halves[:-1] + halves[1:])


def doubled_variance(random: np.random.Generator) -> Images:
    return render(random, room(), SEEDS, SPP / 2)


@pytest.mark.parametrize(
    "plant",
    [
        brighter,
        one_tile,
        without_a_light,
        half_a_pixel,
        shared_samples,
        doubled_variance,
    ],
    ids=lambda plant: plant.__name__,
)
def test_a_planted_error_fails(plant: Callable[[np.random.Generator], Images]) -> None:
    random = np.random.default_rng(20_261_122)
    found = [verdict_of(random, plant(random)) for _ in range(REPEATS)]
    missed = [words for verdict, words in found if verdict is not Verdict.FAIL]
    assert len(missed) <= 5, f"{len(missed)} of {REPEATS} do not fail, the first: {missed[0]}"


def test_clean_runs_raise_hardly_an_alarm() -> None:
    random = np.random.default_rng(20_261_123)
    subjects = 3
    alarms = []
    for _ in range(REPEATS):
        images = [render(random, room(), SEEDS, SPP) for _ in range(subjects)]
        found = [verdict_of(random, stack, subjects) for stack in images]
        alarms += [words for verdict, words in found if verdict is Verdict.FAIL]
    assert len(alarms) <= 2, alarms


def test_a_clean_run_passes() -> None:
    random = np.random.default_rng(20_261_124)
    found = [verdict_of(random, render(random, room(), SEEDS, SPP)) for _ in range(REPEATS)]
    missed = [words for verdict, words in found if verdict is not Verdict.PASS]
    assert len(missed) <= 5, f"{len(missed)} of {REPEATS} do not pass, the first: {missed[0]}"


def test_equal_seeds_that_render_equal_images_pass_whatever_the_noise() -> None:
    random = np.random.default_rng(20_261_125)
    held, level = bound(SUBJECTS)
    truth = make_truth(render(random, room(), 16, 4.0))
    images = render(random, room(), SEEDS, 0.1)
    same = judge_change(snapshot(images, truth), snapshot(images, truth), SETTINGS, held, level)
    assert same.verdict is Verdict.PASS, same
    other = snapshot(render(random, room(), SEEDS, 0.1), truth)
    assert judge_change(snapshot(images, truth), other, SETTINGS, held, level).verdict is (
        Verdict.NOT_ENOUGH_SAMPLES
    )


def speeds(random: np.random.Generator, slowdown: float) -> list[Speed]:
    """What is said of a tracer `slowdown` times as slow as before, in REPEATS pairs of runs.

    Times vary by 2 %, beyond what slows a whole round down, and there are ten rounds in each run.
    """
    held, _ = bound(SUBJECTS)

    def rounds(factor: float) -> NDArray[np.float64]:
        noise = random.normal(0.0, 0.02, (2, 10))
        return np.log(factor) + noise[0] - noise[1]

    return [
        judge_speed(
            combine([(1.0, mean_of(rounds(1.0))), (-1.0, mean_of(rounds(slowdown)))]),
            SETTINGS.speed_margin,
            held.strict,
        )
        for _ in range(REPEATS)
    ]


def test_a_tracer_that_is_a_fifth_slower_is_called_slower_and_never_the_same() -> None:
    found = speeds(np.random.default_rng(20_261_126), 1.2)
    assert Speed.SAME not in found
    assert found.count(Speed.SLOWER) >= 80, found


def test_an_equal_speed_is_the_same_or_ambiguous() -> None:
    found = speeds(np.random.default_rng(20_261_127), 1.0)
    assert set(found) <= {Speed.SAME, Speed.AMBIGUOUS}, found
    assert found.count(Speed.SAME) >= 80, found
