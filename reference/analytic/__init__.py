"""Scenes whose radiance is known: closed forms, and integrals evaluated to all digits.

The formulas know nothing of any renderer. Every number in them is read from the imported scene, so
that a scene and its answer cannot drift apart. See the README beside this file.
"""

from __future__ import annotations

from collections.abc import Callable

from harness.scene import RenderSettings, Scene
from reference.analytic.floors import (
    disk_light,
    highlight,
    rectangle_light,
    soft_shadow,
    sphere_light,
    wall_sky,
)
from reference.analytic.forms import Array
from reference.analytic.furnaces import (
    furnace_diffuse,
    furnace_glass,
    furnace_mirror,
    furnace_phong,
)
from reference.analytic.rooms import (
    ambient_dome,
    emitting_box,
    glass_slab,
    integrating_sphere,
    mirror_box,
)
from reference.analytic.view import AnswerError

__all__ = ["ANSWERS", "AnswerError", "answer"]

ANSWERS: dict[str, Callable[[Scene, RenderSettings], Array | None]] = {
    function.__name__: function
    for function in (
        sphere_light,
        disk_light,
        rectangle_light,
        soft_shadow,
        highlight,
        wall_sky,
        furnace_diffuse,
        furnace_mirror,
        furnace_glass,
        furnace_phong,
        emitting_box,
        mirror_box,
        integrating_sphere,
        glass_slab,
        ambient_dome,
    )
}
"""The key `answer` of a scene's settings.yaml to the function that knows it."""


def answer(name: str, scene: Scene, settings: RenderSettings) -> tuple[float, float, float] | None:
    """Radiance that every pixel of a scene shows.

    Parameters
    ----------
    name
        One of `ANSWERS`.
    scene
        The imported scene, with the camera of the images.
    settings
        Model, depths and ambient light.

    Returns
    -------
    tuple or None
        Linear sRGB; None where there is no closed form in this model.

    Raises
    ------
    AnswerError
        The name is unknown, or the scene is not of the form that the answer is derived for.
    """
    if name not in ANSWERS:
        raise AnswerError(f'no answer is called "{name}"; known are {", ".join(ANSWERS)}')
    found = ANSWERS[name](scene, settings)
    if found is None:
        return None
    return (float(found[0]), float(found[1]), float(found[2]))
