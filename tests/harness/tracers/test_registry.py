"""The registry, and what a tracer says where it cannot run."""

import builtins
from types import ModuleType
from typing import Any

import pytest

from harness.measure.config import ROOT
from harness.scene import load_settings
from harness.tracers.base import Tracer, UnsupportedError
from harness.tracers.haste import HasteCpu
from harness.tracers.mitsuba import MitsubaLlvm, MitsubaScalar
from harness.tracers.registry import COLOURS, TRACERS, load_tracer


def test_every_tracer_loads_and_knows_its_own_name():
    for name, target in TRACERS.items():
        tracer = load_tracer(target)
        assert issubclass(tracer, Tracer), target
        assert tracer.name == name, target
        assert tracer.models and tracer.engines and tracer.precision, target


def test_every_tracer_has_a_colour_of_its_own():
    assert list(COLOURS) == list(TRACERS)
    assert len(set(COLOURS.values())) == len(COLOURS)


def test_a_missing_extension_is_a_reason_that_says_what_builds_it(monkeypatch: pytest.MonkeyPatch):
    original = builtins.__import__

    def without_extension(name: str, *rest: Any) -> ModuleType:
        if name == "haste_cuda":
            raise ImportError("no haste_cuda._core")
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without_extension)
    reason = HasteCpu.unavailable()
    assert reason is not None
    assert "no haste_cuda._core" in reason and "./bench setup" in reason, reason


def test_mitsuba_is_compared_in_its_own_path_tracer_only():
    settings = load_settings(ROOT / "scenes" / "cornell-box").render("haste")
    with pytest.raises(UnsupportedError, match="mitsuba-llvm is compared in the path model only"):
        MitsubaLlvm(1).load(ROOT / "scenes" / "cornell-box", settings)


def test_scalar_mitsuba_refuses_a_bsdf_registered_from_python():
    folder = ROOT / "scenes" / "three-spheres"
    settings = load_settings(folder).render("path", 8, 8)
    with pytest.raises(UnsupportedError, match="the scene uses phong"):
        MitsubaScalar(1).load(folder, settings)
