"""What makes a run impossible, found before anything of it is rendered."""

import tempfile
from collections.abc import Collection
from pathlib import Path

from harness.measure.config import Config, ConfigError
from harness.scene import load_settings
from harness.scene.checks import MAX_PIXELS, too_large


def check_run(config: Config, scenes: Collection[str] | None = None) -> None:
    """Refuse a run with a scene that has no model in it, with too large a picture, with a study in
    a model that its scene is not for, or whose results cannot be written.

    scenes: names of the scenes that are asked for, all of the run where None. Cheap: reads the
    scenes' settings, not the scenes.

    Raises
    ------
    ConfigError
        Naming the setting, the scenes and the folder.
    SceneError
        A scene's settings.yaml cannot be used.
    """
    asked = ", ".join(config["models"])
    for name, path in config.scenes.items():
        if scenes is not None and name not in scenes:
            continue
        settings = load_settings(path)
        if not set(settings.models) & set(config["models"]):
            raise ConfigError(
                f"config: models: {name} is a scene for {', '.join(settings.models)}, and the run "
                f"renders {asked}"
            )
        width, height = config.resolution(name)
        if (width or 1) * (height or 1) > MAX_PIXELS:
            raise ConfigError(f"config: resolution of {name}: {too_large(width, height)}")
    for name, model in config.study_panels:
        known = load_settings(config.study_scenes[name]).models
        if model not in known:
            raise ConfigError(
                f"config: study: {name} is a scene for {', '.join(known)}, not for {model}"
            )
    check_writable(config.results_dir)


def check_writable(folder: Path) -> None:
    """Raise `ConfigError` if `folder` cannot be made or files cannot be written in it."""
    place = folder
    while not place.exists() and place != place.parent:
        place = place.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise ConfigError(
            f"config: results_dir: {folder} cannot be written: {place}: {error.strerror}"
        ) from error
