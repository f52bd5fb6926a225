"""The variant that the Python plug-ins run on; without it the tests that need it are skipped."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from harness.scene import RenderSettings
from reference.mitsuba import available

VARIANT = "llvm_ad_rgb"


@pytest.fixture(scope="session")
def variant() -> str:
    reason = available(VARIANT)
    if reason is not None:
        pytest.skip(reason)
    return VARIANT


@pytest.fixture
def active(variant: str) -> str:
    """The variant, current and with the project's plug-ins."""
    import mitsuba as mi

    from reference.mitsuba import register

    register(variant)
    mi.set_variant(variant)
    return variant


def _settings(model: str, size: int = 8, **changes: object) -> RenderSettings:
    values: dict[str, object] = {
        "max_depth": 8,
        "rr_depth": 100,
        "max_layers": 3,
        "light_samples": 1,
        "ambient_samples": 1,
        "ambient": (0.1, 0.1, 0.1),
    }
    return RenderSettings(model=model, width=size, height=size, **(values | changes))


@pytest.fixture(scope="session")
def settings() -> Callable[..., RenderSettings]:
    """Settings of small images: settings(model, size, **changes)."""
    return _settings
