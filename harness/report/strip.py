"""The strip of verdicts: scene by tracer, at a glance, and where to look."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from harness.agreement import worst
from harness.answers import AnswerVerdict
from harness.gate import Judgement
from harness.regression import Regression
from harness.report import numbers
from harness.report.material import Material
from harness.report.tables import VERDICT_CLASS
from harness.statistics.bias import Verdict
from harness.statistics.change import Speed
from harness.tables.read import SceneJob, model_order, tracer_order
from harness.viewer.links import link_of, worst_place

SIGNS = {Verdict.PASS: "✓", Verdict.FAIL: "✗", Verdict.NOT_ENOUGH_SAMPLES: "?"}
SPEED_SIGNS = {Speed.FASTER: "▲", Speed.SAME: "=", Speed.SLOWER: "▼", Speed.AMBIGUOUS: "≈"}
ABSENT = "–"
"""Signs beside the colours, which some readers and printers do not tell apart."""
ZOOM = 4.0
"""Magnification at which a link opens a place of an image."""
MOST_NAMED = 12
"""Failures that are named above the strip; the strip has all."""


@dataclass(frozen=True, slots=True)
class Mark:
    """What is said of one scene, tracer and model."""

    sign: str
    kind: str
    """pass, fail, wait, or none where there is nothing to judge"""
    speed: str
    """sign of the speed beside the baseline's; empty without one"""
    speed_kind: str
    """faster, same, slower, ambiguous or nothing"""
    words: str
    """the same for those who do not see signs, with the reason"""
    link: str
    """a view of the viewer; empty without images"""


@dataclass(frozen=True, slots=True)
class Row:
    """One scene."""

    scene: str
    marks: Sequence[Mark]


@dataclass(frozen=True, slots=True)
class Alarm:
    """A failure in words, with where to look."""

    scene: str
    model: str
    tracer: str
    reason: str
    link: str


@dataclass(frozen=True, slots=True)
class Strip:
    """Verdicts: a row a scene, a column a tracer and model."""

    columns: Sequence[tuple[str, Sequence[str]]]
    """tracers and their models"""
    rows: Sequence[Row]
    alarms: Sequence[Alarm]
    more_alarms: int
    counts: Sequence[tuple[str, str, str, int]]
    """sign, kind, words and number of every verdict that occurs"""
    has_baseline: bool

    @property
    def first_marks(self) -> set[int]:
        """Places within a row at which the columns of a tracer begin."""
        found, place = set(), 0
        for _, models in self.columns:
            found.add(place)
            place += len(models)
        return found


def image_verdict(change: Regression | None) -> Verdict:
    """What the baseline says of image and variance; a pass without one."""
    if change is None or change.bias is None or change.variance is None:
        return Verdict.PASS
    found = {change.bias.verdict, change.variance.verdict}
    return worst(found | ({Verdict.FAIL} if change.tile_p < change.tile_level else set()))


def reason_of(judgement: Judgement, change: Regression | None, answer: AnswerVerdict | None) -> str:
    """Why a tracer does not pass: what was found of the questions that it does not answer."""
    parts = []
    bias = judgement.bias
    if bias is not None and bias.verdict is not Verdict.PASS:
        value, ends = numbers.percent(bias.bias.value), numbers.percent_bounds(bias.bias)
        parts.append(f"bias {value} % {ends}, bound ±{100.0 * bias.delta:g} %")
    if judgement.tiles is not None and judgement.rejected:
        parts.append(f"{judgement.rejected} of {judgement.tiles.p.size} tiles differ")
    elif judgement.tiles is not None and judgement.tile_verdict is not Verdict.PASS:
        parts.append("tiles too noisy to tell")
    if judgement.defects is not None and judgement.defects.any:
        parts.append(f"{judgement.defects.non_finite + judgement.defects.negative} bad pixels")
    if image_verdict(change) is not Verdict.PASS and change is not None and change.variance:
        ratio = numbers.significant(change.variance.ratio.value)
        moved = numbers.percent(change.bias.bias.value) if change.bias else numbers.MISSING
        parts.append(f"beside the baseline: mean {moved} %, variance × {ratio}")
    if judgement.note:
        parts.append(judgement.note)
    if answer is not None and answer.verdict is not Verdict.PASS:
        parts.append(f"{numbers.percent(answer.error.value)} % off the known radiance")
    return "; ".join(parts)


SPEED_WORDS = {
    Speed.FASTER: "faster than",
    Speed.SAME: "as fast as",
    Speed.SLOWER: "slower than",
    Speed.AMBIGUOUS: "in times too noisy to tell from",
}


def speed_words(change: Regression) -> str:
    """A speed beside the baseline's, in words; empty where it was not compared."""
    if change.speed is None or change.speed_ratio is None:
        return ""
    ratio = numbers.significant(change.speed_ratio.value)
    elsewhere = f", which was timed on {change.machine}" if change.machine else ""
    return f"{SPEED_WORDS[change.speed]} the baseline (× {ratio}){elsewhere}"


def view_of(material: Material, job: SceneJob, model: str, tracer: str) -> str:
    """Link to a tracer's relative error, at the place where it differs most."""
    place = worst_place(job, model, tracer, material.settings.tile)
    if place is None:
        return ""
    return link_of(job.name, model, tracer, mode="relative", place=place, zoom=ZOOM)


@dataclass(frozen=True, slots=True)
class _Findings:
    """What truth, baseline and known answer say of one scene, model and tracer."""

    judgement: Judgement
    change: Regression | None
    answer: AnswerVerdict | None

    @property
    def verdict(self) -> Verdict:
        found = {self.judgement.verdict, image_verdict(self.change)}
        return worst(found | ({self.answer.verdict} if self.answer is not None else set()))

    @property
    def reason(self) -> str:
        return reason_of(self.judgement, self.change, self.answer)

    def mark(self, link: str) -> Mark:
        speed = self.change.speed if self.change is not None else None
        words = [self.verdict.value.lower()]
        if self.verdict is not Verdict.PASS:
            words.append(self.reason)
        elif self.judgement.bias is not None:
            words.append(f"bias {numbers.percent(self.judgement.bias.bias.value)} %")
        if self.change is not None:
            words.append(speed_words(self.change))
        subject = f"{self.judgement.scene}, {self.judgement.model}, {self.judgement.tracer}"
        return Mark(
            SIGNS[self.verdict],
            VERDICT_CLASS[self.verdict],
            SPEED_SIGNS[speed] if speed is not None else "",
            speed.value if speed is not None else "",
            f"{subject}: {'; '.join(filter(None, words))}",
            link,
        )

    def alarms(self, link: str) -> list[Alarm]:
        """What is wrong, in words: the image first, then the speed."""
        row, change = self.judgement, self.change
        found = []
        if self.verdict is Verdict.FAIL:
            found.append(Alarm(row.scene, row.model, row.tracer, self.reason, link))
        if change is not None and change.speed is Speed.SLOWER and not change.machine:
            found.append(Alarm(row.scene, row.model, row.tracer, speed_words(change), "#speed"))
        return found


def _counts(marks: Sequence[Mark]) -> list[tuple[str, str, str, int]]:
    found = [
        (SIGNS[one], VERDICT_CLASS[one], one.value.lower(), [mark.kind for mark in marks])
        for one in Verdict
    ]
    counts = [(sign, kind, words, kinds.count(kind)) for sign, kind, words, kinds in found]
    speeds = [mark.speed_kind for mark in marks]
    counts += [
        (sign, one.value, f"speed: {one.value}", speeds.count(one.value))
        for one, sign in SPEED_SIGNS.items()
    ]
    counts.append((ABSENT, "none", "not run", sum(mark.kind == "none" for mark in marks)))
    return [one for one in counts if one[3]]


def make_strip(material: Material) -> Strip:
    """Arrange what the truth and the baseline say; a tracer that ran nowhere has no column."""
    found = {(row.scene, row.tracer, row.model): row for row in material.judgements}
    reasons = {(row.scene, row.tracer, row.model): row.reason for row in material.absent}
    answers = {(row.scene, row.tracer, row.model): row for row in material.answers}
    changes = {row.subject: row for row in material.changes}
    models = {
        tracer: sorted(
            {row.model for row in found.values() if row.tracer == tracer}, key=model_order
        )
        for tracer in sorted({row.tracer for row in found.values()}, key=tracer_order)
    }
    rows: list[Row] = []
    alarms: list[Alarm] = []
    for job in material.jobs:
        marks = []
        for tracer, model in [(name, one) for name, own in models.items() for one in own]:
            key = (job.name, tracer, model)
            if key not in found:
                words = f"{job.name}, {model}, {tracer}: {reasons.get(key, 'no images')}"
                marks.append(Mark(ABSENT, "none", "", "", words, ""))
                continue
            change = changes.get((job.name, model, tracer))
            findings = _Findings(found[key], change, answers.get(key))
            link = view_of(material, job, model, tracer)
            marks.append(findings.mark(link))
            alarms += findings.alarms(link)
        rows.append(Row(job.name, marks))
    return Strip(
        list(models.items()),
        rows,
        alarms[:MOST_NAMED],
        len(alarms[MOST_NAMED:]),
        _counts([mark for row in rows for mark in row.marks]),
        bool(material.changes),
    )
