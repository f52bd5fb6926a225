"""The check of equal films: a second film of one seed fails it, by name."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from harness.films import describe_films, films_exit_code


def job(different: int) -> Any:
    row = {
        "tracer": "haste-cpu",
        "model": "haste",
        "seed": 0,
        "spp": 16,
        "renders": 9,
        "different_films": different,
        "engines": ["depth_first", "layers"],
    }
    return SimpleNamespace(name="skull", description={"films": [row]})


def test_one_film_passes_and_names_the_engines():
    (line,) = describe_films([job(1)])
    assert "9 renders in 1 groups" in line and "depth_first, layers" in line
    assert films_exit_code([job(1)]) == 0


def test_two_films_fail_with_scene_model_and_tracer():
    lines = describe_films([job(1), job(2)])
    assert lines[0].startswith("FAIL") and "skull haste haste-cpu" in lines[0]
    assert "1 groups with films that differ" in lines[-1]
    assert films_exit_code([job(1), job(2)]) == 1


def test_a_run_without_promises_says_nothing():
    empty = SimpleNamespace(name="lamp", description={})
    assert describe_films([empty]) == [] and films_exit_code([empty]) == 0
