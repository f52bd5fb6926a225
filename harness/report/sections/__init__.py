"""The sections of the report, from the top of the page to its end.

A new one is a function, a template in harness/report/templates, and a line here.
"""

from harness.report.sections import (
    costs,
    error,
    features,
    launches,
    outcome,
    rays,
    record,
    stability,
    trade,
    viewer,
)
from harness.report.sections.section import Section

SECTIONS = (
    Section("strip", "Verdicts", outcome.strip, of_images=True),
    Section("trade", "Trade", trade.trade),
    Section("budget", "Budgets", trade.budget),
    Section("viewer", "Viewer", viewer.viewer, of_images=True),
    Section("convergence", "Convergence", error.convergence, of_images=True),
    Section("spectrum", "Spectrum", error.spectrum),
    Section("quantiles", "Spread", error.quantiles),
    Section("packets", "Packets", launches.packets),
    Section("engines", "Engines", launches.engines),
    Section("launches", "Launches", launches.launches),
    Section("rays", "Rays", rays.rays),
    Section("stability", "Stability", stability.stability),
    Section("features", "Features", features.features),
    Section("eye-rays", "Eye rays", rays.eye_rays),
    Section("speed", "Speed", costs.speed, of_images=True),
    Section("times", "Time, memory, energy", costs.times, of_images=True),
    Section("agreement", "Agreement", outcome.agreement, of_images=True),
    Section("answers", "Known answers", outcome.answers),
    Section("provenance", "Provenance", record.provenance),
    Section("downloads", "Downloads", record.downloads),
    Section("formulas", "Formulas", record.formulas),
    Section("reproduce", "Reproduce", record.commands),
)
"""In this order on the page; those that a run has nothing for are left out."""
