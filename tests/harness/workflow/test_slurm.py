"""Scaling out: the same tables from jobs that SLURM has run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from itertools import pairwise
from pathlib import Path

import pandas as pd
import pytest
from runs import SCENES, Run, compare_mitsuba, make_run, records, rows, tracers_images
from slurm_node import missing_programs, slurm_node

PATIENCE = 900.0
"""Seconds after which a run hangs that takes two minutes, or five beside other work."""


def run_on_slurm(run: Run, environment: dict[str, str]) -> None:
    """Make a run's tables as SLURM's jobs.

    The first look at waiting jobs comes soon; each that finds none ended is followed by one that is
    ten seconds later: the second comes when a small job has most likely ended.
    """
    tables = [str(run.results / name) for name in ("samples.parquet", "measurements.csv")]
    options = "--profile profiles/slurm --slurm-init-seconds-before-status-checks 3"
    small = ["--default-resources", "mem_mb=500", "runtime=10"]
    process = run.start(
        *(*tables, *options.split(), *small), program="snakemake", environment=environment
    )
    try:
        status = process.wait(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        status = None
    logs = "".join(path.read_text() for path in run.folder.glob(".snakemake/slurm_logs/**/*.log"))
    assert status == 0, run.said() + logs


def test_slurm_runs_the_same_workflow_and_no_two_timed_jobs_at_once(
    tmp_path: Path, undisturbed: Run
):
    missing = missing_programs()
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)} (apt-get install slurm-wlm munge)")
    run = make_run(tmp_path / "haste")
    cores = len(os.sched_getaffinity(0))
    with slurm_node(cores) as environment:
        run_on_slurm(run, environment)
    said = run.said()
    # Two jobs a scene, surfaces and sweeps of the suite of stability, and the tables.
    assert said.count("has been submitted with SLURM jobid") == 2 * len(SCENES) + 2 + 1, said

    jobs = [
        json.loads((run.results / "scenes" / scene / f"{step}.json").read_text())
        for scene in SCENES
        for step in ("truth", "measured")
    ]
    spans = sorted((job["started"], job["ended"], job["scene"]) for job in jobs)
    for first, second in pairwise(spans):
        assert first[1] <= second[0], spans

    assert tracers_images(run.results) == tracers_images(undisturbed.results)
    assert records(run.results) == records(undisturbed.results)
    assert compare_mitsuba(undisturbed.results, run.results, 1e-5) > 0
    tables = [
        rows(one.results, undisturbed.results, tmp_path / name, ("haste-cpu", "embree"))
        for name, one in (("undisturbed-tables", undisturbed), ("tables", run))
    ]
    pd.testing.assert_frame_equal(*tables)
