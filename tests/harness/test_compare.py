"""Two runs side by side: only what is beyond noise is named."""

import gzip
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.bounds import GateSettings
from harness.compare import compare, compare_runs, describe_run, log_estimate
from harness.statistics.intervals import Interval
from harness.tables import write_tables
from harness.tables.lookup import Measurement, Measurements

Fabricate = Callable[..., Path]
SMALL = {"scenes": ("cornell-box",), "models": ("path",), "spp": 64, "seeds": 16}
SETTINGS = GateSettings()
CHANGED = (4096, "lifo")


@pytest.fixture
def runs(fabricate_results: Fabricate, tmp_path: Path) -> tuple[Path, Path]:
    """Two runs of the same with noise of their own."""
    folders = []
    for seed in (1, 2):
        fabricate_results(**SMALL, random_seed=seed)
        folders.append((tmp_path / "results").rename(tmp_path / f"run-{seed}"))
        write_tables(folders[-1])
    return folders[0], folders[1]


def change_images(run: Path, tracer: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    for path in (run / "scenes/cornell-box/seeds/path" / tracer).glob("*.npy"):
        np.save(path, change(np.load(path)).astype(np.float32))
    write_tables(run)


def lines_of(capsys: pytest.CaptureFixture[str], word: str) -> list[str]:
    return [line for line in capsys.readouterr().out.splitlines() if word in line]


def test_noise_is_no_change(runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    code = compare(*runs, None, SETTINGS)
    out = capsys.readouterr().out
    assert code == 0, out
    assert "0 beyond noise" in out
    assert "0 lost, 0 new" in out


def test_a_run_of_parts_is_described_by_all_their_commits_and_machines(tmp_path: Path):
    study = {
        "skull": {"commit": "a" * 40, "machine": {"processor": "P", "gpus": [{"name": "G"}]}},
        "hard": {"commit": "b" * 40, "dirty": True, "machine": {"processor": "Q", "gpus": []}},
    }
    (tmp_path / "provenance.json").write_text(json.dumps({"run": "gpu", "study": study}))
    commits = f"commit {'a' * 40} and {'b' * 40} with local changes"
    assert describe_run(tmp_path) == f"{tmp_path}: run gpu, {commits}, P, G, Q"


def test_a_brighter_image_is_named_and_nothing_else(
    runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
):
    change_images(runs[1], "embree", lambda image: 1.02 * image)
    assert compare(*runs, None, SETTINGS) == 1
    out = capsys.readouterr().out
    changed = [line.split()[0] for line in out.splitlines() if "cornell-box path" in line]
    assert "image" in changed, out
    assert not [line for line in out.splitlines() if "haste-cpu" in line], out


def test_a_slower_tracer_is_worse(runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    path = runs[1] / "scenes/cornell-box/timing.json"
    rows = json.loads(path.read_text())
    for row in rows:
        row["seconds"] *= 1.4 if row["tracer"] == "haste-cpu" else 1.0
    path.write_text(json.dumps(rows))
    write_tables(runs[1])
    assert compare(*runs, None, SETTINGS) == 1
    (line,) = lines_of(capsys, "cornell-box path haste-cpu")
    assert line.startswith("speed")
    assert line.endswith("worse")
    # And back: the same change is for the better.
    assert compare(runs[1], runs[0], None, SETTINGS) == 1
    (line,) = lines_of(capsys, "cornell-box path haste-cpu")
    assert line.endswith("better")


def test_what_the_papers_allocation_costs_is_compared_launch_by_launch(
    studied_results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folders = [shutil.copytree(studied_results, tmp_path / name) for name in ("one", "other")]
    path = folders[1] / "study/mirror-glass/haste/rows.json"
    rows = json.loads(path.read_text())
    for row in rows:
        case = row["case"]
        if case.get("allocation") == "per_packet" and (case["packet"], case["order"]) == CHANGED:
            row["seconds"] *= 1.5
    path.write_text(json.dumps(rows))
    for folder in folders:
        write_tables(folder)
    assert compare(*folders, None, SETTINGS) == 1
    (line,) = lines_of(capsys, "mirror-glass haste haste-cuda packets")
    assert line.startswith("price"), line
    assert "order=lifo;packet=4096" in line, line
    assert line.endswith("worse"), line


def test_a_pixel_that_is_not_finite_is_worse(
    runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
):
    path = runs[1] / "scenes/cornell-box/seeds/path/embree/seed_002.npy"
    image = np.load(path)
    image[3, 4, 1] = np.nan
    np.save(path, image)
    write_tables(runs[1])
    assert compare(*runs, None, SETTINGS) == 1
    out = capsys.readouterr().out
    assert "non finite" in out, out
    assert "lost: cornell-box path embree (failed: 1 pixels are not finite)" in out


def test_the_report_is_a_page_of_markdown(runs: tuple[Path, Path], tmp_path: Path):
    change_images(runs[1], "embree", lambda image: 1.02 * image)
    compare(*runs, tmp_path / "out.md", SETTINGS)
    text = (tmp_path / "out.md").read_text()
    assert text.startswith("# What changed beyond noise\n")
    assert f"before is {runs[0]}: run fabricated" in text
    assert "| image | cornell-box path embree |" in text
    widths = {line.count("|") for line in text.splitlines() if line.startswith("|")}
    assert len(widths) == 1


def test_published_tables_are_enough(runs: tuple[Path, Path], tmp_path: Path):
    published = tmp_path / "published"
    published.mkdir()
    packed = gzip.compress((runs[0] / "measurements.csv").read_bytes())
    (published / "measurements.csv.gz").write_bytes(packed)
    assert compare(published, runs[1], None, SETTINGS) == 0


def test_folders_that_measured_nothing_alike_are_refused(
    runs: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert compare(runs[0], tmp_path / "nothing", None, SETTINGS) == 2
    assert "cannot be read" in capsys.readouterr().err


def many(random: np.random.Generator, shift: float, count: int = 200) -> Measurements:
    """Images with standard errors of 1 %, the first of them changed."""
    rows = []
    for place in range(count):
        values = random.normal(1.0, 0.04, 16)
        mean = float(values.mean()) + (shift if place == 0 else 0.0)
        half = 2.1314495 * float(values.std(ddof=1)) / 4.0
        found = Interval(mean, mean - half, mean + half, 16)
        rows.append(
            Measurement(
                *(f"scene-{place}", "embree", "path", "depth_first", "robust", "seeds=16;spp=64"),
                *("mean_luminance", found, "radiance", "ok", ""),
            )
        )
    return Measurements(rows)


def test_among_many_comparisons_noise_is_named_no_more_often_than_stated():
    random = np.random.default_rng(1)
    trials = 300
    wrong = sum(
        bool(compare_runs(many(random, 0.0, 40), many(random, 0.0, 40), 0.05, 0.1).changed)
        for _ in range(trials)
    )
    # Four standard errors of a share of 0.05.
    assert wrong / trials <= 0.05 + 4.0 * np.sqrt(0.0475 / trials), wrong


def test_among_many_comparisons_a_change_of_ten_errors_is_found():
    random = np.random.default_rng(2)
    found = compare_runs(many(random, 0.0), many(random, 0.15), 0.01, 0.1)
    assert [row.subject for row in found.changed] == ["scene-0 path embree"]


def test_the_error_of_a_measurement_comes_back_from_its_interval():
    half = 2.1314495 * 0.02
    found = log_estimate(Interval(2.0, 2.0 - half, 2.0 + half, 16), symmetric_log=False)
    assert found is not None
    assert (found.value, found.error) == pytest.approx((np.log(2.0), 0.01), rel=1e-6)
    assert log_estimate(Interval(2.0, np.nan, np.nan, 1), symmetric_log=False) is None


def replayed(precision: str, ratio: float) -> Measurement:
    """A ratio of rates of rays, within 1 %, of ten repeats."""
    case = "rays=diffuse1;to=mitsuba-cuda;traversal=bvh8"
    return Measurement(
        *("skull", "haste-cuda", "none", "replay", precision, case),
        *("speed_ratio", Interval(ratio, ratio / 1.01, ratio * 1.01, 10), "1", "ok", ""),
    )


def test_slower_rays_are_worse_in_the_precision_that_is_slower():
    before = Measurements([replayed("watertight", 4.5), replayed("fast", 5.0)])
    after = Measurements([replayed("watertight", 3.6), replayed("fast", 5.0)])
    found = compare_runs(before, after, 0.01, 0.1)
    named = [(row.title, row.kind, "watertight" in row.subject) for row in found.changed]
    assert named == [("speed", "worse", True)], found.changed
    assert found.compared == 2, found.compared


def test_rays_within_the_margin_of_speed_are_no_change():
    before, after = (Measurements([replayed("watertight", ratio)]) for ratio in (4.5, 4.2))
    found = compare_runs(before, after, 0.01, 0.1)
    assert not found.changed, found.changed
