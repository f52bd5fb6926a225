"""The ground truth of one scene: Mitsuba's images in independent batches."""

import platform
import time
from pathlib import Path

from harness.measure.config import Config
from harness.measure.files import write_json
from harness.measure.own_folder import own_folder
from harness.measure.progress import Progress
from harness.scene import load_settings

SUMMARY = "truth.json"
"""Written last: that it is there says that every batch of every model is."""


def truth_scene(config: Config, name: str, threads: int) -> Path:
    """Render the ground truth of one scene in each of its models.

    A model that Mitsuba cannot render on this machine, or only with pixels that are not finite, is
    noted with the reason. Batches that are there already, from the same scene, settings and code,
    are kept. One process at a time renders a scene's truth; another one waits.

    Parameters
    ----------
    config
        The run's settings.
    name
        One of its scenes.
    threads
        Processor threads for Mitsuba.

    Returns
    -------
    Path
        The summary, written last.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    """
    with own_folder(config.scene_dir(name), "truth", name, of_truth=True) as progress:
        return _render(config, name, threads, progress)


def _render(config: Config, name: str, threads: int, progress: Progress) -> Path:
    from reference.mitsuba import UnavailableVariantError, render_truth

    started = time.time()
    scene_path = config.scenes[name]
    folder = config.scene_dir(name)
    settings = load_settings(scene_path)
    width, height = config.resolution(name)
    done: dict[str, dict[str, float]] = {}
    skipped: list[dict[str, str]] = []
    for model in config["models"]:
        if model not in settings.models:
            continue
        spp = config.truth_spp(name, model)
        batches = config["truth"]["batches"]
        progress.say(f"{model} truth: {batches} batches of {spp} samples a pixel")
        start = progress.elapsed
        try:
            render_truth(
                scene_path,
                settings.render(model, width=width, height=height),
                batches=batches,
                spp=spp,
                seed=config["truth"]["seed"],
                out_dir=folder / "truth" / model,
                progress=lambda text, model=model: progress.hint(f"{model} truth, {text}"),
                threads=threads,
            )
        except (UnavailableVariantError, FloatingPointError) as refusal:
            progress.say(f"{model} has no ground truth: {refusal}")
            skipped.append({"model": model, "reason": str(refusal)})
        else:
            done[model] = {"batches": batches, "spp": spp, "seconds": progress.elapsed - start}
    progress.say(f"truth complete in {progress.elapsed:.0f} s")
    summary = folder / SUMMARY
    write_json(
        summary,
        {
            "scene": name,
            "host": platform.node(),
            "started": started,
            "ended": time.time(),
            "models": done,
            "skipped": skipped,
        },
    )
    return summary
