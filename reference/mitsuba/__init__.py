"""The project's ground truth: Mitsuba's ``path``, and the paper's models written once more for it.

Nothing is shared with ``haste_cuda``. See the README beside this file for what this can and cannot
judge. Mitsuba is imported on first use, after an LLVM library has been chosen for Dr.Jit.
"""

from reference.mitsuba.rendering import LoadedScene, load, register, render, turn
from reference.mitsuba.truth import render_truth
from reference.mitsuba.variants import UnavailableVariantError, available

__all__ = [
    "LoadedScene",
    "UnavailableVariantError",
    "available",
    "load",
    "register",
    "render",
    "render_truth",
    "turn",
]
