"""What two runs are compared in: every quantity but those that a clock has a part in."""

from __future__ import annotations

import re

import pandas as pd
from runs import CLOCKED, is_timed, without_timings

from harness.tables.schema import load_list

QUANTITIES = load_list("quantities")
TIMED = ("seconds", "samples_per_second", "speed_ratio", "paired_speed", "paired_rate")
RATIOS_OF_TIMES = ("feature_price", "determinism_price", "speed_up", "law_kink_ratio")
TIMELESS = ("relmse", "paired_bias", "registers", "rays_per_sample", "eye_rays_hit", "cracks_ppm")


def test_rows_of_times_and_of_ratios_of_times_are_left_out_and_no_others():
    table = pd.DataFrame({"quantity": [*TIMED, *TIMELESS, *RATIOS_OF_TIMES]})
    kept = list(without_timings(table).quantity)
    assert kept == list(TIMELESS), f"of {list(table.quantity)} these were kept: {kept}"


def test_a_table_without_rows_stays_one():
    empty = pd.DataFrame({"quantity": pd.Series([], dtype=str), "value": pd.Series([], dtype=str)})
    kept = without_timings(empty)
    assert kept.empty and list(kept.columns) == list(empty.columns), kept


def test_a_quantity_whose_meaning_speaks_of_time_is_one_of_a_clock():
    """A new ratio of times is noticed here rather than by two runs that differ now and then."""
    missed = {
        name: entry["meaning"]
        for name, entry in QUANTITIES.items()
        if re.search(r"(?<!half of the )\b(time|seconds?)\b", entry["meaning"])
        if not is_timed(name)
    }
    assert not missed, f"neither in CLOCKED nor of a unit with seconds: {missed}"


def test_the_quantities_of_a_clock_are_on_the_closed_list():
    unknown = CLOCKED - set(QUANTITIES)
    assert not unknown, f"not on the list: {sorted(unknown)}"
    named_twice = {name for name in CLOCKED if "s" in re.split(r"[ /]", QUANTITIES[name]["unit"])}
    assert not named_twice, f"their units say so already: {sorted(named_twice)}"
