"""Reader of the folder of one scene's job: results/<preset>/scenes/<scene>/."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.statistics.metrics import Truth, make_truth
from harness.tracers.registry import TRACERS

MODELS = ("path", "haste", "whitted")
"""Order of the models in every table and figure."""


class ResultsError(Exception):
    """A results folder is missing, empty or damaged; the message names the file."""


@dataclass(frozen=True, slots=True)
class ImageSet:
    """Independent images of one tracer at one sample count."""

    images: NDArray[np.float32]
    """[K, h, w, 3]"""
    seeds: tuple[int, ...]
    spp: int
    records: tuple[Mapping[str, Any], ...]
    """the JSON record beside each image"""
    failures: tuple[str, ...]
    """notes of seeds that failed"""

    @property
    def dropped(self) -> int:
        """Samples that are in none of the images, being no finite numbers."""
        return sum(int(record.get("non_finite", 0)) for record in self.records)


@dataclass(frozen=True, slots=True)
class Absence:
    """A tracer that has not done all of its work, and why."""

    tracer: str
    status: str
    """skipped or failed"""
    reason: str


def read_json(path: Path) -> Any:
    """Read a JSON file; raises ResultsError naming the file if it is missing or damaged."""
    try:
        return json.loads(path.read_text())
    except OSError as error:
        raise ResultsError(f"{path}: cannot be read ({error.strerror})") from error
    except json.JSONDecodeError as error:
        raise ResultsError(f"{path}: not JSON ({error})") from error


def read_image(path: Path, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Read an .npy image of the given shape; raises ResultsError naming the file."""
    try:
        image = np.load(path, allow_pickle=False)
    except (OSError, ValueError) as error:
        raise ResultsError(f"{path}: not a NumPy array ({error})") from error
    if image.shape != shape:
        raise ResultsError(f"{path}: shape {image.shape}, expected {shape}")
    return np.asarray(image, dtype=np.float32)


def tracer_order(name: str) -> tuple[int, str]:
    """Sort key of a tracer: its place in the registry, unknown names last."""
    names = list(TRACERS)
    return (names.index(name) if name in names else len(names), name)


def model_order(name: str) -> tuple[int, str]:
    """Sort key of a model."""
    return (MODELS.index(name) if name in MODELS else len(MODELS), name)


@dataclass(frozen=True, slots=True)
class SceneJob:
    """The files of one scene's job. Images are read when they are asked for."""

    folder: Path
    name: str
    title: str
    caustic: bool
    width: int
    height: int
    description: Mapping[str, Any]
    """scene.json"""
    provenance: Mapping[str, Any]
    timing: Sequence[Mapping[str, Any]]
    skipped: Sequence[Mapping[str, str]]
    untrue: Mapping[str, str]
    """models without a ground truth, and why: their images have nothing to be compared with"""

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.provenance)

    @property
    def miniature(self) -> bool:
        """Whether the run tried the machinery, with too few images for some questions."""
        return bool(self.provenance.get("config", {}).get("miniature", False))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of an image."""
        return (self.height, self.width, 3)

    @property
    def models(self) -> list[str]:
        """Models with a truth or images, in the order of the tables."""
        found = {path.name for kind in ("truth", "seeds") for path in self._folders(kind)}
        found |= {str(row["model"]) for row in [*self.timing, *self.skipped]} | set(self.untrue)
        return sorted(found, key=model_order)

    def _folders(self, kind: str) -> list[Path]:
        return [path for path in (self.folder / kind).glob("*") if path.is_dir()]

    def tracers(self, model: str) -> list[str]:
        """Tracers with images of a model that can be judged, in the order of the registry."""
        if model in self.untrue:
            return []
        found = self._rendered(model)
        return sorted(found, key=tracer_order)

    def _rendered(self, model: str) -> set[str]:
        """Tracers with images of a model."""
        return {
            path.name
            for kind in ("seeds", "convergence")
            for path in (self.folder / kind / model).glob("*")
            if path.is_dir() and any(path.iterdir())
        }

    def absent(self, model: str) -> list[Absence]:
        """Tracers that were skipped, failed, or cannot be judged in a model, in the order of the
        registry.
        """
        rows = [
            Absence(str(row["tracer"]), str(row.get("status", "skipped")), str(row["reason"]))
            for row in self.skipped
            if row["model"] == model
        ]
        if model in self.untrue:
            reason = f"no ground truth: {self.untrue[model]}"
            named = {row.tracer for row in rows}
            rows += [Absence(tracer, "skipped", reason) for tracer in self._rendered(model) - named]
        return sorted(rows, key=lambda row: tracer_order(row.tracer))

    def truth(self, model: str) -> Truth:
        """The ground truth of a model; raises ResultsError if its batches are missing."""
        folder = self.folder / "truth" / model
        paths = sorted(folder.glob("batch_*.npy"))
        if len(paths) < 2:
            raise ResultsError(f"{folder}: {len(paths)} batches of truth, at least 2 are needed")
        return make_truth(np.stack([read_image(path, self.shape) for path in paths]))

    def seeds(self, model: str, tracer: str) -> ImageSet | None:
        """Independent images of a tracer, or None if there is not even a failure."""
        return self._image_set(sorted((self.folder / "seeds" / model / tracer).glob("seed_*.json")))

    def convergence(self, model: str, tracer: str) -> dict[int, ImageSet]:
        """Images of a tracer at several sample counts, by count."""
        folder = self.folder / "convergence" / model / tracer
        by_count: dict[int, list[Path]] = {}
        for path in sorted(folder.glob("spp_*_seed_*.json")):
            by_count.setdefault(int(path.stem.split("_")[1]), []).append(path)
        sets = {spp: self._image_set(paths) for spp, paths in sorted(by_count.items())}
        return {spp: found for spp, found in sets.items() if found and found.seeds}

    def knobs(self, model: str, tracer: str) -> list[tuple[dict[str, Any], ImageSet]]:
        """Images of a tracer by what was turned, in the order of the names of their folders."""
        found = []
        for folder in sorted((self.folder / "knobs" / model / tracer).glob("*")):
            images = self._image_set(sorted(folder.glob("seed_*.json")))
            if images is not None and images.seeds:
                found.append((dict(images.records[0]["case"]), images))
        return found

    @property
    def untaken(self) -> Sequence[Mapping[str, Any]]:
        """Turns of knobs that a tracer has not: tracer, model, case and reason."""
        path = self.folder / "untaken.json"
        return read_json(path) if path.exists() else []

    def _image_set(self, paths: list[Path]) -> ImageSet | None:
        if not paths:
            return None
        records, images, seeds, failures = [], [], [], []
        for path in paths:
            record = read_json(path)
            if record.get("status", "ok") != "ok":
                failures.append(str(record.get("note", "failed without a note")))
                continue
            images.append(read_image(path.with_suffix(".npy"), self.shape))
            seeds.append(int(record.get("seed", path.stem.split("_")[-1])))
            records.append(record)
        counts = {int(record["spp"]) for record in records}
        if len(counts) > 1:
            raise ResultsError(f"{paths[0].parent}: images of different sample counts {counts}")
        stack = np.stack(images) if images else np.zeros((0, *self.shape), np.float32)
        return ImageSet(
            stack, tuple(seeds), counts.pop() if counts else 0, tuple(records), tuple(failures)
        )


def read_job(folder: Path) -> SceneJob:
    """Read the description of one scene's job; raises ResultsError."""
    description = read_json(folder / "scene.json")
    width, height = description["resolution"]
    timing, skipped = folder / "timing.json", folder / "skipped.json"
    truth = folder / "truth.json"
    untrue = read_json(truth).get("skipped", []) if truth.exists() else []
    return SceneJob(
        folder=folder,
        name=str(description.get("name", folder.name)),
        title=str(description.get("title") or description.get("name", folder.name)),
        caustic=bool(description.get("caustic", False)),
        width=int(width),
        height=int(height),
        description=description,
        provenance=read_json(folder / "provenance.json"),
        timing=read_json(timing) if timing.exists() else [],
        skipped=read_json(skipped) if skipped.exists() else [],
        untrue={str(row["model"]): str(row["reason"]) for row in untrue},
    )


def run_name(provenance: Mapping[str, Any]) -> str:
    """Name of the run of a job, which joins rows to the provenance."""
    return str(provenance.get("run", "unnamed"))


def section_of_run(results_dir: Path, *keys: str) -> Mapping[str, Any]:
    """A section of a run's settings, or a section of that; empty where there is none.

    Raises
    ------
    ResultsError
        settings.json is damaged.
    """
    settings = results_dir / "settings.json"
    section: Mapping[str, Any] = read_json(settings) if settings.exists() else {}
    for key in keys:
        section = section.get(key, {})
    return section


def scenes_of_section(results_dir: Path, *keys: str) -> list[str]:
    """Names of the scenes of a section of a run's settings, in their order; none without it.

    Folders of scenes that it does not name are those of earlier runs, and left alone.
    """
    return scene_names(section_of_run(results_dir, *keys).get("scenes", []))


def scenes_of_run(results_dir: Path) -> list[str] | None:
    """Names of the scenes that the settings.json of a results folder names, None without one."""
    settings = results_dir / "settings.json"
    if not settings.exists():
        return None
    return scene_names(read_json(settings).get("scenes", []))


def scene_names(scenes: str | Sequence[str]) -> list[str]:
    """What jobs call scenes of a run's settings: by their folder, or by their file's stem."""
    paths = [Path(scene) for scene in ([scenes] if isinstance(scenes, str) else scenes)]
    folders = [path.parent if path.name == "scene.xml" else path for path in paths]
    return [path.stem if path.suffix == ".xml" else path.name for path in folders]


def scenes_of_study(results_dir: Path) -> list[tuple[str, str]]:
    """Scene and model of each study of packets that the settings.json of a folder names."""
    study = section_of_run(results_dir, "study")
    elsewhere = study.get("elsewhere", {})
    panels = [*study.get("panels", {}).items()]
    panels += [(name, elsewhere["models"]) for name in elsewhere.get("scenes", [])]
    found = [(scene_names([name])[0], model) for name, models in panels for model in models]
    return list(dict.fromkeys(found))


def read_jobs(results_dir: Path) -> list[SceneJob]:
    """Read the scene jobs of a run; raises ResultsError if there is not one for each scene of its
    settings, or none where there are no settings.

    Only scenes that the run's settings.json names count: folders of earlier runs are left alone.
    Without that file all do. They come in the order of the run's settings, or of the provenance, or
    by name.
    """
    wanted = scenes_of_run(results_dir)
    if wanted == []:
        return []
    folders = sorted(path.parent for path in (results_dir / "scenes").glob("*/scene.json"))
    if not folders:
        raise ResultsError(f"{results_dir / 'scenes'}: no scene job has been written here")
    if wanted is not None:
        lost = [name for name in wanted if name not in {folder.name for folder in folders}]
        if lost:
            raise ResultsError(
                f"{results_dir / 'scenes'}: no scene job of {', '.join(lost)}, which "
                "settings.json names; is the run complete?"
            )
        folders = [folder for folder in folders if folder.name in wanted]
    jobs = [read_job(folder) for folder in folders]
    order = wanted or scene_names(jobs[0].provenance.get("config", {}).get("scenes", []))
    return sorted(
        jobs, key=lambda job: (order.index(job.name) if job.name in order else len(order), job.name)
    )
