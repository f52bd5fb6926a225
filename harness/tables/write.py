"""Writer of samples.parquet, measurements.csv and provenance.json."""

from __future__ import annotations

import json
import math
from pathlib import Path

from harness.statistics.intervals import Interval
from harness.tables.answers import record_answers
from harness.tables.eye_rays import record_eye_rays
from harness.tables.images import record_convergence, record_seeds, record_truth, subject_of
from harness.tables.knobs import record_knobs
from harness.tables.prices import read_price_jobs, record_prices
from harness.tables.provenance import PARTS, Provenance, merge_provenance
from harness.tables.rays import read_ray_jobs, record_rays
from harness.tables.read import SceneJob, read_jobs
from harness.tables.schema import Recorder
from harness.tables.spectra import record_spectra
from harness.tables.stability import (
    read_modes_jobs,
    read_stability_jobs,
    read_surfaces_job,
    record_modes,
    record_stability,
    record_surfaces,
)
from harness.tables.study import read_study, record_study
from harness.tables.sweeps import read_sweeps_job, record_sweeps
from harness.tables.times import (
    group_times,
    headline,
    record_efficiency,
    record_ratios,
    record_times,
)
from harness.tables.trade import EXACT, record_trade
from harness.whole_files import written_whole


def tile_size(job: SceneJob) -> int:
    """Edge of the tiles of a run's tile test, from its settings."""
    return int(job.provenance.get("config", {}).get("gate", {}).get("tile", 8))


def record_job(recorder: Recorder, job: SceneJob) -> None:
    """Record everything that one scene's job has measured, skipped or failed to do."""
    record_answers(recorder, job)
    record_eye_rays(recorder, job)
    times = group_times(job)
    record_times(recorder, job, times)
    record_ratios(recorder, job, times)
    timed = headline(times)
    limit = record_knobs(recorder, job, timed)
    record_trade(recorder, job, timed, limit)
    for model in job.models:
        for absence in job.absent(model):
            recorder.measure(
                subject_of(job, model, absence.tracer),
                "relative_bias",
                Interval(math.nan, math.nan, math.nan, 0),
                status=absence.status,
                note=absence.reason,
            )
        # What a tracer rendered before it failed is kept as files, but measures nothing.
        failed = {row.tracer for row in job.absent(model) if row.status == "failed"}
        tracers = [tracer for tracer in job.tracers(model) if tracer not in failed]
        if not tracers:
            continue
        truth = job.truth(model)
        record_truth(recorder, job, model, truth)
        for tracer in tracers:
            subject = subject_of(job, model, tracer)
            images = job.seeds(model, tracer)
            if images is not None and images.seeds:
                record_seeds(recorder, subject, images, truth, tile_size(job))
                # A known answer is one colour all over the image.
                if model == EXACT and not job.description.get("answers"):
                    record_spectra(recorder, subject, images, truth)
                own = timed.get((model, tracer))
                if own is not None:
                    record_efficiency(recorder, job, model, tracer, (images, truth, own))
            sets = job.convergence(model, tracer)
            if sets:
                record_convergence(recorder, subject, sets, truth)


def write_tables(results_dir: Path) -> tuple[Path, Path, Path]:
    """Write samples.parquet, measurements.csv and provenance.json; returns their paths.

    All three are written, whole, or none is.
    Raises ResultsError for missing or damaged files, SchemaError for a name that the closed lists
    do not know.
    """
    jobs = read_jobs(results_dir)
    recorder = Recorder()
    for job in jobs:
        record_job(recorder, job)
    parts: dict[str, dict[str, Provenance]] = {part: {} for part in PARTS}
    for ray_job in read_ray_jobs(results_dir):
        record_rays(recorder, ray_job)
        parts["rays"][ray_job.name] = ray_job.provenance
    for stability_job in read_stability_jobs(results_dir):
        record_stability(recorder, stability_job)
        parts["stability"][stability_job.name] = stability_job.provenance
    for modes_job in read_modes_jobs(results_dir):
        record_modes(recorder, modes_job)
        parts["modes"][modes_job.name] = modes_job.record["provenance"]
    surfaces_job = read_surfaces_job(results_dir)
    if surfaces_job is not None:
        record_surfaces(recorder, surfaces_job)
        parts["surfaces"]["all"] = surfaces_job.record["provenance"]
    sweeps_job = read_sweeps_job(results_dir)
    if sweeps_job is not None:
        record_sweeps(recorder, sweeps_job)
        parts["sweeps"]["all"] = sweeps_job.record["provenance"]
    for price_job in read_price_jobs(results_dir):
        record_prices(recorder, price_job)
        parts["features"][price_job.name] = price_job.provenance
    for study in read_study(results_dir):
        record_study(recorder, study)
        parts["study"][f"{study.name} {study.model}"] = study.provenance
    samples, measurements = recorder.frames()
    paths = (
        results_dir / "samples.parquet",
        results_dir / "measurements.csv",
        results_dir / "provenance.json",
    )
    provenance = merge_provenance({job.name: job.provenance for job in jobs}, parts)
    text = json.dumps(provenance, indent=1, sort_keys=True)
    with written_whole(*paths) as temporaries:
        samples.to_parquet(temporaries[0], index=False)
        measurements.to_csv(temporaries[1], index=False, float_format="%.9g", lineterminator="\n")
        temporaries[2].write_text(text + "\n")
    return paths
