"""Numbers as text: significant digits, prefixes, intervals."""

from __future__ import annotations

import math

from harness.statistics.intervals import Interval

MISSING = "–"


def signed(text: str) -> str:
    """Replace the hyphen of a negative number by a minus sign."""
    return text.replace("-", "−")


def significant(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, without an exponent between 1e-3 and 1e5."""
    if not math.isfinite(value):
        return MISSING if math.isnan(value) else signed("∞" if value > 0 else "-∞")
    if value == 0.0:
        return "0"
    magnitude = math.floor(math.log10(abs(value)))
    if magnitude < -3 or magnitude >= 5:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        return signed(f"{mantissa}e{int(exponent)}")
    return signed(f"{value:,.{max(0, digits - 1 - magnitude)}f}")


def bounds(interval: Interval, factor: float = 1.0, digits: int = 3) -> str:
    """The two ends in brackets, or nothing where they are not known."""
    if not (math.isfinite(interval.lower) and math.isfinite(interval.upper)):
        return ""
    lower, upper = interval.lower * factor, interval.upper * factor
    return f"[{significant(lower, digits)}, {significant(upper, digits)}]"


def percent(value: float, digits: int = 2) -> str:
    """A signed percentage without its sign of unit."""
    if not math.isfinite(value):
        return MISSING if math.isnan(value) else signed("+∞" if value > 0 else "-∞")
    # Adding zero to a negative zero makes it positive.
    return signed(f"{round(100.0 * value, digits) + 0.0:+.{digits}f}")


def fixed(interval: Interval, decimals: int) -> tuple[str, str]:
    """A value and its bounds in brackets, all with so many decimals."""
    if not math.isfinite(interval.value):
        return MISSING, ""
    ends = f"[{interval.lower:.{decimals}f}, {interval.upper:.{decimals}f}]"
    known = math.isfinite(interval.lower) and math.isfinite(interval.upper)
    return signed(f"{interval.value:.{decimals}f}"), signed(ends) if known else ""


def percent_bounds(interval: Interval, digits: int = 2) -> str:
    """The two ends of an interval as signed percentages, in brackets."""
    if not (math.isfinite(interval.lower) and math.isfinite(interval.upper)):
        return ""
    return f"[{percent(interval.lower, digits)}, {percent(interval.upper, digits)}]"


def seconds(value: float) -> str:
    """A time with the unit that suits it."""
    if not math.isfinite(value):
        return MISSING
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if value * factor >= 1.0:
            return f"{significant(value * factor)} {unit}"
    return "0" if value == 0.0 else f"{significant(value * 1e6)} µs"


def size(value: float) -> str:
    """A number of bytes with a binary prefix."""
    if not math.isfinite(value):
        return MISSING
    for power, unit in ((3, "GiB"), (2, "MiB"), (1, "KiB")):
        if value >= 1024.0**power:
            return f"{significant(value / 1024.0**power)} {unit}"
    return f"{value:.0f} B"
