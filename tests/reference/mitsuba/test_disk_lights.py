"""Disks as lights of the integrators `haste` and `whitted`, against their closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from harness.scene import load_scene, load_settings
from reference.analytic import answer
from reference.mitsuba import load, render

SCENES = Path(__file__).parents[3] / "scenes" / "analytic"
SEEDS = 8


@pytest.mark.parametrize("model", ["haste", "whitted"])
@pytest.mark.parametrize("name", ["disk-light", "soft-shadow"])
def test_a_disk_light_is_sampled_by_area(name: str, model: str, variant: str) -> None:
    settings = load_settings(SCENES / name)
    render_settings = settings.render(model)  # type: ignore[arg-type]
    known = answer(settings.answer, load_scene(SCENES / name), render_settings)
    assert known is not None
    loaded = load(SCENES / name, render_settings, variant)
    means = np.array([render(loaded, seed, 64)[0].mean() for seed in range(SEEDS)])
    errors = means / np.mean(known) - 1.0
    half = stats.t.ppf(1.0 - 1e-6, SEEDS - 1) * errors.std(ddof=1) / math.sqrt(SEEDS)
    # 1e-4 for the patch that the camera sees.
    assert abs(errors.mean()) < half + 1e-4, f"{name} {model}: {errors.mean():+.4%} ± {half:.4%}"
