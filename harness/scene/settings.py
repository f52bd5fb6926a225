"""Render settings: what a scene file cannot hold, from the scene's settings.yaml."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import jsonschema
import yaml

from harness.scene.errors import SceneError
from harness.scene.records import Rgb

Model = Literal["path", "haste", "whitted"]

SCHEMA_FILE = Path(__file__).parents[1] / "schemas" / "settings.schema.yaml"


@dataclass(frozen=True, slots=True)
class RenderSettings:
    """Everything that an image depends on beside scene, seed and sample count. Each is explained in
    harness/schemas/settings.schema.yaml. Sizes are in pixels; `ambient` is linear sRGB radiance.
    """

    model: Model
    width: int
    height: int
    max_depth: int
    rr_depth: int
    max_layers: int
    light_samples: int
    ambient_samples: int
    ambient: Rgb


@dataclass(frozen=True, slots=True)
class EyeRays:
    """How many of an image's eye rays were published to hit, and how far a count may be off."""

    hits: int
    share: float


@dataclass(frozen=True, slots=True)
class Settings:
    """A scene's settings.yaml, with the schema's defaults where it is silent."""

    title: str
    models: tuple[Model, ...]
    max_depth: int
    rr_depth: int
    max_layers: int
    light_samples: int
    ambient_samples: int
    ambient: Rgb
    resolution: tuple[int, int]
    picture: tuple[int, int]
    caustic: bool
    recentre: bool
    answer: str
    eye_rays: EyeRays | None
    rays_inside: bool
    picture_parameters: Mapping[str, str]

    def render(
        self, model: Model, width: int | None = None, height: int | None = None
    ) -> RenderSettings:
        """Settings of one image: the measured resolution, unless `width` and `height` are given."""
        return RenderSettings(
            model=model,
            width=self.resolution[0] if width is None else width,
            height=self.resolution[1] if height is None else height,
            max_depth=self.max_depth,
            rr_depth=self.rr_depth,
            max_layers=self.max_layers,
            light_samples=self.light_samples,
            ambient_samples=self.ambient_samples,
            ambient=self.ambient,
        )


def load_settings(source: str | os.PathLike[str] | Mapping[str, Any]) -> Settings:
    """Settings of a scene folder, of the folder that an XML file lies in, of a .yaml file, or of a
    mapping of settings. Without a settings.yaml the schema's defaults hold.

    Raises `SceneError`, naming the file and every key that is unknown or has a bad value.
    """
    if isinstance(source, Mapping):
        return _settings("settings", source, title="")
    path = Path(source)
    file = path / "settings.yaml" if path.is_dir() else path
    if file.suffix == ".xml":
        file = file.with_name("settings.yaml")
    elif not file.is_file() and not path.is_dir():
        raise SceneError(os.fspath(source), [f"no such settings: {file} does not exist"])
    title = file.resolve().parent.name
    if not file.is_file():
        return _settings(os.fspath(file), {}, title=title)
    try:
        written = yaml.safe_load(file.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise SceneError(os.fspath(file), [f"not valid YAML: {error}"]) from error
    return _settings(os.fspath(file), {} if written is None else written, title=title)


@cache
def settings_schema() -> dict[str, Any]:
    """The JSON schema of settings.yaml."""
    schema: dict[str, Any] = yaml.safe_load(SCHEMA_FILE.read_text(encoding="utf-8"))
    return schema


def _settings(source: str, written: Any, *, title: str) -> Settings:
    schema = settings_schema()
    errors = sorted(
        jsonschema.Draft202012Validator(schema).iter_errors(written),
        key=lambda error: [str(part) for part in error.absolute_path],
    )
    if errors:
        raise SceneError(source, [_line(error) for error in errors])
    values = {name: rule["default"] for name, rule in schema["properties"].items()} | written
    return Settings(
        title=values["title"] or title,
        models=tuple(values["models"]),
        max_depth=values["max_depth"],
        rr_depth=values["rr_depth"],
        max_layers=values["max_layers"],
        light_samples=values["light_samples"],
        ambient_samples=values["ambient_samples"],
        ambient=_rgb(values["ambient"]),
        resolution=_size(values["resolution"]),
        picture=_size(values["picture"]),
        caustic=values["caustic"],
        recentre=values["recentre"],
        answer=values["answer"],
        eye_rays=EyeRays(**values["eye_rays"]) if values["eye_rays"] else None,
        rays_inside=values["rays_inside"],
        picture_parameters={
            name: str(value) for name, value in values["picture_parameters"].items()
        },
    )


def _rgb(values: list[float]) -> Rgb:
    return (float(values[0]), float(values[1]), float(values[2]))


def _size(values: list[int]) -> tuple[int, int]:
    return (int(values[0]), int(values[1]))


def _line(error: jsonschema.ValidationError) -> str:
    key = ".".join(str(part) for part in error.absolute_path)
    return f'key "{key}": {error.message}' if key else error.message
