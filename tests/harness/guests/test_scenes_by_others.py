"""Scenes that others wrote for Mitsuba: rendered and judged, or refused with the whole list."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from guest_scenes import scanned_types

from harness.bounds import GateSettings
from harness.describe import describe_scene, format_description
from harness.gate import describe, judge
from harness.retarget import retarget
from harness.scene import active_variant, load_settings, parser_config
from harness.scene.plugins import SUPPORTED
from harness.statistics.bias import Verdict
from harness.tables.read import SceneJob, read_job
from harness.tracers.registry import TRACERS, load_tracer
from reference.mitsuba import render_truth

EDGE = 16
SEEDS = BATCHES = 16
TAGS = {"Shape": "shape", "BSDF": "bsdf", "Emitter": "emitter", "Sensor": "sensor", "Film": "film"}
RADIO = "itu-radio-material"
REFUSED = ("simple_street_canyon", "simple_street_canyon_with_cars", "etoile", "munich")


@pytest.mark.parametrize("name", REFUSED)
def test_the_list_of_what_is_missing_equals_a_scan_of_the_file(
    sionna_scene: Mapping[str, Path], name: str
):
    file = sionna_scene[name]
    supported = {(TAGS[kind], plugin) for kind in TAGS for plugin in SUPPORTED[kind]}
    scanned = Counter(scanned_types(file))
    description = describe_scene(file)
    found = Counter((TAGS[use.kind], use.name) for use in description.missing)
    wanted = Counter({use: count for use, count in scanned.items() if use not in supported})
    assert found == wanted, (file, found, wanted)
    assert set(found) == {("bsdf", RADIO)}
    assert not description.accepted()
    others = Counter((TAGS[use.kind], use.name) for use in description.plugins)
    assert others == scanned, (file, others - scanned, scanned - others)
    text = format_description(description)
    assert text.endswith(f'  cannot be rendered: missing bsdf "{RADIO}"'), text[-200:]
    assert "the scene has no sensor" in text


def render_job(scene: Path, folder: Path, *, spp: int) -> SceneJob:
    """Truth and images of `haste-cpu` in the model path, as a job leaves them."""
    settings = load_settings(scene).render("path", EDGE, EDGE)
    threads = len(os.sched_getaffinity(0))
    truth = folder / "truth" / "path"
    render_truth(scene, settings, batches=BATCHES, spp=2 * spp, out_dir=truth, threads=threads)
    tracer = load_tracer(TRACERS["haste-cpu"])(threads)
    tracer.load(scene, settings)
    seeds = folder / "seeds" / "path" / "haste-cpu"
    seeds.mkdir(parents=True)
    for seed in range(SEEDS):
        image = tracer.render(seed, spp).image
        np.save(seeds / f"seed_{seed:03d}.npy", image.astype(np.float32))
        record = {"status": "ok", "seed": seed, "spp": spp}
        (seeds / f"seed_{seed:03d}.json").write_text(json.dumps(record))
    (folder / "provenance.json").write_text("{}")
    description = {"name": scene.parent.name, "resolution": [EDGE, EDGE]}
    (folder / "scene.json").write_text(json.dumps(description))
    return read_job(folder)


def verdict(job: SceneJob) -> tuple[Verdict, str]:
    judgements, _ = judge([job], GateSettings())
    assert len(judgements) == 1, judgements
    return judgements[0].verdict, describe(judgements[0])


def test_the_cornell_box_of_mitsuba_is_rendered_and_not_rejected(tmp_path: Path):
    # Its light is small, bright and in the picture: proving the bias within 0.5 % takes 8,192
    # samples a pixel and image, so that this asks no more than that nothing is rejected.
    file = tmp_path / "cornell" / "scene.xml"
    file.parent.mkdir()
    with active_variant("scalar_rgb"):
        state = mi.parser.parse_dict(parser_config("scalar_rgb"), mi.cornell_box())
        mi.parser.write_file(state, str(file))
    job = render_job(file, tmp_path / "job", spp=256)
    found, line = verdict(job)
    assert found is not Verdict.FAIL, line


@pytest.mark.parametrize("name", ["simple_street_canyon", "etoile"])
def test_a_retargeted_city_passes_the_gate_and_fails_with_2_percent_more_light(
    sionna_scene: Mapping[str, Path], name: str, tmp_path: Path
):
    copy = tmp_path / name / "scene.xml"
    replacements = {RADIO: "twosided:0.6"}
    retarget(sionna_scene[name], copy, replace_bsdf=replacements, emitter=1.0, camera=True)
    assert describe_scene(copy).accepted()
    job = render_job(copy, tmp_path / "job", spp=64)
    found, line = verdict(job)
    assert found is Verdict.PASS, line
    for path in (job.folder / "seeds").rglob("*.npy"):
        np.save(path, np.float32(1.02) * np.load(path))
    found, line = verdict(job)
    assert found is Verdict.FAIL, line
