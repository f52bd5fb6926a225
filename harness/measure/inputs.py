"""The files that a step of the workflow depends on, as paths relative to the repository.

Snakemake reruns a step when a file among its inputs changes; it does not look into what a command
imports, so the sources are inputs like any other.
"""

import sys
from pathlib import Path

from harness.measure.config import ROOT, Config

SOURCE_ENDINGS = frozenset({".py", ".h", ".cpp", ".cu", ".yaml", ".jinja", ".css", ".js", ".html"})
TRACING_PACKAGES = ("harness/scene", "harness/tracers", "harness/measure", "reference/mitsuba")
"""Python packages whose content decides what an image or a time is."""


def _relative(path: Path) -> str:
    return str(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)


def package_sources(*folders: str) -> list[str]:
    """List the sources below folders of the repository."""
    return [
        _relative(path)
        for folder in folders
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in SOURCE_ENDINGS
    ]


def extension_path() -> Path | None:
    """Find the compiled extension without importing it; None where it is not built."""
    for entry in (ROOT, *map(Path, sys.path)):
        for path in sorted(entry.glob("haste_cuda/_core*.so")):
            return path
    return None


def tracing_sources() -> list[str]:
    """List what images and times are made by: the Python sources and the compiled extension.

    The headers of the core are not among them, though kernels for the GPU are compiled from them
    at run time: whoever edits one builds the extension anew, whose file changes with it.
    """
    extension = extension_path()
    return package_sources(*TRACING_PACKAGES) + ([_relative(extension)] if extension else [])


def scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene: its folder but for prose and pictures, or its Mitsuba file."""
    files = {}
    for name, path in config.scenes.items():
        parts = sorted(path.rglob("*")) if path.is_dir() else [path]
        files[name] = [
            _relative(part)
            for part in parts
            if part.is_file() and part.suffix not in {".md", ".png", ".pyc"}
        ]
    return files
