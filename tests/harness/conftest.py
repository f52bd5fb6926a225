"""Fabricated results: the files of a run, with images of known mean and variance."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fabricated_study import fabricate_study
from numpy.typing import NDArray

from harness.report.write import write_report
from harness.tables import write_tables

SPEED = {"haste-cpu": 4e5, "embree": 6e5, "mitsuba-llvm": 5e5, "haste-cuda": 2e7}
TITLES = {"cornell-box": "Cornell box", "mirror-glass": "Mirror and glass"}
NO_GPU = "no NVIDIA driver: libcuda.so.1 cannot be opened"


def fabricated_scene(size: int, model: str) -> NDArray[np.float64]:
    """A box with coloured walls, a light, a disk and a black band: [size, size, 3]."""
    y, x = np.mgrid[0:size, 0:size] / size
    image = np.stack([0.25 + 0.2 * y, 0.25 + 0.15 * y, 0.22 + 0.1 * y], axis=-1)
    image[x < 0.2] = [0.5, 0.06, 0.05]
    image[x > 0.8] = [0.08, 0.35, 0.07]
    disk = (x - 0.5) ** 2 + (y - 0.65) ** 2 < 0.03
    image[disk] *= (1.6 + np.cos(9.0 * x[disk]))[:, None]
    image[(y < 0.12) & (abs(x - 0.5) < 0.15)] = 8.0
    image[y > 0.94] = 0.0
    return image * {"path": 1.0, "haste": 1.7, "whitted": 1.2}[model]


def fabricated_noise(truth: NDArray[np.float64], model: str) -> NDArray[np.float64]:
    """Variance of a single sample: large for path, none but at edges for whitted."""
    if model != "whitted":
        return (0.9 if model == "path" else 0.3) * truth**2 * (truth < 5.0)
    edges = np.abs(np.gradient(truth, axis=1)) + np.abs(np.gradient(truth, axis=0))
    return 0.05 * np.minimum(edges, 0.5) ** 2


def fabricated_image(
    random: np.random.Generator, truth: NDArray[np.float64], variance: NDArray[np.float64], spp: int
) -> NDArray[np.float32]:
    """Mean of `spp` gamma-distributed samples; exactly the truth where there is no variance."""
    image = truth.copy()
    noisy = (variance > 0.0) & (truth > 0.0)
    shape = spp * truth[noisy] ** 2 / variance[noisy]
    image[noisy] = random.gamma(shape, truth[noisy] / shape)
    return image.astype(np.float32)


def _write(path: Path, value: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value))


def _save(stem: Path, image: NDArray[np.float32], **record: object) -> None:
    stem.parent.mkdir(parents=True, exist_ok=True)
    np.save(stem.with_suffix(".npy"), image)
    _write(stem.with_suffix(".json"), {"status": "ok", "note": "", "rays": None, **record})


def _timing(
    random: np.random.Generator, tracer: str, model: str, samples: int, **what: Any
) -> dict[str, Any]:
    spp = what["spp"]
    seconds = samples * spp / SPEED[tracer] * what.pop("slowdown", 1.0)
    own = not tracer.startswith("mitsuba")
    rays = {"camera": 1, "shadow": 3, "ambient": 4 if model == "haste" else 0, "bounce": 2}
    return {
        "tracer": tracer,
        "model": model,
        "engine": "depth_first",
        "precision": "native" if not own else "robust" if tracer == "embree" else "watertight",
        "case": {},
        "key": "0" * 64,
        "seed": 0,
        "seconds": seconds * random.lognormal(0.0, 0.02),
        "rays": {name: n * samples * spp for name, n in rays.items()} if own else None,
        "load_seconds": 0.12,
        **({"build_seconds": 0.034, "bvh_bytes": 81920.0} if own else {"compile_seconds": 1.9}),
        "status": "ok",
        "note": "",
        **what,
    }


ENGINES: tuple[tuple[str, dict[str, int]], ...] = (
    ("depth_first", {}),
    ("packets", {"packet": 65536}),
    ("layers", {"packet": 65536}),
    ("layers", {"packet": 1048576}),
)


def _timings(random: np.random.Generator, tracer: str, model: str, samples: int) -> list[Any]:
    rows = [_timing(random, tracer, model, samples, spp=64, repeat=k) for k in range(5)]
    if tracer != "haste-cpu":
        return rows
    for engine, case in ENGINES:
        rows += [
            _timing(
                *(random, tracer, model, samples),
                spp=16,
                repeat=k,
                engine=engine,
                case={"accumulation": "flat", **case},
                peak_queue_bytes=64.0 * case.get("packet", 0),
                slowdown=1.2,
            )
            for k in range(3)
        ]
    for exponent in range(4, 21):
        packet = 2**exponent
        for order in ("fifo", "lifo"):
            slowdown = 1.1 + 40.0 / packet + (packet / 2**19 if order == "fifo" else 0.0)
            rows += [
                _timing(
                    random,
                    tracer,
                    model,
                    samples,
                    spp=16,
                    repeat=k,
                    engine="packets",
                    case={"packet": packet, "order": order},
                    peak_queue_bytes=64.0 * packet * (3 if order == "fifo" else 1),
                    slowdown=slowdown,
                )
                for k in range(3)
            ]
    return rows


def fabricate(
    folder: Path,
    *,
    scenes: tuple[str, ...] = ("cornell-box", "mirror-glass"),
    models: tuple[str, ...] = ("path", "haste", "whitted"),
    size: int = 32,
    seeds: int = 8,
    batches: int = 16,
    spp: int = 64,
    changes: Mapping[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] | None = None,
    random_seed: int = 1,
) -> Path:
    """Write a results folder; `changes` maps a tracer to a change of the mean of its images."""
    changes = changes or {}
    random = np.random.default_rng(random_seed)
    for name in scenes:
        scene = folder / "scenes" / name
        timing: list[Any] = []
        skipped = []
        for model in models:
            mean = fabricated_scene(size, model)
            variance = fabricated_noise(mean, model)
            for batch in range(batches):
                path = scene / "truth" / model / f"batch_{batch:03d}.npy"
                path.parent.mkdir(parents=True, exist_ok=True)
                np.save(path, fabricated_image(random, mean, variance, 4 * spp))
            tracers = ("haste-cpu", "embree", "mitsuba-llvm")
            for tracer in tracers if model == "path" else tracers[:2]:
                own = changes.get(tracer, lambda image: image)(mean)
                for seed in range(seeds):
                    _save(
                        scene / "seeds" / model / tracer / f"seed_{seed:03d}",
                        fabricated_image(random, own, variance, spp),
                        seed=seed,
                        spp=spp,
                        seconds=size**2 * spp / SPEED[tracer],
                    )
                for doubling in range(7):
                    for seed in range(4):
                        _save(
                            scene
                            / "convergence"
                            / model
                            / tracer
                            / f"spp_{2**doubling}_seed_{seed}",
                            fabricated_image(random, own, variance, 2**doubling),
                            seed=10_000 + 1000 * doubling + seed,
                            spp=2**doubling,
                            seconds=size**2 * 2**doubling / SPEED[tracer] + 1e-4,
                        )
                timing += _timings(random, tracer, model, size**2)
            skipped += [
                {"tracer": tracer, "model": model, "status": "skipped", "reason": NO_GPU}
                for tracer in ("haste-cuda", "mitsuba-cuda")
            ]
            if model != "path":
                reason = "compared in the model path only"
                skipped.append(
                    {
                        "tracer": "mitsuba-llvm",
                        "model": model,
                        "status": "skipped",
                        "reason": reason,
                    }
                )
        _write(scene / "timing.json", timing)
        _write(scene / "skipped.json", skipped)
        _write(
            scene / "scene.json",
            {
                "name": name,
                "title": TITLES.get(name, name),
                "features": ["triangles", "mesh_lights"],
                "caustic": name == "mirror-glass",
                "resolution": [size, size],
                "triangles": 36,
                "spheres": 2,
                "films": [],
            },
        )
        _write(
            scene / "provenance.json",
            {
                "run": "fabricated",
                "commit": "0" * 40,
                "dirty": False,
                "started": "2000-01-01T00:00:00+00:00",
                "machine": {"processor": "none", "cores": 2, "gpus": []},
                "packages": {"numpy": np.__version__, "mitsuba": None},
                "config": {"scenes": list(scenes), "gate": {"tile": 8}},
                "scene": {"name": name, "sha256": "ab" * 32},
            },
        )
    return folder


FABRICATED_TURNS: tuple[tuple[dict[str, Any], float, float], ...] = (
    ({"max_depth": 64}, 1.0, 0.20),
    ({"max_depth": 2}, 0.7, 0.02),
    ({"max_depth": 8}, 0.97, 0.10),
    ({"max_depth": 64, "rr_depth": 5}, 1.0, 0.08),
    ({"max_depth": 64, "clamp": 10.0}, 0.9, 0.20),
    ({"max_depth": 64, "clamp": 1000.0}, 1.0, 0.20),
)
"""What was turned, the factor of the images' mean that is left, and seconds an image."""


def add_knobs(folder: Path, scene: str, *, seeds: int = 8, spp: int = 16, size: int = 32) -> Path:
    """Turn the knobs of `path` and `haste` in a fabricated scene, by Embree.

    Images of the same seed are the same but for the factor, those with roulette on their own.
    """
    random = np.random.default_rng(7)
    place = folder / "scenes" / scene
    mean = fabricated_scene(size, "path")
    noise = fabricated_noise(mean, "path")
    base = [fabricated_image(random, mean, noise, spp) for _ in range(seeds)]
    ways: list[tuple[str, dict[str, Any], list[Any], float]] = []
    for case, factor, seconds in FABRICATED_TURNS:
        own = [fabricated_image(random, mean, 1.5 * noise, spp) for _ in range(seeds)]
        images = own if "rr_depth" in case else [np.float32(factor) * one for one in base]
        ways.append(("path", case, images, seconds))
    mean = fabricated_scene(size, "haste")
    for samples, seconds in ((1, 0.01), (4, 0.03)):
        noise = fabricated_noise(mean, "haste") / samples
        images = [fabricated_image(random, mean, noise, spp) for _ in range(seeds)]
        case = {"light_samples": samples, "ambient_samples": samples}
        ways.append(("haste", case, images, seconds))
    for model, case, images, seconds in ways:
        name = "_".join(f"{key}-{value}" for key, value in sorted(case.items()))
        for seed, image in enumerate(images):
            _save(
                place / "knobs" / model / "embree" / name / f"seed_{seed:03d}",
                image,
                case=case,
                seed=seed,
                spp=spp,
                seconds=seconds * random.lognormal(0.0, 0.02),
            )
    film = {"film": "float_atomic", "max_depth": 64}
    reason = "embree has no choice of film"
    row = {"tracer": "embree", "model": "path", "case": film, "reason": reason}
    _write(place / "untaken.json", [row])
    description = json.loads((place / "scene.json").read_text())
    _write(place / "scene.json", description | {"settings": {"max_depth": 8}})
    provenance = json.loads((place / "provenance.json").read_text())
    provenance["config"]["knobs"] = {"exact_depth": 64}
    _write(place / "provenance.json", provenance)
    return folder


@pytest.fixture(scope="session")
def turned_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder of one scene whose knobs were turned; no test may change it."""
    folder = fabricate(tmp_path_factory.mktemp("turned"), scenes=("cornell-box",))
    return add_knobs(folder, "cornell-box")


@pytest.fixture
def fabricate_results(tmp_path: Path) -> Callable[..., Path]:
    """Write a results folder below tmp_path; arguments as of `fabricate`."""
    return lambda **arguments: fabricate(tmp_path / "results", **arguments)


@pytest.fixture(scope="session")
def fabricate_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The same for a folder that several tests read."""
    return lambda **arguments: fabricate(tmp_path_factory.mktemp("once"), **arguments)


@pytest.fixture(scope="session")
def fabricated_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small results folder that every test may read and none may change."""
    return fabricate(tmp_path_factory.mktemp("fabricated"))


@pytest.fixture(scope="session")
def written_results(fabricated_results: Path) -> Path:
    """The same with its tables."""
    write_tables(fabricated_results)
    return fabricated_results


@pytest.fixture(scope="session")
def written_report(written_results: Path) -> Path:
    """The page of the same, beside its figures and tables."""
    return write_report(written_results)


@pytest.fixture(scope="session")
def studied_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small results folder with a study of packets, for reading only."""
    folder = fabricate(
        tmp_path_factory.mktemp("studied"), scenes=("mirror-glass",), models=("haste",), size=16
    )
    return fabricate_study(folder, {"mirror-glass": ["haste", "whitted"]})
