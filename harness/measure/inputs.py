"""The files that a step of the workflow depends on, as paths relative to the repository.

Snakemake reruns a step when a file among its inputs changes; it does not look into what a command
imports, so the sources are inputs like any other.
"""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from harness.measure.config import ROOT, Config
from harness.scene.generated import generated_in
from harness.whole_files import PARTIAL

SOURCE_ENDINGS = frozenset({".py", ".h", ".cuh", ".cpp", ".yaml", ".j2", ".css", ".js", ".rst"})
PACKAGES = frozenset({"harness", "haste_cuda", "reference"})
"""What of the imported is ours."""


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


def module_sources(*modules: str) -> list[str]:
    """List the files of modules, of the packages that they lie in, and of all that these import.

    Imports are read, not carried out: those within functions count, and those of a name that is
    put together at run time are not seen.
    """
    found: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        module = waiting.pop()
        package = module.rpartition(".")[0]
        if module in found or module.partition(".")[0] not in PACKAGES:
            continue
        path = _path_of(module)
        if path is not None:
            found[module] = path
            waiting += [*([package] if package else []), *_imported(path)]
    return sorted({_relative(path) for path in found.values()})


def _path_of(module: str) -> Path | None:
    """The source of a module or package; None for a name within a module."""
    path = ROOT.joinpath(*module.split("."))
    candidates = (path / "__init__.py", path.with_suffix(".py"))
    return next((candidate for candidate in candidates if candidate.is_file()), None)


@cache
def _imported(path: Path) -> frozenset[str]:
    """Every name that a source imports, anywhere; what is imported from a package may be a module
    of it.
    """
    return frozenset(_names(ast.parse(path.read_text(encoding="utf-8"))))


def _names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


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
    # The registry imports a tracer by its name.
    tracers = [
        f"harness.tracers.{path.stem}"
        for path in (ROOT / "harness" / "tracers").glob("*.py")
        if path.stem != "__init__"
    ]
    sources = module_sources("harness.measure.job", *tracers)
    extension = extension_path()
    return sources + ([_relative(extension)] if extension else [])


def scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene: its folder but for prose and pictures, or its Mitsuba file.

    Files that a generator makes are listed also where they are yet to be made.
    """
    return {name: files_of_scene(path) for name, path in config.scenes.items()}


def ray_scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene of the benchmark of rays, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.ray_scenes.items()}


def price_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene whose features are priced, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.price_scenes.items()}


def stability_scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene whose mesh is tested, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.stability_scenes.items()}


def mode_scene_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene that is rendered in every precision, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.mode_scenes.items()}


def study_files(config: Config) -> dict[str, list[str]]:
    """List the files of each scene of the study of packets, see `scene_files`."""
    return {name: files_of_scene(path) for name, path in config.study_scenes.items()}


def files_of_scene(path: Path) -> list[str]:
    """List the files of one scene, see `scene_files`."""
    parts = path.rglob("*") if path.is_dir() else [path]
    files = {
        part
        for part in parts
        if part.is_file()
        and part.suffix not in {".md", ".png", ".pyc"}
        and not part.name.startswith(PARTIAL)
    }
    generated = generated_in(path)
    if generated is not None:
        files.update(generated.paths)
    return [_relative(file) for file in sorted(files)]
