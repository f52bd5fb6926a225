"""The files that a step of the workflow depends on, as paths relative to the repository.

Snakemake reruns a step when a file among its inputs changes; it does not look into what a command
imports, so the sources are inputs like any other.
"""

import sys
from pathlib import Path

from harness.measure.config import ROOT, Config
from harness.scene.generated import generated_in

SOURCE_ENDINGS = frozenset({".py", ".h", ".cuh", ".cpp", ".yaml", ".j2", ".css", ".rst"})
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
    single = ["harness/eye_rays.py", "reference/pinhole.py"]
    sources = package_sources(*TRACING_PACKAGES) + single
    return sources + ([_relative(extension)] if extension else [])


def scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene: its folder but for prose and pictures, or its Mitsuba file.

    Files that a generator makes are listed also where they are yet to be made.
    """
    return {name: files_of_scene(path) for name, path in config.scenes.items()}


def study_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene of the study of packets, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.study_scenes.items()}


def files_of_scene(path: Path) -> list[str]:
    """List the files of one scene, see `scene_files`."""
    parts = path.rglob("*") if path.is_dir() else [path]
    files = {
        part for part in parts if part.is_file() and part.suffix not in {".md", ".png", ".pyc"}
    }
    generated = generated_in(path)
    if generated is not None:
        files.update(generated.paths)
    return [_relative(file) for file in sorted(files)]
