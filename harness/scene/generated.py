"""Which files of the shipped scenes a generator makes: scenes/generators/generated.yaml, read."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

SCENES = Path(__file__).resolve().parents[2] / "scenes"
TABLE = SCENES / "generators" / "generated.yaml"


@dataclass(frozen=True, slots=True)
class GeneratedScene:
    """What is generated in one scene.

    generator: module of scenes/generators. files: what it writes, relative to `folder`, in the
    order in which its function `generate` takes them. parameters: its keyword arguments.
    """

    name: str
    folder: Path
    generator: str
    files: tuple[str, ...]
    parameters: Mapping[str, Any]

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files, with their folder."""
        return tuple(self.folder / file for file in self.files)

    @property
    def missing(self) -> tuple[str, ...]:
        """Those of `files` that are not there."""
        return tuple(file for file in self.files if not (self.folder / file).is_file())


@cache
def generated_scenes() -> dict[str, GeneratedScene]:
    """By name, the shipped scenes that have generated files; none where scenes/ is not shipped."""
    if not TABLE.is_file():
        return {}
    table = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return {
        name: GeneratedScene(
            name=name,
            folder=SCENES / name,
            generator=entry["generator"],
            files=tuple(entry["files"]),
            parameters=entry["parameters"],
        )
        for name, entry in table.items()
    }


def generated_in(folder: Path) -> GeneratedScene | None:
    """What is generated in a scene's folder; None where nothing is."""
    found = [scene for scene in generated_scenes().values() if scene.folder == folder.resolve()]
    return found[0] if found else None
