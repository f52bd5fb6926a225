"""The words of the report: its summary, the matrix of verdicts, provenance and commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from harness.bounds import FAR, VISIBLE, GateSettings
from harness.gate import Absent, Judgement
from harness.report.numbers import significant
from harness.statistics.bias import Verdict
from harness.tables.lookup import Measurements
from harness.tables.provenance import commits_of, machine_of, records_of
from harness.tables.read import SceneJob, model_order, tracer_order


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")


def _join(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def summarise(
    jobs: list[SceneJob], judgements: list[Judgement], absent: list[Absent], speed: Measurements
) -> str:
    """One paragraph: what was compared, how it came out, and how fast it was."""
    tracers = sorted({row.tracer for row in judgements}, key=tracer_order)
    models = sorted({row.model for row in judgements}, key=model_order)
    if not tracers:
        return "No tracer has produced an image: there is nothing to compare."
    counts = {verdict: sum(row.verdict is verdict for row in judgements) for verdict in Verdict}
    text = (
        f"{_join(tracers)} rendered {_plural(len(jobs), 'scene')} in "
        f"{_plural(len(models), 'lighting model')} ({_join(models)}). "
        f"Of {_plural(len(judgements), 'comparison')} with the ground truth, "
        f"{counts[Verdict.PASS]} pass"
    )
    if counts[Verdict.FAIL]:
        text += f", {counts[Verdict.FAIL]} fail"
    if counts[Verdict.NOT_ENOUGH_SAMPLES]:
        text += f", {counts[Verdict.NOT_ENOUGH_SAMPLES]} need more samples"
    text += ". "
    ratios = [
        row
        for row in speed.rows
        if row.quantity == "speed_ratio" and row.case == "to=mitsuba-llvm" and row.model == "path"
    ]
    best = [row for row in ratios if row.tracer in {"haste-cuda", "embree", "haste-cpu"}]
    parts = []
    for tracer in sorted({row.tracer for row in best}, key=tracer_order):
        values = [row.interval.value for row in best if row.tracer == tracer]
        low, high = significant(min(values), 2), significant(max(values), 2)
        parts.append(f"{tracer} at {low if low == high else f'{low} to {high}'}")
    if parts:
        text += (
            f"In path, {_join(parts)} times the samples a second of mitsuba-llvm on these scenes. "
        )
    names = sorted({row.tracer for row in absent} - set(tracers), key=tracer_order)
    if names:
        text += f"{_join(names)} did not run here; the reasons are below."
    return text.strip()


def explain_gate(settings: GateSettings, judgements: list[Judgement]) -> str:
    """The questions of the gate, with their numbers."""
    tiles = sum(row.tiles.p.size for row in judgements if row.tiles is not None)
    level = significant(judgements[0].tile_level, 2) if judgements else "–"
    return (
        "A tracer passes where five things hold. The bias of its image mean is proven to be "
        f"small: the 90 % interval lies within ±{100 * settings.delta:g} % "
        f"(±{100 * settings.caustic_delta:g} % in a scene with a caustic). "
        f"None of its {settings.tile} × {settings.tile} tiles differs from the truth: Welch’s test "
        f"at p < {level} (Šidák) for each of {tiles:,} tiles, so that the whole check errs with "
        f"probability {settings.alpha:g}. The picture lies where the truth’s does, to "
        f"{FAR:g} pixels. Images of different seeds have no noise in common. And every pixel is "
        "finite and not negative. An interval "
        "that is too wide is no pass, nor is a tile test that cannot see an error of "
        f"{100 * VISIBLE:g} %: the visible tile error is the one that it would find half of the "
        "time in the median tile."
    )


def collect_facts(provenance: Mapping[str, Any], jobs: list[SceneJob]) -> list[tuple[str, str]]:
    """Key facts of the provenance, as far as they were recorded."""
    machine = machine_of(provenance)
    begun = [str(one["started"]) for one in records_of(provenance) if "started" in one]
    packages = provenance.get("packages", {})
    facts = [
        ("run", str(provenance["run"])),
        ("commit", " and ".join(commits_of(provenance))),
        ("started", min(begun, default="")),
        ("processor", str(machine.get("processor", ""))),
        ("cores", str(machine.get("usable_cores", machine.get("cores", "")))),
        ("threads a tracer", str(provenance.get("threads", ""))),
        ("governor", str(machine.get("governor") or "")),
        ("GPUs", ", ".join(str(gpu.get("name")) for gpu in machine.get("gpus", [])) or "none"),
        ("system", str(machine.get("system", ""))),
        ("Python", str(provenance.get("python", ""))),
        ("packages", ", ".join(f"{name} {v}" for name, v in packages.items() if v)),
    ]
    different = [
        f"{job.name} {row['model']} {row['tracer']}"
        for job in jobs
        for row in job.description.get("films", [])
        if row["different_films"] > 1
    ]
    films = sum(len(job.description.get("films", [])) for job in jobs)
    if films:
        facts.append(
            (
                "films",
                f"{films} groups of renders with one seed, over engines and packet sizes: "
                + (f"bits differ in {', '.join(different)}" if different else "equal bit for bit"),
            )
        )
    return [(key, value) for key, value in facts if value and value != "None"]


def warn_of_load(jobs: list[SceneJob]) -> str:
    """A sentence naming the scenes that were timed on a busy machine, empty if there are none."""
    busy = [job.name for job in jobs if job.provenance.get("machine", {}).get("contended")]
    if not busy:
        return ""
    return (
        f"The machine was already busy when {_join(busy)} began: "
        "the times there are upper bounds, and the ratios rough."
    )


def reproduce(provenance: Mapping[str, Any], jobs: list[SceneJob]) -> str:
    """Commands that make this report again, and one row of it."""
    run = provenance["run"]
    commit = provenance.get("commit") or "COMMIT"
    settings = "" if run == "quick" else f" --configfile config/{run}.yaml"
    lines = [
        f"git checkout {commit}",
        f"./bench all{settings}",
        "./bench check" + ("" if run == "quick" else f" --settings config/{run}.yaml"),
    ]
    if jobs:
        one = f"./bench all{settings} --config scenes={jobs[0].name}"
        lines += ["", "# one scene only", one]
    return "\n".join(lines)
