"""What a run left behind, read once, for every section of its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.answers import AnswerVerdict, judge_answers
from harness.bounds import GateSettings, settings_of
from harness.gate import Absent, Judgement, compare_with_baseline, judge
from harness.regression import Regression
from harness.tables.lookup import Measurements, read_measurements
from harness.tables.rays import RayJob, read_ray_jobs
from harness.tables.read import SceneJob, read_jobs, read_json
from harness.tables.study import StudyJob, read_study

CAPTIONS = Path(__file__).resolve().parents[1] / "captions"


@dataclass(frozen=True, slots=True)
class Material:
    """A run's files, and what the gate says of them."""

    folder: Path
    jobs: list[SceneJob]
    measurements: Measurements
    settings: GateSettings
    judgements: list[Judgement]
    absent: list[Absent]
    answers: list[AnswerVerdict]
    changes: list[Regression]
    """against the baseline; empty without one"""
    ray_jobs: list[RayJob]
    studies: list[StudyJob]
    provenance: Mapping[str, Any]
    captions: Mapping[str, str]

    @property
    def pictured(self) -> list[SceneJob]:
        """Scenes with a picture to look at: a known answer is one colour all over the image."""
        return [job for job in self.jobs if not job.description.get("answers")]


def read_captions() -> dict[str, str]:
    """The texts of harness/captions, by name."""
    return {path.stem: path.read_text().strip() for path in sorted(CAPTIONS.glob("*.rst"))}


def read_material(results_dir: Path, baseline: Path | None = None) -> Material:
    """Read a results folder whose tables are written, and judge it.

    baseline: a folder that `./bench baseline` has written, or None to ask the truth only. Raises
    ResultsError for missing or damaged files.
    """
    jobs = read_jobs(results_dir)
    settings = settings_of(jobs)
    judgements, absent = judge(jobs, settings)
    return Material(
        folder=results_dir,
        jobs=jobs,
        measurements=read_measurements(results_dir / "measurements.csv"),
        settings=settings,
        judgements=judgements,
        absent=absent,
        answers=judge_answers(jobs),
        changes=compare_with_baseline(jobs, settings, baseline),
        ray_jobs=read_ray_jobs(results_dir),
        studies=read_study(results_dir),
        provenance=read_json(results_dir / "provenance.json"),
        captions=read_captions(),
    )
