"""The workflow as a user meets it: the command line, without rendering anything."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from harness.measure.config import ROOT


def snakemake(*arguments: str) -> subprocess.CompletedProcess[str]:
    # The lock of a run in the same folder is none of the tests' business.
    command = [sys.executable, "-m", "snakemake", "--nolock", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_a_dry_run_plans_two_jobs_a_scene_and_one_of_rays_then_tables_and_report(tmp_path: Path):
    done = snakemake("--dry-run", "--config", f"results_dir={tmp_path}")
    assert done.returncode == 0, done.stdout + done.stderr
    text = done.stdout + done.stderr
    for scene in ("cornell-box", "three-spheres", "skull", "mirror-glass", "hard"):
        assert f"{scene}: ground truth" in text, text
        assert f"{scene}: images and times of every tracer" in text, text
    for scene in ("skull", "bunny"):
        assert f"{scene}: the same rays through every tracer" in text, text
    assert "bumpy-16k: rays at its edges and vertices through every tracer" in text, text
    assert "Report of the run" in text and "Tables of the run" in text, text


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("scenes=no-such-scene", "unknown scene 'no-such-scene'"),
        ("tracers=[povray]", "config: tracers.0: 'povray' is not one of"),
    ],
)
def test_an_impossible_setting_stops_the_workflow_with_one_message(
    tmp_path: Path, setting: str, message: str
):
    done = snakemake("--dry-run", "--config", f"results_dir={tmp_path}", setting)
    text = done.stdout + done.stderr
    assert done.returncode != 0, text
    assert message in text, text
    assert "Traceback" not in text, text


def test_a_run_may_leave_the_rays_out(tmp_path: Path):
    settings = tmp_path / "settings.yaml"
    settings.write_text(f"results_dir: {tmp_path}\nscenes: [skull]\nrays: {{scenes: []}}\n")
    done = snakemake("--dry-run", "--configfile", str(settings))
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    assert "skull: ground truth" in text and "the same rays" not in text, text


def test_the_linter_finds_nothing():
    done = snakemake("--lint")
    assert done.returncode == 0, done.stdout + done.stderr


def test_timed_jobs_own_every_core():
    for rule in ("truth", "measure", "rays", "stability"):
        text = (ROOT / "harness" / "rules" / f"{rule}.smk").read_text()
        assert "threads: workflow.cores" in text, rule


def test_the_snakefile_stays_short():
    lines = (ROOT / "Snakefile").read_text().splitlines()
    assert len(lines) <= 40, len(lines)


def test_every_rule_that_runs_a_command_writes_a_log():
    for file in (ROOT / "harness" / "rules").glob("*.smk"):
        _, *blocks = re.split(r"^ *rule\b.*:$", file.read_text(), flags=re.MULTILINE)
        for block in blocks:
            if re.search(r"^ +shell:$", block, flags=re.MULTILINE):
                assert re.search(r"^ +log:$", block, flags=re.MULTILINE), f"{file.name}:{block}"
