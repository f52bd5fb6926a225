"""Runs the generators of scenes/generators, which make the files that are not committed."""

import importlib
import shutil
import sys
import tempfile
from pathlib import Path

from harness.scene.generated import TABLE, GeneratedScene, generated_scenes
from harness.whole_files import written_whole

GENERATORS = TABLE.parent


def write_files(scene: GeneratedScene, folder: Path) -> list[Path]:
    """Run a scene's generator, which writes the scene's files below `folder`.

    The files are the same bytes each time. A generator is a module with a function
    ``generate(*files, **parameters)``.
    """
    if str(GENERATORS) not in sys.path:
        # Generators share modules that lie beside them.
        sys.path.insert(0, str(GENERATORS))
    module = importlib.import_module(scene.generator)
    files = [folder / file for file in scene.files]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
    module.generate(*files, **scene.parameters)
    return files


def generate_scene(scene: GeneratedScene) -> None:
    """Make the files of a scene anew; all are complete or not there, whenever this is stopped."""
    # Not beside the scene: what a killed process leaves there would count as files of the scene.
    with tempfile.TemporaryDirectory() as folder, written_whole(*scene.paths) as temporaries:
        made = write_files(scene, Path(folder))
        for file, temporary in zip(made, temporaries, strict=True):
            shutil.copyfile(file, temporary)


def generate_outdated() -> None:
    """Make the files of every shipped scene that lacks some, or has some older than a generator."""
    newest = max((path.stat().st_mtime for path in GENERATORS.glob("*.*")), default=0.0)
    for scene in generated_scenes().values():
        if scene.missing or min(path.stat().st_mtime for path in scene.paths) < newest:
            generate_scene(scene)
