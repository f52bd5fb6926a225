"""report.zip: the page with every image at full size, and all files that it leads to."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from harness.viewer.pack import write_full_size
from harness.whole_files import written_whole

FOLDER = "haste-report"
"""What the archive unpacks into."""
LONG_AGO = (1980, 1, 1, 0, 0, 0)
"""The date of every file: equal results give equal bytes."""

Images = list[tuple[str, list[tuple[str, str]]]]
"""By scene, the EXR files as path and name."""


def find_images(folder: Path) -> Images:
    """The EXR files below a folder, by scene."""
    found: dict[str, list[tuple[str, str]]] = {}
    for path in sorted(folder.glob("images/*/*/*.exr")):
        scene, model = path.parts[-3:-1]
        name = f"{model}, {path.stem}"
        found.setdefault(scene, []).append((path.relative_to(folder).as_posix(), name))
    return list(found.items())


def write_zip(path: Path, folder: Path) -> None:
    """Pack a folder: the same bytes for the same files. EXR files are compressed already."""
    with (
        written_whole(path) as (temporary,),
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for file in sorted(one for one in folder.rglob("*") if one.is_file()):
            entry = zipfile.ZipInfo(f"{FOLDER}/{file.relative_to(folder).as_posix()}", LONG_AGO)
            entry.external_attr = 0o644 << 16
            entry.compress_type = (
                zipfile.ZIP_STORED if file.suffix == ".exr" else zipfile.ZIP_DEFLATED
            )
            archive.writestr(entry, file.read_bytes())


def write_bundle(
    results_dir: Path,
    files: Sequence[Path],
    make_page: Callable[[Mapping[str, Any], Images], str],
) -> Path:
    """Write report.zip beside report.html; returns its path.

    files: what the page leads to, below results_dir. make_page: the page from the viewer's data and
    the EXR files. Raises ResultsError for missing or damaged files.
    """
    path = results_dir / "report.zip"
    with tempfile.TemporaryDirectory(prefix=".report-", dir=results_dir) as name:
        folder = Path(name)
        viewer = write_full_size(results_dir, folder)
        for file in files:
            place = folder / file.relative_to(results_dir)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, place)
        (folder / "report.html").write_text(make_page(viewer, find_images(folder)))
        write_zip(path, folder)
    return path
