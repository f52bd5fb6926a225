"""Runs in a working directory of their own, one that takes seconds, and what two runs share."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from harness.measure.config import ROOT
from harness.tables import write_tables
from harness.tables.schema import load_list

SCENES = ("cornell-box", "three-spheres")
SPP = {"path": 4, "haste": 2, "whitted": 2}
PLAIN = {"path": 1, "haste": 1, "whitted": 1}
"""Factors of a scene that takes no more samples than others."""
SWEPT: dict[str, list[float]] = {
    **{
        key: [] for key in ("distance", "distance_recentred", "eye", "light_distance", "light_size")
    },
    **{key: [] for key in ("radiance", "grazing", "slivers", "phong", "depth", "samples")},
    "scale": [1.0],
    "triangles": [2],
}
SETTINGS: dict[str, Any] = {
    "preset": "small",
    "miniature": True,
    "scenes": list(SCENES),
    "models": ["whitted", "path"],
    "tracers": ["haste-cpu", "embree"],
    "resolution": [16, 16],
    "truth": {"spp": SPP},
    "seeds": {"count": 4, "spp": SPP},
    "convergence": {"doublings": 2, "seeds": 2, "most_seeds": 2},
    "timing": {"repeats": 2, "spp": SPP},
    "packets": {"scenes": ["cornell-box"], "models": ["path"], "sizes": [64, 4096], "repeats": 2},
    "engines": {"scenes": ["cornell-box"], "models": ["path"], "packets": [4096], "repeats": 2},
    "rays": {"scenes": []},
    "features": {"scenes": []},
    "stability": {
        "scenes": [],
        "modes": {"scenes": []},
        "surfaces": {"scales": [1.0], "eyes": [1.0], "gaps": [1.0e-5]},
        "sweeps": {"values": SWEPT, "images": 2},
    },
    "knobs": {
        "scenes": ["cornell-box"],
        "max_depth": [2],
        "rr_depth": [],
        "clamp": [1],
        "seeds": 3,
        "spp": {"path": 2, "haste": 1},
    },
    "scene_settings": {
        "cornell-box": {"truth_factor": PLAIN, "seeds_factor": PLAIN},
        "three-spheres": {
            "truth_factor": PLAIN,
            "seeds_factor": PLAIN,
            "convergence": {"seeds": 2, "most_seeds": 2},
        },
    },
}
COPIES = ("harness", "haste_cuda", "reference")
LINKS = ("Snakefile", "bench", "config", "profiles", "scenes", ".venv")
STAMPS = frozenset({"started", "ended", "host", "processor_seconds", "renders"})
"""What tells when and where rather than what; `renders` counts those of the last attempt."""
CLOCKED = frozenset(
    {
        *("speed_ratio", "speed_up", "paired_speed", "feature_price", "relmse_at"),
        *("determinism_price", "reallocation_price", "overlap", "n_half", "joules", "peak_bytes"),
        *("law_scatter", "law_runs_p_value", "law_kink_p_value", "law_kink_rays"),
        "law_kink_ratio",
    }
)
"""Quantities that a clock or a meter has a part in though no second stands in their unit."""


@dataclass(frozen=True)
class Run:
    """A working directory with its own .snakemake, so that no run of the repository's meets it."""

    folder: Path

    @property
    def results(self) -> Path:
        return self.folder / "out"

    def start(
        self,
        *arguments: str,
        log: str = "run.log",
        program: str = "bench",
        environment: Mapping[str, str] | None = None,
    ) -> subprocess.Popen[bytes]:
        """Begin `./bench all`, or plain Snakemake, in a process group of its own.

        What it says goes to a file.
        """
        settings = self.folder / "settings.yaml"
        bench = ["./bench", "all"]
        command = bench if program == "bench" else [sys.executable, "-m", program]
        with (self.folder / log).open("ab") as file:
            return subprocess.Popen(
                [*command, *arguments, "--configfile", str(settings)],
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                env={**own_environment(), **(environment or {})},
            )

    def run(self, *arguments: str) -> str:
        """Run to the end; what it said. Fails with that where the exit status is not 0."""
        before = len(self.said())
        process = self.start(*arguments)
        assert process.wait() == 0, self.said()[before:]
        return self.said()[before:]

    def said(self, log: str = "run.log") -> str:
        """What runs have said so far, one after the other."""
        path = self.folder / log
        return path.read_text(errors="replace") if path.exists() else ""


def own_environment() -> dict[str, str]:
    """The tests' own, with their interpreter, which finds the checkout's packages anywhere."""
    path = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), str(ROOT)]))
    return {**os.environ, "PYTHONPATH": path, "PYTHON": sys.executable}


def make_run(folder: Path, settings: Mapping[str, Any] | None = None) -> Run:
    """Make a working directory of the checkout's files; a small run by default.

    Sources are copies, that a test may change one.
    """
    folder.mkdir(parents=True)
    for name in COPIES:
        ignored = shutil.ignore_patterns("__pycache__", "*.cpp")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in LINKS:
        # A virtual environment may lie elsewhere.
        if (ROOT / name).exists():
            (folder / name).symlink_to(ROOT / name)
    run = Run(folder)
    values = {**(settings or SETTINGS), "results_dir": str(run.results)}
    (folder / "settings.yaml").write_text(yaml.safe_dump(values))
    return run


def finished(results: Path) -> dict[str, str]:
    """Hash of every finished batch: the truth's images, and those of tracers that have a record."""
    folder = results / "scenes"
    names = [*folder.glob("*/truth/*/batch_*.npy")]
    for record in [*folder.glob("*/seeds/*/*/*.json"), *folder.glob("*/convergence/*/*/*.json")]:
        names += [record, record.with_suffix(".npy")]
    return {
        str(name.relative_to(folder)): hashlib.sha256(name.read_bytes()).hexdigest()
        for name in names
    }


def tracers_images(results: Path) -> dict[str, bytes]:
    """Every image of a tracer that promises equal bits."""
    folder = results / "scenes"
    names = [*folder.glob("*/seeds/*/*/*.npy"), *folder.glob("*/convergence/*/*/*.npy")]
    return {
        str(name.relative_to(folder)): name.read_bytes()
        for name in names
        if not name.parent.name.startswith("mitsuba")
    }


def without_times(value: Any) -> Any:
    """A JSON value without what a clock has said."""
    if isinstance(value, dict):
        return {
            key: without_times(inner)
            for key, inner in value.items()
            if key not in STAMPS and "seconds" not in key
        }
    return [without_times(inner) for inner in value] if isinstance(value, list) else value


def records(results: Path) -> dict[str, Any]:
    """What the jobs have written down beside the images, without times."""
    names = ("scene.json", "measured.json", "skipped.json", "timing.json", "rays.json")
    found = {
        str(path.relative_to(results)): without_times(json.loads(path.read_text()))
        for name in names
        for path in (results / "scenes").glob(f"*/{name}")
    }
    # A resumed job takes its turns from where it is, so that rows may come in another order.
    return {
        name: sorted(rows, key=lambda row: json.dumps(row, sort_keys=True))
        if isinstance(rows, list)
        else rows
        for name, rows in found.items()
    }


def compare_mitsuba(one: Path, other: Path, tolerance: float) -> int:
    """Compare Mitsuba's images of two runs, the truth's and its own as a tracer; how many it were.

    Mitsuba adds light up in an order that differs from run to run: images agree within rounding,
    relative to the pixel, or to the mean of the image where that is brighter.
    """
    folder = one / "scenes"
    names = [*folder.glob("*/truth/*/batch_*.npy"), *folder.glob("*/*/*/mitsuba-*/*.npy")]
    for name in names:
        first, second = np.load(name), np.load(other / name.relative_to(one))
        apart = float((np.abs(first - second) / np.maximum(first, first.mean())).max())
        assert apart <= tolerance, f"{name.relative_to(one)}: {apart:.2g} > {tolerance:.2g}"
    return len(names)


def rows(results: Path, truth_of: Path, folder: Path, tracers: Sequence[str]) -> pd.DataFrame:
    """The rows of both tables that no clock has a part in, against the truth of another run.

    Equal images against truths that differ by rounding give numbers that differ by rounding;
    against one truth they give equal numbers.
    """
    shutil.copytree(results, folder, ignore=shutil.ignore_patterns("truth", "figures"))
    for scene in (folder / "scenes").iterdir():
        shutil.copytree(truth_of / "scenes" / scene.name / "truth", scene / "truth")
    write_tables(folder)
    tables = [
        pd.read_parquet(folder / "samples.parquet"),
        pd.read_csv(folder / "measurements.csv", keep_default_na=False, dtype=str),
    ]
    kept = [
        without_timings(table[table.tracer.isin([*tracers, "truth"])]).astype(str)
        for table in tables
    ]
    joined = pd.concat(kept, ignore_index=True)
    return joined.sort_values(list(joined.columns), ignore_index=True)


def is_timed(quantity: str) -> bool:
    """Whether a quantity of the closed list differs from run to run because a clock does."""
    unit = load_list("quantities")[quantity]["unit"]
    return quantity in CLOCKED or "s" in unit.replace("/", " ").split()


def without_timings(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of a table whose quantity no clock has a part in."""
    return table[~table.quantity.map(is_timed).astype(bool)]
