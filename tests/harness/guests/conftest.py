"""Scenes by others, once a session."""

from __future__ import annotations

from pathlib import Path

import guest_scenes
import pytest


@pytest.fixture(scope="session")
def sionna_scene(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Mitsuba files of sionna-rt's scenes, by name."""
    wheel = guest_scenes.sionna_wheel()
    folder = tmp_path_factory.mktemp("sionna")
    names = ("simple_street_canyon", "simple_street_canyon_with_cars", "etoile", "munich")
    return {name: guest_scenes.unpack(wheel, name, folder) for name in names}
