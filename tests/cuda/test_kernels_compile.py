"""Every model's kernel compiles for every architecture, without a GPU and without spills.

Compilations run two at a time while the tests wait for their own; the cache of compiled kernels
makes a second run short.
"""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from faults import faults

from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings
from haste_cuda import _core

SCENES = sorted(
    path.parent
    for path in Path(__file__).parents[2].glob("scenes/*/scene.xml")
    # bumpy-16k with more triangles, and the same kernels.
    if path.parent.name not in ("bumpy-262k", "bumpy-4m")
)
ARCHITECTURES = (75, 80, 90, 100)
MODELS = ("haste", "whitted", "path")
ALL_FEATURES = (1 << len(_core.feature_names())) - 1
WORKERS = 2


@dataclass(frozen=True)
class Case:
    """A kernel with what it is compiled for."""

    model: str
    features: int
    stack: int = 1
    architecture: int = 90
    count_rays: bool = False
    kernel: str = "depth_first"
    film: str = "int64"
    layered: bool = False

    def compile(self, core: ModuleType, *, use_cache: bool = True) -> dict[str, Any]:
        return core.compile_kernel(
            self.kernel,
            self.model,
            "watertight",
            self.features,
            self.stack,
            self.film,
            self.layered,
            self.count_rays,
            architecture=self.architecture,
            use_cache=use_cache,
        )


FULL = [
    Case(model, ALL_FEATURES, 1 if model == "path" else 16, architecture)
    for model in MODELS
    for architecture in ARCHITECTURES
]
COUNTING = [Case(model, ALL_FEATURES, 1 if model == "path" else 16, 90, True) for model in MODELS]


@cache
def scene_cases(scene: Path) -> dict[str, Case]:
    """The kernels that renders of the scene ask for, by model."""
    settings = load_settings(scene)
    core_scene = to_core(load_scene(scene, width=16, height=16), 2)
    found = {}
    for model in settings.models:
        values = to_core_settings(settings.render(model, 16, 16))
        features = _core.required_features(core_scene, model, values)
        found[model] = Case(model, features, _core.stack_capacity(model, values, features))
    return found


@pytest.fixture(scope="module")
def kernels(core: ModuleType) -> Iterator[dict[Case, Future[dict[str, Any]]]]:
    """The compilations, by case; those of all features are under way from the start."""
    reason = core.nvrtc_unavailable()
    if reason is not None:
        pytest.skip(reason)
    with ThreadPoolExecutor(WORKERS) as pool:
        futures = {case: pool.submit(case.compile, core) for case in FULL + COUNTING}
        for scene in SCENES:
            for case in scene_cases(scene).values():
                if case not in futures:
                    futures[case] = pool.submit(case.compile, core)
        yield futures
        pool.shutdown(cancel_futures=True)


@pytest.mark.parametrize("case", FULL, ids=str)
def test_a_kernel_with_all_features_spills_nothing(
    kernels: dict[Case, Future[dict[str, Any]]], case: Case
):
    result = kernels[case].result()
    found = faults(result, blocks=1)
    assert not found, f"{case}: {found}\n{result['log']}"


@pytest.mark.parametrize("case", COUNTING, ids=str)
def test_a_kernel_that_counts_rays_spills_nothing(
    kernels: dict[Case, Future[dict[str, Any]]], case: Case
):
    result = kernels[case].result()
    found = faults(result, blocks=1)
    assert not found, f"{case}: {found}\n{result['log']}"


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.name)
def test_the_kernels_of_a_scene_spill_nothing(
    kernels: dict[Case, Future[dict[str, Any]]], scene: Path
):
    for case in scene_cases(scene).values():
        result = kernels[case].result()
        found = faults(result, blocks=1)
        assert not found, f"{scene.name}, {case}: {found}\n{result['log']}"


@pytest.mark.parametrize("model", MODELS)
def test_features_that_a_scene_lacks_cost_no_code(
    kernels: dict[Case, Future[dict[str, Any]]], model: str
):
    """The point of compiling for a scene's features: the box needs a fraction of the program."""
    box = next(scene for scene in SCENES if scene.name == "cornell-box")
    full = next(case for case in FULL if case.model == model and case.architecture == 90)
    sizes = [len(kernels[case].result()["cubin"]) for case in (scene_cases(box)[model], full)]
    assert sizes[0] < 0.9 * sizes[1], f"{model}: {sizes} bytes"


@pytest.mark.usefixtures("cache")
def test_a_cached_kernel_loads_in_a_tenth_of_its_compilation(compiler: ModuleType):
    case = Case("whitted", 0b1011, 4)
    first = case.compile(compiler)
    assert not first["cached"]
    loads = sorted(case.compile(compiler)["seconds"] for _ in range(5))
    assert loads[2] <= 0.1 * first["seconds"], f"median of {loads} s after {first['seconds']} s"


@pytest.mark.parametrize(
    ("setting", "names"),
    [
        ("kernel", "kernel_names"),
        ("model", "kernel_models"),
        ("precision", "kernel_precisions"),
        ("film", "kernel_films"),
    ],
)
def test_an_unknown_name_is_refused_with_the_known_ones(core: ModuleType, setting: str, names: str):
    arguments = {
        "kernel": "depth_first",
        "model": "path",
        "precision": "watertight",
        "film": "int64",
    }
    arguments[setting] = "no-such"
    with pytest.raises(ValueError, match="no-such") as raised:
        core.kernel_source(**arguments, features=1, stack_capacity=1)
    assert all(name in str(raised.value) for name in getattr(core, names)())


def test_a_stack_without_room_is_refused(core: ModuleType):
    with pytest.raises(ValueError, match="at least one ray, not 0"):
        core.kernel_source("depth_first", "path", "watertight", 1, 0)
