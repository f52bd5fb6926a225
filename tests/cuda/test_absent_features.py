"""A kernel holds nothing of a feature that its scene does not require.

Every header that belongs to absent features alone is replaced by one that stops the compiler; what
is compiled must then be the same cubin, byte for byte. No GPU is needed.
"""

from __future__ import annotations

import hashlib
import re
import shutil
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from types import ModuleType

import pytest

from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings
from haste_cuda import _core

ROOT = Path(__file__).parents[2]
HEADERS = ROOT / "haste_cuda"
SCENES = sorted(
    path.parent
    for path in ROOT.glob("scenes/**/scene.xml")
    # bumpy-16k with more triangles, and the same kernel.
    if path.parent.name not in ("bumpy-262k", "bumpy-4m")
)
EVERY_ENGINE_ON = "three-spheres"
NAMES = _core.feature_names()
STOP = '#error "a feature that the scene lacks"\n'
WORKERS = 2
WITH_A_STACK = ("depth_first", "persistent")


@dataclass(frozen=True)
class Program:
    """A kernel with what decides its source."""

    kernel: str
    model: str
    features: int
    stack: int
    traversal: str = "bvh2"

    @property
    def source(self) -> str:
        stack = self.stack if self.kernel in WITH_A_STACK else 1
        return _core.kernel_source(
            *(self.kernel, self.model, "watertight", self.features, stack),
            traversal=self.traversal,
        )

    def __str__(self) -> str:
        names = ",".join(name for i, name in enumerate(NAMES) if self.features >> i & 1)
        return f"{self.kernel}-{self.model}-{self.traversal}-{names}-{self.stack}"


@dataclass(frozen=True)
class Use:
    """A kernel that a render of a scene asks for, named without loading the scene."""

    scene: Path
    model: str
    kernel: str = "depth_first"
    traversal: str = "bvh2"

    def program(self) -> Program:
        settings = load_settings(self.scene)
        scene = load_scene(self.scene, width=16, height=16, recentre=settings.recentre)
        core_scene = to_core(scene, 2)
        values = to_core_settings(settings.render(self.model, 16, 16))
        features = _core.required_features(core_scene, self.model, values)
        stack = _core.stack_capacity(self.model, values, features)
        return Program(self.kernel, self.model, features, stack, self.traversal)

    def __str__(self) -> str:
        return f"{self.scene.name}-{self.kernel}-{self.model}-{self.traversal}"


def model_of(scene: Path) -> str:
    """The model with the most code of those that a scene claims."""
    models = load_settings(scene).models
    return next(model for model in ("path", "haste", "whitted") if model in models)


def includes(header: str) -> set[str]:
    """Headers of ours that a header includes, by their paths below haste_cuda/."""
    text = (HEADERS / header).read_text()
    return set(re.findall(r'^#include "((?:core|cuda)/[^"]+)"', text, flags=re.MULTILINE))


def reached(source: str) -> set[str]:
    """Headers that a translation unit includes, directly or not."""
    waiting = set(re.findall(r'^#include "([^"]+)"', source, flags=re.MULTILINE))
    found: set[str] = set()
    while waiting:
        header = waiting.pop()
        found.add(header)
        waiting |= includes(header) - found
    return found


def headers_of_features(features: int) -> set[str]:
    """Headers of the features whose bits are set, with all that these include."""
    lines = [
        f'#include "core/features/{name}.h"' for i, name in enumerate(NAMES) if features >> i & 1
    ]
    return reached("\n".join(lines))


def absent_headers(program: Program) -> set[str]:
    """The headers of the absent features, and what only these include."""
    own = {
        f"core/features/{name}.h" for i, name in enumerate(NAMES) if not program.features >> i & 1
    }
    return own | (headers_of_features(~program.features) - reached(program.source))


def compile_in(tree: Path, program: Program) -> bytes:
    options = ["--fmad=false", f"--include-path={tree}"]
    return _core.compile_source(program.source, 90, options, "absent.cu", use_cache=False)["cubin"]


def with_and_without(tree: Path, program: Program) -> tuple[bytes, bytes]:
    """The cubin from a tree of headers as it is, and from the same without absent features."""
    whole = compile_in(tree, program)
    replaced = absent_headers(program)
    for header in replaced:
        (tree / header).write_text(STOP)
    try:
        return whole, compile_in(tree, program)
    finally:
        for header in replaced:
            shutil.copy2(HEADERS / header, tree / header)


ENGINES = [
    Use(ROOT / "scenes" / EVERY_ENGINE_ON, model, kernel, traversal)
    for kernel in _core.kernel_names()
    for model in ("haste", "whitted")
    for traversal in ["bvh2" if kernel in WITH_A_STACK else "bvh8"]
    if model == "haste" or kernel == "depth_first"
]
BY_SCENE = [Use(scene, model_of(scene)) for scene in SCENES]

Compiled = dict[Use, tuple[Program, Future[tuple[bytes, bytes]]]]


@pytest.fixture(scope="module")
def compiled(core: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Compiled]:
    """Both cubins of every use's program, all under way from the start."""
    reason = core.nvrtc_unavailable()
    if reason is not None:
        pytest.skip(reason)
    trees: SimpleQueue[Path] = SimpleQueue()
    for worker in range(WORKERS):
        tree = tmp_path_factory.mktemp(f"headers{worker}")
        for part in ("core", "cuda/kernels"):
            shutil.copytree(HEADERS / part, tree / part)
        trees.put(tree)

    def run(program: Program) -> tuple[bytes, bytes]:
        tree = trees.get()
        try:
            return with_and_without(tree, program)
        finally:
            trees.put(tree)

    with ThreadPoolExecutor(WORKERS) as pool:
        futures: dict[Program, Future[tuple[bytes, bytes]]] = {}
        found: Compiled = {}
        for use in [*ENGINES, *BY_SCENE]:
            program = use.program()
            if program not in futures:
                futures[program] = pool.submit(run, program)
            found[use] = program, futures[program]
        yield found
        pool.shutdown(cancel_futures=True)


def hashes(cubins: Future[tuple[bytes, bytes]]) -> list[str]:
    return [hashlib.sha256(cubin).hexdigest() for cubin in cubins.result()]


@pytest.mark.parametrize("use", BY_SCENE, ids=str)
def test_the_kernel_of_a_scene_is_the_same_without_the_headers_of_what_it_lacks(
    compiled: Compiled, use: Use
):
    program, cubins = compiled[use]
    whole, without = hashes(cubins)
    assert whole == without, f"{program}: without {sorted(absent_headers(program))}"


@pytest.mark.parametrize("use", ENGINES, ids=str)
def test_so_are_those_of_every_engine(compiled: Compiled, use: Use):
    program, cubins = compiled[use]
    whole, without = hashes(cubins)
    assert whole == without, f"{program}: without {sorted(absent_headers(program))}"


def test_every_feature_has_a_header_and_every_header_a_feature():
    headers = {path.stem for path in (HEADERS / "core" / "features").glob("*.h")}
    assert headers == {*NAMES, "all"}


def test_the_processor_has_every_feature():
    assert includes("core/features/all.h") == {f"core/features/{name}.h" for name in NAMES}


def test_no_header_of_all_programs_includes_that_of_a_feature():
    features = {f"core/features/{name}.h" for name in [*NAMES, "all"]}
    offenders = {
        str(path.relative_to(HEADERS)): sorted(found)
        for part in ("core", "cuda/kernels")
        for path in sorted((HEADERS / part).rglob("*.*h"))
        if (found := includes(str(path.relative_to(HEADERS))) & features)
        if path.parent.name != "features"
    }
    assert not offenders


@pytest.mark.parametrize("feature", NAMES)
def test_a_feature_that_is_required_is_missed(compiler: ModuleType, tmp_path: Path, feature: str):
    """Negative control: without its header no kernel compiles that has the feature."""
    for part in ("core", "cuda/kernels"):
        shutil.copytree(HEADERS / part, tmp_path / part)
    (tmp_path / f"core/features/{feature}.h").write_text(STOP)
    model = "path" if _core.model_features("path") >> NAMES.index(feature) & 1 else "haste"
    program = Program("depth_first", model, _core.model_features(model), 4)
    with pytest.raises(compiler.CompileError, match="a feature that the scene lacks"):
        compile_in(tmp_path, program)
