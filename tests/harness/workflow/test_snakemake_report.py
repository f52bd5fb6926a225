"""Snakemake's own report of a run: every figure and table, in categories, with captions."""

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

from runs import Run, own_environment


def test_snakemakes_report_has_every_figure_and_table_with_a_caption(
    undisturbed: Run, tmp_path: Path
):
    path = tmp_path / "report.zip"
    command = [sys.executable, "-m", "snakemake", "--nolock", "--report", str(path)]
    done = subprocess.run(
        [*command, "--configfile", "settings.yaml"],
        cwd=undisturbed.folder,
        env=own_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "No files found for patterns" not in said, said
    with zipfile.ZipFile(path) as archive:
        packed = {Path(name).name for name in archive.namelist() if "/data/raw/" in name}
        page = archive.read("report/report.html").decode()
    assert not re.findall(r"""(?:src|href)=["']https?://""", page)
    found = value_of("results", page)
    listed = {Path(name).name: entry for name, entry in found.items()}
    wanted = {"report.html"} | {
        file.name
        for folder in ("figures", "tables")
        for file in (undisturbed.results / folder).iterdir()
        if not file.name.startswith(".")
    }
    assert wanted == set(listed) == packed
    for name, entry in listed.items():
        assert re.sub(r"<[^>]*>", "", entry["caption"]).strip(), f"{name} has no caption"
    categories = value_of("categories", page)
    assert {"Report", "Tables", "What speed costs", "Error", "Agreement"} <= set(categories)
    assert "Figures" not in categories, "a kind of figure without a category"


def value_of(variable: str, page: str) -> dict[str, Any]:
    """The JSON object that a script of the page begins with."""
    start = page.index(f"var {variable} = {{") + len(f"var {variable} = ")
    return json.JSONDecoder().raw_decode(page, start)[0]
