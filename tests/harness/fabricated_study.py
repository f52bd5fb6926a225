"""A study of packets that nobody rendered: every engine follows a law that is known."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from harness.measure.study_plan import StudyPlan, StudyRender
from harness.statistics.work_spans import WorkSpan, summarise_work

RAYS = {"camera": 1.0, "shadow": 8.0, "ambient": 4.0, "bounce": 1.0}
QUEUED = 6.0
LAWS = {
    "depth_first": (4e-5, 3.0e9),
    "packets": (6e-5, 1.2e8),
    "streams": (2e-5, 1.1e9),
    "layers": (2.5e-5, 2.4e9),
    "wavefront": (4.5e-5, 2.2e9),
    "persistent": (5e-5, 2.0e9),
}
"""Seconds of an empty launch, and queued rays a second."""
REALLOCATION = 2.0e-4
"""Seconds of allocating for one packet, and seconds a ray."""
REALLOCATION_A_RAY = 1.5e-9
FLOAT_GAIN = 0.95
KINK = 2**20
"""From so many rays on, a further ray of `layers` takes twice as long."""
STUDY = {
    "elsewhere": {"scenes": [], "models": [], "sizes": [4096, 65536, 1048576]},
    "orders": ["fifo", "lifo"],
    "light_samples": 4,
    "ambient_samples": 4,
    "width": 256,
    "launches": 8,
    "engine_launches": {},
    "least_rays": 262144,
    "repeats": 3,
    "price_repeats": 6,
    "largest": {"streams": 4194304},
    "queue_bytes": 1 << 35,
    "memory": {"packet": 65536, "spp": [1, 4, 16, 64]},
    "timeline_packet": 65536,
    "joules_seconds": 0.3,
    "sizes": [2**k for k in range(8, 25)],
}
COPIES = {
    "pinned_up": 5.4e10,
    "pinned_down": 5.4e10,
    "pinned_both": 4.99e10,
    "pageable_up": 9e9,
    "pageable_down": 8e9,
    "device": 2.6e12,
}


def launch_seconds(render: StudyRender, rays: float) -> float:
    """Time of a launch of so many queued rays."""
    empty, rate = LAWS[render.engine]
    seconds = empty + rays / rate
    if render.engine == "layers":
        seconds += max(0.0, rays - KINK) / rate
    if render.case.get("allocation") == "per_packet":
        seconds += REALLOCATION + REALLOCATION_A_RAY * rays
    return seconds * (FLOAT_GAIN if render.case.get("film") == "float_atomic" else 1.0)


def queue_bytes(render: StudyRender) -> float:
    """Layers hold a generation of their packet, fifo a generation of the image, lifo a stack."""
    packet = int(str(render.case.get("packet", 0)))
    rays = render.samples * QUEUED
    if render.engine == "layers":
        return 64.0 * min(5.0 * packet, rays)
    if render.case.get("order") == "fifo":
        return 64.0 * min(0.6 * rays, 12.0 * packet)
    return 64.0 * min(9.0 * packet, rays) if packet else 0.0


def _spans(render: StudyRender, rays: float) -> list[WorkSpan]:
    """Six packets, one after the other, or on three streams."""
    spans = []
    seconds = launch_seconds(render, rays)
    if render.engine == "streams":
        for packet in range(6):
            begin, lane = packet * 1.1 * seconds, packet % 3
            for kind, at, length in (
                ("upload", 0.0, 0.6),
                ("trace", 0.6, 1.0),
                ("download", 1.6, 0.6),
            ):
                start = begin + at * seconds
                spans.append(WorkSpan(kind, lane, start, start + length * seconds, int(rays)))
        return spans
    parts = {"pop": 0.1, "upload": 0.25, "trace": 0.2, "download": 0.25, "push": 0.2}
    if render.case.get("allocation") == "per_packet":
        parts = {
            "pop": 0.1,
            "allocate": 0.2,
            **{k: 0.7 * v for k, v in parts.items() if k != "pop"},
        }
    if render.engine != "packets":
        parts = {"trace": 1.0}
    for packet in range(6):
        start = packet * seconds
        for kind, share in parts.items():
            spans.append(WorkSpan(kind, 0, start, start + share * seconds, int(rays)))
            start += share * seconds
    return spans


def fabricate_study(
    folder: Path,
    panels: dict[str, list[str]],
    *,
    elsewhere: tuple[str, ...] = (),
    engines: tuple[str, ...] = (*LAWS,),
    noise: float = 0.02,
    seed: int = 3,
) -> Path:
    """Write the files of studies below a results folder, and its settings.json."""
    random = np.random.default_rng(seed)
    study: dict[str, Any] = {**STUDY, "panels": panels}
    study["elsewhere"] = {**study["elsewhere"], "scenes": list(elsewhere), "models": ["haste"]}
    jobs = [(name, model, STUDY["sizes"]) for name, models in panels.items() for model in models]
    jobs += [(name, "haste", study["elsewhere"]["sizes"]) for name in elsewhere]
    for name, model, sizes in jobs:
        where = folder / "study" / name / model
        where.mkdir(parents=True)
        plan = StudyPlan(study, engines, sizes, QUEUED)
        rows: list[dict[str, Any]] = []
        work: list[dict[str, Any]] = []
        for render in plan.renders():
            rays = float(str(render.case.get("packet", QUEUED * render.samples)))
            launches = max(1.0, QUEUED * render.samples / rays)
            row = {
                "tracer": "haste-cuda",
                "precision": "watertight",
                "rays_per_sample": RAYS,
                "key": render.key(name + model),
                "engine": render.engine,
                "case": render.case,
                "width": render.width,
                "spp": render.spp,
                "samples": render.samples,
                "launches": launches,
                "peak_queue_bytes": queue_bytes(render),
                "bytes_moved": 64.0 * 2 * rays * launches if "order" in render.case else 4.0,
                "status": "ok",
                "note": "",
                "film_sha256": "0" * 64,
            }
            seconds = launches * launch_seconds(render, rays)
            spans = _spans(render, rays)
            scale = seconds / spans[-1].end
            shares = asdict(summarise_work(spans))
            looked = {
                key: value * (1.0 if key == "overlap" else scale)
                for key, value in shares.items()
                if np.isfinite(value)
            }
            if render.with_joules:
                looked["joules"] = 350.0 * seconds
            if render.case.get("packet") == study["timeline_packet"]:
                looked["spans"] = [asdict(span) for span in spans]
            work.append({**row, "repeat": 0, "seconds": seconds, **looked})
            rows += [
                {**row, "repeat": k, "seconds": seconds * random.lognormal(0.0, noise)}
                for k in range(render.repeats)
            ]
        files = {
            "rows": rows,
            "work": work,
            "scene": {
                "name": name,
                "model": model,
                "title": name,
                "settings": {"light_samples": 4},
                "copies": COPIES,
            },
            "provenance": {"run": "fabricated", "config": {"study": study}},
            "studied": {},
        }
        for file, value in files.items():
            (where / f"{file}.json").write_text(json.dumps(value))
    settings = {"scenes": [*panels, *elsewhere], "study": study}
    (folder / "settings.json").write_text(json.dumps(settings))
    return folder
