"""What engines say of their launches, copies and time, on the GPU."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import haste_cuda
from harness.scene import load_scene, load_settings
from harness.statistics.work_spans import WorkSpan, summarise_work
from harness.tracers.haste import to_core, to_core_settings

pytestmark = pytest.mark.gpu

SCENE = Path(__file__).parents[2] / "scenes" / "mirror-glass"
SIZE, SAMPLES, PACKET, RAY_BYTES = 64, 8, 4096, 64
CASES: dict[str, dict[str, Any]] = {
    "depth_first": {"engine": "depth_first"},
    "persistent": {"engine": "persistent"},
    "packets": {"engine": "packets", "packet": PACKET, "allocation": "once"},
    "allocating": {"engine": "packets", "packet": PACKET, "allocation": "per_packet"},
    "streams": {"engine": "streams", "packet": PACKET},
    "layers": {"engine": "layers", "packet": PACKET},
    "wavefront": {"engine": "wavefront", "packet": PACKET},
}
KINDS = {
    "depth_first": {"trace"},
    "persistent": {"trace"},
    "packets": {"pop", "upload", "trace", "download", "push"},
    "allocating": {"pop", "allocate", "upload", "trace", "download", "push"},
    "streams": {"upload", "trace", "download"},
    "layers": {"trace", "download"},
    "wavefront": {"trace"},
}


@pytest.fixture(scope="module")
def render() -> Any:
    scene = to_core(load_scene(SCENE, width=SIZE, height=SIZE), 2)
    settings = to_core_settings(load_settings(SCENE).render("whitted", SIZE, SIZE))

    def call(**schedule: Any) -> dict[str, Any]:
        return haste_cuda.render_cuda(
            scene, "whitted", settings, seed=7, samples=SAMPLES, **schedule
        )

    return call


@pytest.mark.parametrize("name", CASES)
def test_spans_are_of_the_engines_kinds_and_lie_within_the_render(render: Any, name: str):
    answer = render(**CASES[name], record_spans=True)
    spans = [WorkSpan(*span) for span in answer["spans"]]
    assert {span.kind for span in spans} == KINDS[name]
    for span in spans:
        assert 0.0 <= span.begin <= span.end <= 1.001 * answer["seconds"] + 1e-4, span
    work = summarise_work(spans)
    assert work.kernel_seconds <= 1.001 * answer["seconds"] + 1e-4, work


@pytest.mark.parametrize("name", CASES)
def test_spans_change_no_film_and_are_left_out_unless_asked_for(render: Any, name: str):
    plain, looked = render(**CASES[name]), render(**CASES[name], record_spans=True)
    assert plain["film_sha256"] == looked["film_sha256"]
    assert "spans" not in plain


@pytest.mark.parametrize("name", ["packets", "allocating", "streams", "layers", "wavefront"])
def test_launches_have_room_for_all_queued_rays(render: Any, name: str):
    answer = render(**CASES[name], count_rays=True)
    queued = answer["camera"] + answer["ambient"] + answer["bounce"]
    assert answer["launches"] >= queued / PACKET, (answer["launches"], queued)


@pytest.mark.parametrize("name", ["packets", "allocating", "streams", "layers"])
def test_a_span_of_a_kernel_is_one_launch_and_they_trace_every_queued_ray(render: Any, name: str):
    answer = render(**CASES[name], count_rays=True, record_spans=True)
    queued = answer["camera"] + answer["ambient"] + answer["bounce"]
    traced = [span[4] for span in answer["spans"] if span[0] == "trace"]
    assert len(traced) == answer["launches"]
    assert sum(traced) == queued
    assert max(traced) <= PACKET


def test_the_papers_queue_moves_every_ray_up_and_every_spawned_one_down(render: Any):
    answer = render(**CASES["packets"], count_rays=True)
    queued = answer["camera"] + answer["ambient"] + answer["bounce"]
    expected = RAY_BYTES * (queued + queued - answer["camera"]) + 4 * answer["launches"]
    assert answer["bytes_moved"] == expected


def test_streams_make_camera_rays_on_the_device(render: Any):
    answer = render(**CASES["streams"], count_rays=True)
    spawned = answer["ambient"] + answer["bounce"]
    assert answer["bytes_moved"] == 2 * RAY_BYTES * spawned + 4 * answer["launches"]


@pytest.mark.parametrize("name", ["depth_first", "persistent", "wavefront"])
def test_nothing_is_moved_where_the_queue_is_on_the_device(render: Any, name: str):
    assert render(**CASES[name])["bytes_moved"] == 0


def test_copies_have_rates_and_page_locked_ones_are_faster():
    rates = haste_cuda.copy_rates(1 << 26)
    assert all(rate > 1e8 for rate in rates.values()), rates
    assert rates["pinned_up"] > rates["pageable_up"], rates
    assert rates["device"] > rates["pinned_both"], rates
