"""The viewer of images, in the page or with every image at full size beside it."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content
from harness.statistics.bias import Verdict
from harness.viewer.pack import viewer_context

MOST_IMAGES = 100
"""Images within the page, the thumbnails counted."""


def viewer(material: Material, figures: FigureFiles) -> Content | None:
    """The images of as many scenes as the page has room for, those that fail first."""
    del figures
    room = MOST_IMAGES - len(material.pictured)
    failed = [(row.scene, row.model) for row in material.judgements if row.verdict is Verdict.FAIL]
    found = viewer_context(material.folder, limit=room, first=tuple(dict.fromkeys(failed)))
    return {"viewer": found} if found["shown"] or found["elsewhere"] else None
