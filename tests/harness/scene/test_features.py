"""What import says that a scene requires is what the core finds in it."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from harness.scene import Features, load_scene
from harness.tracers.haste import HasteCpu, to_core, to_core_settings

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")

SCENES = Path(__file__).parents[3] / "scenes"
OF_SETTINGS = {"clamp", "bounces"}
"""Features that no scene requires by itself."""
SMALL = sorted(
    [path.parent for path in SCENES.glob("analytic/*/scene.xml")]
    + [SCENES / name for name in ("cornell-box", "three-spheres", "mirror-glass", "hard")]
    + [SCENES / name for name in ("veach-mis", "menger-1", "tetra", "teapot")]
)


def core_names() -> list[str]:
    from haste_cuda import _core

    return list(_core.feature_names())


def test_import_knows_every_feature_of_the_list() -> None:
    assert {field.name for field in fields(Features)} == set(core_names()) - OF_SETTINGS


@pytest.mark.parametrize("scene", SMALL, ids=lambda path: path.name)
def test_import_and_core_agree_on_what_a_scene_requires(scene: Path) -> None:
    imported = load_scene(scene, width=16, height=16)
    bits = to_core(imported, 1).features
    found = {name for bit, name in enumerate(core_names()) if bits >> bit & 1}
    assert found == set(imported.features.names())


@pytest.mark.parametrize(
    ("model", "changes", "bounces"),
    [
        ("path", {"max_depth": 1}, False),
        ("path", {"max_depth": 2}, True),
        ("haste", {"max_layers": 1}, False),
        ("haste", {"max_layers": 2}, True),
        ("whitted", {"max_layers": 1}, False),
        ("whitted", {"max_layers": 2}, True),
    ],
)
def test_settings_decide_whether_rays_bounce(
    model: str, changes: dict[str, int], bounces: bool
) -> None:
    import haste_cuda
    from haste_cuda import _core

    scene = to_core(load_scene(SCENES / "mirror-glass", width=8, height=8), 1)
    bits = _core.required_features(scene, model, haste_cuda.Settings(**changes))
    assert bool(bits >> core_names().index("bounces") & 1) is bounces


@pytest.mark.parametrize("engine", ["depth_first", "packets", "layers"])
@pytest.mark.parametrize("model", ["path", "haste", "whitted"])
def test_more_features_than_are_required_change_no_bit(model: str, engine: str) -> None:
    """The processor's programs differ in primitives, and stacks and queues in the rest."""
    import haste_cuda
    from harness.scene import load_settings

    folder = SCENES / "cornell-box"
    scene = to_core(load_scene(folder, width=12, height=12), 1)
    settings = to_core_settings(load_settings(folder).render(model, 12, 12))
    films = {
        haste_cuda.render_cpu(
            *(scene, model, settings),
            seed=7,
            samples=4,
            engine=engine,
            packet=64,
            threads=1,
            more_features=more,
        )["film_sha256"]
        for more in (0, 1 << core_names().index("spheres"), (1 << len(core_names())) - 1)
    }
    assert len(films) == 1, (model, engine, films)
