"""A run's settings: read, merged over the default preset, checked and typed."""

import json
import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match

ROOT = Path(__file__).resolve().parents[2]
DEFAULT_PRESET = ROOT / "config" / "quick.yaml"
SCHEMA = ROOT / "harness" / "schemas" / "config.schema.yaml"
CONVERGENCE_SEED = 10_000
"""First seed of the convergence images: apart from those of the variance and of the truth."""
DOUBLINGS = 6
"""Fewer doublings do not tell a slope of -1 from one that flattens."""


class ConfigError(Exception):
    """A setting cannot be used; the message names it and its value."""


def find_scene(name: str, root: Path = ROOT) -> Path:
    """Find a scene: a folder of scenes/ by its name, or a Mitsuba file by its path.

    Raises
    ------
    ConfigError
        There is neither; the message lists the scenes that there are.
    """
    folder = root / "scenes" / name
    if (folder / "scene.xml").is_file():
        return folder
    file = Path(name) if Path(name).is_absolute() else root / name
    if file.suffix == ".xml" and file.is_file():
        return file.parent if file.name == "scene.xml" else file
    if (file / "scene.xml").is_file():
        return file
    raise ConfigError(
        f"unknown scene {name!r}: neither scenes/{name}/scene.xml nor a Mitsuba file; "
        f"the scenes are {', '.join(standard_scenes(root)) or 'none yet'}"
    )


def standard_scenes(root: Path = ROOT) -> list[str]:
    """Names of the folders below scenes/ that hold a scene, as settings name them."""
    folder = root / "scenes"
    found = [*folder.glob("*/scene.xml"), *folder.glob("analytic/*/scene.xml")]
    return sorted(path.parent.relative_to(folder).as_posix() for path in found)


def scene_name(path: Path) -> str:
    """Name a scene found by `find_scene`: the folder's, or the file's without its ending."""
    return path.stem if path.suffix == ".xml" else path.name


@dataclass(frozen=True, slots=True)
class Config:
    """The settings of one run, checked. `values` follows harness/schemas/config.schema.yaml."""

    values: dict[str, Any]

    def __getitem__(self, key: str) -> Any:
        return self.values[key]

    @property
    def results_dir(self) -> Path:
        """Where the run is written."""
        return ROOT / self.values["results_dir"]

    @property
    def scenes(self) -> dict[str, Path]:
        """Name and place of each scene, in the order of the settings."""
        found = [find_scene(scene) for scene in self.values["scenes"]]
        return {scene_name(path): path for path in found}

    @property
    def ray_scenes(self) -> dict[str, Path]:
        """Name and place of each scene of the benchmark of rays, in the order of the settings."""
        found = [find_scene(scene) for scene in self.values["rays"]["scenes"]]
        return {scene_name(path): path for path in found}

    @property
    def stability_scenes(self) -> dict[str, Path]:
        """Name and place of each scene whose mesh is tested, in the order of the settings."""
        found = [find_scene(scene) for scene in self.values["stability"]["scenes"]]
        return {scene_name(path): path for path in found}

    def stability_dir(self, scene: str) -> Path:
        """Where what came of the tests of a scene's mesh is written."""
        return self.results_dir / "stability" / scene

    @property
    def mode_scenes(self) -> dict[str, Path]:
        """Name and place of each scene that is rendered in every precision."""
        found = [find_scene(scene) for scene in self.values["stability"]["modes"]["scenes"]]
        return {scene_name(path): path for path in found}

    @property
    def surfaces_file(self) -> Path:
        """Where what came of rays that leave surfaces is written."""
        return self.results_dir / "stability" / "surfaces.json"

    def modes_file(self, scene: str) -> Path:
        """Where what came of a scene in every precision is written."""
        return self.results_dir / "stability" / "modes" / f"{scene}.json"

    def ray_dir(self, scene: str) -> Path:
        """Where the rays of a scene, and what came of them, are written."""
        return self.results_dir / "rays" / scene

    @property
    def price_scenes(self) -> dict[str, Path]:
        """Name and place of each scene whose features are priced, in the order of the settings."""
        found = [find_scene(scene) for scene in self.values["features"]["scenes"]]
        return {scene_name(path): path for path in found}

    def price_dir(self, scene: str) -> Path:
        """Where the prices of a scene's features are written."""
        return self.results_dir / "features" / scene

    def scene_dir(self, scene: str) -> Path:
        """Where the files of one scene's job are written."""
        return self.results_dir / "scenes" / scene

    def has_answer(self, scene: str) -> bool:
        """Whether the radiance of a scene is known; raises SceneError for unusable settings."""
        from harness.scene import load_settings

        return bool(load_settings(self.scenes[scene]).answer)

    def resolution(self, scene: str) -> tuple[int | None, int | None]:
        """Width and height of a scene's images, None where the scene's own are meant.

        A scene with a known answer keeps its own: the answer holds for a patch that its few pixels
        show, and more of them would show nothing else.
        """
        if self.has_answer(scene):
            return None, None
        own = self.values["scene_settings"].get(scene, {}).get("resolution")
        width, height = own or self.values.get("resolution") or (None, None)
        return width, height

    def _scene_spp(self, key: str, scene: str, model: str) -> int:
        """A count of the preset, `truth` or `seeds`, as many times as the scene needs it."""
        own = self.values["scene_settings"].get(scene, {}).get(f"{key}_factor", {})
        kind = "answers" if self.has_answer(scene) else key
        return math.ceil(self.values[kind]["spp"][model] * own.get(model, 1))

    def truth_spp(self, scene: str, model: str) -> int:
        """Samples a pixel of one batch of the truth."""
        return self._scene_spp("truth", scene, model)

    def seeds_spp(self, scene: str, model: str, tracer: str) -> int:
        """Samples a pixel of one of a tracer's independent images.

        A slow tracer's own share comes before what a noisy scene needs. The few pixels of a scene
        with a known answer are no burden to any tracer.
        """
        spp = self._scene_spp("seeds", scene, model)
        if self.has_answer(scene):
            return spp
        share = self.values["tracer_settings"].get(tracer, {}).get("seeds_spp", {})
        return int(share.get(model, spp))

    def timing_spp(self, model: str, tracer: str) -> int:
        """Samples a pixel of a timed render."""
        own = self.values["tracer_settings"].get(tracer, {}).get("timing_spp", {})
        return own.get(model, self.values["timing"]["spp"][model])

    def knobs_spp(self, model: str, tracer: str) -> int:
        """Samples a pixel of an image of the sweep of knobs."""
        own = self.values["tracer_settings"].get(tracer, {}).get("knobs_spp", {})
        return int(own.get(model, self.values["knobs"]["spp"][model]))

    def packet_sizes(self, tracer: str) -> list[int]:
        """Sizes of the sweep of packets."""
        least = self.values["tracer_settings"].get(tracer, {}).get("least_packet", 1)
        return [size for size in self.values["packets"]["sizes"] if size >= least]

    @property
    def study_scenes(self) -> dict[str, Path]:
        """Name and place of each scene of the study of packets, in the order of the settings."""
        elsewhere = self.values["study"]["elsewhere"]["scenes"]
        found = [find_scene(scene) for scene in (*self.values["study"]["panels"], *elsewhere)]
        return {scene_name(path): path for path in found}

    @property
    def study_panels(self) -> list[tuple[str, str]]:
        """Scene and model of each job of the study of packets."""
        study = self.values["study"]
        panels = [(name, model) for name, models in study["panels"].items() for model in models]
        elsewhere = study["elsewhere"]
        panels += [(name, model) for name in elsewhere["scenes"] for model in elsewhere["models"]]
        return list(dict.fromkeys(panels))

    def study_dir(self, scene: str, model: str) -> Path:
        """Where the files of one job of the study of packets are written."""
        return self.results_dir / "study" / scene / model

    def study_sizes(self, tracer: str, scene: str, model: str) -> list[int]:
        """Rays in a launch: all sizes where a panel is the study's own, a few elsewhere."""
        study = self.values["study"]
        own = model in study["panels"].get(scene, [])
        limits = self.values["tracer_settings"].get(tracer, {})
        sizes = study["sizes"] if own else study["elsewhere"]["sizes"]
        least, most = limits.get("least_packet", 1), limits.get("most_packet", max(sizes))
        return [size for size in sizes if least <= size <= most]

    def _convergence(self, scene: str) -> dict[str, Any]:
        own = self.values["scene_settings"].get(scene, {}).get("convergence", {})
        return self.values["convergence"] | own

    def converges(self, scene: str, model: str, tracer: str) -> bool:
        """Whether a tracer takes part in the convergence images of a scene in a model."""
        takes_part = self.values["tracer_settings"].get(tracer, {}).get("convergence", True)
        return takes_part and model in self._convergence(scene)["models"]

    def convergence_seeds(self, scene: str, doubling: int) -> int:
        """Independent images of 2^doubling samples a pixel."""
        sizes = self._convergence(scene)
        equal_samples = sizes["seeds"] * 2 ** (sizes["doublings"] - doubling)
        return min(equal_samples, max(sizes["seeds"], sizes["most_seeds"]))


def merge(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Merge settings as Snakemake merges its config files: mappings key by key, the rest whole."""
    merged = deepcopy(dict(base))
    for key, value in changes.items():
        if isinstance(value, Mapping) and isinstance(merged.get(key), Mapping):
            merged[key] = merge(merged[key], value)
        else:
            merged[key] = deepcopy(value)
    return merged


def check_config(values: Mapping[str, Any]) -> Config:
    """Check settings and fill in what they leave out.

    Raises
    ------
    ConfigError
        The first setting that is impossible, with its place and value.
    """
    schema = yaml.safe_load(SCHEMA.read_text())
    error = best_match(Draft202012Validator(schema).iter_errors(dict(values)))
    if error is not None:
        place = ".".join(str(part) for part in error.absolute_path) or "the settings"
        raise ConfigError(f"config: {place}: {error.message}")
    checked = deepcopy(dict(values))
    for key, default in (("miniature", False), ("timeout_seconds", 900.0)):
        checked.setdefault(key, default)
    for key in ("scene_settings", "tracer_settings"):
        checked.setdefault(key, {})
    checked["truth"].setdefault("seed", 1_000_000)
    if isinstance(checked["scenes"], str):
        checked["scenes"] = [checked["scenes"]]
    if not checked["miniature"]:
        doublings = checked["convergence"]["doublings"]
        if doublings < DOUBLINGS:
            raise ConfigError(
                f"config: convergence.doublings: {doublings} is less than {DOUBLINGS}, "
                "unless `miniature: true`"
            )
    config = Config(checked)
    _check_names("scenes", checked["scenes"])
    _check_names("rays.scenes", checked["rays"]["scenes"])
    _check_names("features.scenes", checked["features"]["scenes"])
    _check_names("stability.scenes", checked["stability"]["scenes"])
    _check_names("stability.modes.scenes", checked["stability"]["modes"]["scenes"])
    known = {*config.scenes, *(Path(name).name for name in standard_scenes())}
    for key, names in (
        ("scene_settings", checked["scene_settings"]),
        ("packets.scenes", checked["packets"]["scenes"]),
        ("engines.scenes", checked["engines"]["scenes"]),
        ("study.panels", checked["study"]["panels"]),
        ("study.elsewhere.scenes", checked["study"]["elsewhere"]["scenes"]),
        ("knobs.scenes", checked["knobs"]["scenes"]),
    ):
        for name in names:
            if name not in known:
                raise ConfigError(f"config: {key}: there is no scene {name!r}")
    return config


def _check_names(key: str, scenes: Sequence[str]) -> None:
    """Refuse two scenes whose results would go into one folder."""
    first: dict[str, str] = {}
    for scene in scenes:
        name = scene_name(find_scene(scene))
        if name in first:
            raise ConfigError(
                f"config: {key}: {first[name]!r} and {scene!r} have the same name, {name!r}"
            )
        first[name] = scene


def load_config(path: Path | None = None) -> Config:
    """Read settings from a YAML or JSON file, over those of config/quick.yaml.

    Raises
    ------
    ConfigError
        The file cannot be read, or a setting in it cannot be used.
    """
    values = yaml.safe_load(DEFAULT_PRESET.read_text())
    if path is not None:
        try:
            # Not every number of JSON is one of YAML 1.1: 1e-06 is a string there.
            read = json.loads if path.suffix == ".json" else yaml.safe_load
            changes = read(path.read_text())
        except (OSError, ValueError, yaml.YAMLError) as error:
            raise ConfigError(f"{path}: {error}") from error
        if not isinstance(changes, dict):
            raise ConfigError(f"{path}: not a mapping of settings")
        values = merge(values, changes)
    return check_config(values)
