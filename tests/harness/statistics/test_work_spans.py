"""Overlap of copies and kernels, on spans whose overlap is plain to see."""

import math

import pytest

from harness.statistics.work_spans import WorkSpan, summarise_work


def spans(*parts: tuple[str, float, float]) -> list[WorkSpan]:
    return [WorkSpan(kind, lane, begin, end, 1) for lane, (kind, begin, end) in enumerate(parts)]


def test_one_thing_at_a_time_overlaps_nowhere():
    work = summarise_work(
        spans(("pop", 0, 1), ("upload", 1, 3), ("trace", 3, 7), ("download", 7, 8), ("push", 8, 9))
    )
    assert (work.copy_seconds, work.kernel_seconds, work.queue_seconds) == (3, 4, 2)
    assert work.overlap == 0.0


def test_copies_behind_a_kernel_are_hidden():
    assert (
        summarise_work(spans(("trace", 0, 10), ("upload", 2, 4), ("download", 5, 6))).overlap == 1
    )


def test_a_copy_is_hidden_as_far_as_kernels_reach():
    work = summarise_work(spans(("upload", 0, 4), ("trace", 3, 5), ("trace", 1, 2)))
    assert work.overlap == pytest.approx(0.5)


def test_copies_that_run_beside_each_other_count_once():
    work = summarise_work(spans(("upload", 0, 4), ("download", 2, 6), ("trace", 3, 4)))
    assert work.copy_seconds == 6
    assert work.overlap == pytest.approx(1 / 6)


def test_without_copies_there_is_no_overlap_to_speak_of():
    assert math.isnan(summarise_work(spans(("trace", 0, 1))).overlap)
