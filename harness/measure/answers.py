"""The known answers of a scene, written beside its images by the job that renders them."""

from collections.abc import Mapping

from harness.scene import RenderSettings, Scene

Rgb = tuple[float, float, float]


def expected_answers(
    name: str, scene: Scene, renders: Mapping[str, RenderSettings]
) -> dict[str, Rgb]:
    """The known radiance of a scene, linear sRGB by model.

    Parameters
    ----------
    name
        The key `answer` of the scene's settings; empty for a scene without a known answer.
    scene
        The scene as it is rendered.
    renders
        Settings by model.

    Raises
    ------
    reference.analytic.AnswerError
        There is no such answer, the scene is not of its form, or it claims a model without one.
    """
    if not name:
        return {}
    from reference.analytic import AnswerError, answer

    found = {}
    for model, settings in renders.items():
        value = answer(name, scene, settings)
        if value is None:
            raise AnswerError(f"{scene.name}: {name} has no answer in the model {model}")
        found[model] = value
    return found
