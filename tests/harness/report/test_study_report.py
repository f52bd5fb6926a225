"""The report's section on launches, from fabricated renders."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from fabricated_study import LAWS

from harness.gate import check
from harness.report.study import find_variants
from harness.report.study_figures import bounds_of, plot_timeline
from harness.report.study_tables import smallest_reaching
from harness.report.summary import collect_facts
from harness.report.write import write_report
from harness.statistics.intervals import Interval
from harness.tables import write_tables
from harness.tables.lookup import read_measurements


@pytest.fixture(scope="module")
def folder(studied_results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report") / "results"
    shutil.copytree(studied_results, folder)
    write_tables(folder)
    write_report(folder)
    return folder


def test_the_page_has_figures_and_tables_of_the_study(folder: Path):
    page = (folder / "report.html").read_text()
    assert 'id="launches"' in page
    for name in ("study-ladder-haste-cuda", "study-timeline-mirror-glass-haste"):
        assert (folder / "figures" / f"{name}.svg").is_file()
    for table in ("launch_laws", "launch_work", "queue_memory", "prices"):
        assert len(pd.read_csv(folder / "tables" / f"{table}.csv")) > 0, table


def test_the_table_of_laws_says_who_is_fastest_and_where_it_is_reached(folder: Path):
    laws = pd.read_csv(folder / "tables" / "launch_laws.csv").set_index(["model", "engine"])
    assert laws.loc[("haste", "depth_first"), "share_of_fastest"].item() == pytest.approx(1.0)
    reached = laws.loc[("haste", "wavefront"), "reaches_90_percent_at"].item()
    half = LAWS["wavefront"][0] * LAWS["wavefront"][1]
    # N / (N + N_1/2) >= 0.9 from N = 9 N_1/2 on; the next power of two, or its neighbour by noise.
    assert 9 * half / 1.5 <= reached <= 9 * half * 3


def test_a_run_of_the_study_alone_has_tables_a_report_and_a_machine(
    studied_results: Path, tmp_path: Path
):
    alone = tmp_path / "alone"
    shutil.copytree(studied_results / "study", alone / "study")
    settings = json.loads((studied_results / "settings.json").read_text())
    (alone / "settings.json").write_text(json.dumps({**settings, "scenes": []}))
    machines = {"haste": "Intel", "whitted": "AMD"}
    for model, processor in machines.items():
        path = alone / "study" / "mirror-glass" / model / "provenance.json"
        provenance = json.loads(path.read_text())
        study = {**provenance["config"]["study"], "joules_seconds": len(model)}
        more = {"machine": {"processor": processor}, "started": f"2026-11-2{len(processor)}"}
        path.write_text(json.dumps({**provenance, **more, "config": {"study": study}}))
    write_tables(alone)
    page = write_report(alone).read_text()
    found = re.findall(r'<section id="([\w-]+)"', page)
    assert found == ["launches", "provenance", "downloads", "formulas", "reproduce"]
    provenance = json.loads((alone / "provenance.json").read_text())
    assert provenance["scenes"] == {}
    # The two machines differ, so that neither is the run's; the first is named.
    facts = dict(collect_facts(provenance, []))
    assert facts["processor"] in machines.values(), facts
    assert facts["started"] == "2026-11-23", facts
    # Nor are their settings; a row's command is of the row's panel all the same.
    assert "config" not in provenance
    for row in pd.read_csv(alone / "tables" / "launch_laws.csv").itertuples():
        assert f"'study={{panels: {{mirror-glass: [{row.model}]}}" in row.command, row.command


def test_the_gate_says_that_a_run_of_the_study_alone_has_nothing_to_judge(
    studied_results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    shutil.copytree(studied_results / "study", tmp_path / "study")
    settings = json.loads((studied_results / "settings.json").read_text())
    (tmp_path / "settings.json").write_text(json.dumps({**settings, "scenes": []}))
    write_tables(tmp_path)
    assert check(tmp_path) == 1
    assert "the run has no images: there is nothing to judge" in capsys.readouterr().out


def test_layers_grow_with_the_image_and_packets_do_not(folder: Path):
    memory = pd.read_csv(folder / "tables" / "queue_memory.csv")
    first, last = memory.iloc[1], memory.iloc[3]
    assert last["layers_bytes"] > 8 * first["layers_bytes"]
    assert last["lifo_bytes"] == first["lifo_bytes"]


def test_bounds_are_those_of_the_fabricated_machine(folder: Path):
    measurements = read_measurements(folder / "measurements.csv")
    variants = [one for one in find_variants(measurements) if one.model == "haste"]
    bounds = bounds_of(measurements, variants)
    # Five of six queued rays of a sample are not a camera's; 64 bytes each way at once.
    assert bounds["bus"][0.0] == pytest.approx(4.99e10 / (64 * 5 / 6), rel=0.02)
    assert bounds["device"][0.0] == pytest.approx(2.6e12 / 128)
    assert set(bounds) == {"bus", "device", "kernel", "queue"}


def test_the_smallest_launch_that_reaches_a_share_is_measured_not_fitted():
    rates = {n: Interval(value, 0.0, 0.0, 3) for n, value in ((1, 0.5), (2, 0.91), (4, 0.95))}
    assert smallest_reaching(rates, Interval(1.0, 0.9, 1.1, 9)) == 2
    assert smallest_reaching(rates, Interval(2.0, 1.9, 2.1, 9)) is None


def test_without_spans_there_is_no_time_line():
    assert plot_timeline([("packets", [])], "") is None


def test_a_run_without_a_study_has_no_section(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("mirror-glass",), models=("haste",), size=16)
    write_tables(folder)
    assert 'id="launches"' not in write_report(folder).read_text()
