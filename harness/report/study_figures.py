"""Figures of the study of packets: throughput and memory, the ladder, the time line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, NullLocator

from harness.report import numbers
from harness.report.figures import power_of_two, powers_of_two
from harness.report.study import WORDS, Panel, Variant, panels_of
from harness.report.style import FAINT, INK, figure_style, make_panels
from harness.report.tables import find_knee
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.study import RAY_BYTES

ENGINE_COLOURS = {
    "packets": "#0072b2",
    "streams": "#56b4e9",
    "layers": "#e69f00",
    "wavefront": "#d55e00",
    "persistent": "#009e73",
    "depth_first": "#555b63",
}
"""Okabe and Ito's, apart for colour-blind readers; tracers have other ones."""
WORK_COLOURS = {
    "pop": "#cc79a7",
    "allocate": "#f0e442",
    "upload": "#56b4e9",
    "trace": "#d55e00",
    "download": "#009e73",
    "push": "#a05195",
}
LADDER = (
    ("packets", "per_packet"),
    ("packets", "once"),
    ("streams", ""),
    ("layers", ""),
    ("wavefront", ""),
    ("persistent", ""),
    ("depth_first", ""),
)
BOUNDS = {
    "bus": ("bus, pinned, both ways at once", (0, (5, 2))),
    "device": ("device memory, a ray written and read once", (0, (1, 1))),
    "kernel": ("kernels alone", (0, (3, 1, 1, 1))),
    "queue": ("push and pop on the host alone", (0, (2, 2))),
}


def _style(variant: Variant) -> str:
    return "--" if variant.allocation == "per_packet" or variant.order == "lifo" else "-"


def plot_throughput(
    measurements: Measurements, variants: Sequence[Variant], panel: Panel, tracer: str
) -> Figure | None:
    """Rays a second and what waits in the queue, both over the size of a launch.

    None unless at least one engine was swept widely enough for a law.
    """
    own = [one for one in variants if one.panel == panel and one.tracer == tracer]
    if not any(one.find(measurements, "r_inf") for one in own):
        return None
    with figure_style():
        figure, (speed, memory) = make_panels(1, 2, 4.3)
        shown = [one for one in own if one.order != "lifo"]
        for variant in shown:
            _draw_rates(speed, measurements, variant)
        bounds = _draw_bounds(speed, measurements, own)
        for variant in own:
            _draw_queue(memory, measurements, variant)
        speed.set_xscale("log", base=2)
        speed.set_yscale("log")
        speed.xaxis.set_minor_locator(NullLocator())
        speed.xaxis.set_major_formatter(FuncFormatter(power_of_two))
        speed.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        speed.set_title(f"{panel[0]}, {panel[1]}")
        speed.set_xlabel("queued rays a launch")
        speed.set_ylabel("million queued rays a second")
        memory.set_yscale("log", base=2)
        memory.yaxis.set_minor_locator(NullLocator())
        memory.yaxis.set_major_formatter(FuncFormatter(lambda value, _: numbers.size(value)))
        memory.set_title("peak of the queue")
        memory.set_xlabel("rays a packet")
        handles = [
            Line2D([], [], color=ENGINE_COLOURS[name], marker="o", ms=3.5, mfc="white", label=name)
            for name in dict.fromkeys(one.engine for one in own)
        ]
        handles += [
            Line2D([], [], color=INK, ls="--", label="allocated each time; right: lifo"),
            *(Line2D([], [], color=FAINT, ls=BOUNDS[b][1], label=BOUNDS[b][0]) for b in bounds),
        ]
        figure.legend(handles=handles, loc="outside upper left", ncols=4, borderaxespad=0.2)
    return figure


def _draw_rates(axes: Axes, measurements: Measurements, variant: Variant) -> None:
    """Measured rates, the law as a thin line, the knee filled."""
    rates = variant.rates(measurements)
    rays = variant.sweep(measurements, "launch_rays")
    sizes = [size for size in rates if size in rays]
    if not sizes:
        return
    colour, style = ENGINE_COLOURS[variant.engine], _style(variant)
    x = [rays[size].value for size in sizes]
    y = [rates[size].value * 1e-6 for size in sizes]
    for place, size in zip(x, sizes, strict=True):
        interval = rates[size].scaled(1e-6)
        if np.isfinite(interval.lower) and interval.lower > 0:
            axes.vlines(place, interval.lower, interval.upper, color=colour, lw=1.0, alpha=0.6)
    axes.plot(x, y, color=colour, ls=style, marker="o", ms=3.5, mfc="white")
    knee = find_knee(rates)
    if knee in rays:
        axes.plot(rays[knee].value, rates[knee].value * 1e-6, color=colour, marker="o", ms=6.0)
    r_inf, half = (variant.find(measurements, name) for name in ("r_inf", "n_half"))
    if r_inf is not None and half is not None and np.isfinite(r_inf.value):
        n = np.geomspace(min(x), max(x), 200)
        law = r_inf.value * n / (n + max(half.value, 0.0))
        axes.plot(n, law * 1e-6, color=colour, lw=0.6, alpha=0.7)


def _draw_queue(axes: Axes, measurements: Measurements, variant: Variant) -> None:
    queue = variant.sweep(measurements, "peak_queue_bytes")
    found = {size: value.value for size, value in queue.items() if value.value > 0}
    # Where device memory is allocated changes no queue.
    if variant.size_key != "packet" or variant.allocation == "per_packet" or not found:
        return
    axes.plot(
        list(found),
        list(found.values()),
        color=ENGINE_COLOURS[variant.engine],
        ls="--" if variant.order == "lifo" else "-",
        marker="o",
        ms=3.5,
        mfc="white",
    )
    powers_of_two(axes, found, max(1, len(found) // 6))
    axes.xaxis.set_major_formatter(FuncFormatter(power_of_two))


def bounds_of(
    measurements: Measurements, variants: Sequence[Variant]
) -> dict[str, dict[float, float]]:
    """What no schedule on the host can beat, [rays/s] over the rays of a launch.

    The bus carries every ray up that is not a camera's, which the device can make itself, and down
    when it is spawned: both ways at once. Kernels alone are those of `layers` at the same size;
    push and pop are those of `packets`.
    """
    bounds: dict[str, dict[float, float]] = {}
    by_engine = {one.engine: one for one in variants if one.order != "lifo"}
    packets, layers = by_engine.get("packets"), by_engine.get("layers")
    for name, variant, quantity in (
        ("kernel", layers, "kernel_seconds"),
        ("queue", packets, "queue_seconds"),
    ):
        if variant is None:
            continue
        rays, launches = (variant.sweep(measurements, q) for q in ("launch_rays", "launches"))
        spent = variant.sweep(measurements, quantity)
        bounds[name] = {
            rays[size].value: rays[size].value * launches[size].value / spent[size].value
            for size in spent
            if size in rays and size in launches and spent[size].value > 0
        }
    if packets is None:
        return bounds
    where = {"scene": packets.scene, "model": packets.model, "tracer": packets.tracer}
    copies = {
        name: measurements.find("copy_rate", engine="none", case=f"copy={name}", **where)
        for name in ("pinned_both", "device")
    }
    rates = {
        kind: packets.sweep(measurements, "rays_per_second", rays=kind)
        for kind in ("camera", "queued")
    }
    size = max(rates["queued"], default=0)
    if copies["pinned_both"] and copies["device"] and size:
        camera = rates["camera"][size].value / rates["queued"][size].value
        ends = [0.0, float("inf")]
        bus = copies["pinned_both"].value / (RAY_BYTES * (1.0 - camera))
        bounds["bus"] = dict.fromkeys(ends, bus)
        bounds["device"] = dict.fromkeys(ends, copies["device"].value / (2 * RAY_BYTES))
    return {name: bound for name, bound in bounds.items() if bound}


def _draw_bounds(axes: Axes, measurements: Measurements, variants: Sequence[Variant]) -> list[str]:
    bounds = bounds_of(measurements, variants)
    for name, bound in bounds.items():
        style = BOUNDS[name][1]
        if 0.0 in bound:
            axes.axhline(1e-6 * bound[0.0], color=FAINT, ls=style, lw=1.1)
        else:
            places = sorted(bound)
            values = [1e-6 * bound[place] for place in places]
            axes.plot(places, values, color=FAINT, ls=style, lw=1.1)
    return [name for name in BOUNDS if name in bounds]


def plot_ladder_bars(
    measurements: Measurements, variants: Sequence[Variant], tracer: str
) -> Figure | None:
    """The engines as bars, each at its best size, with its gain over the rung before."""
    ladders: dict[Panel, list[tuple[str, str, Interval]]] = {}
    own = [one for one in variants if one.tracer == tracer]
    for engine, allocation in LADDER:
        for panel in panels_of(own):
            rates = [
                (one, rate)
                for one in own
                if (one.panel, one.engine) == (panel, engine)
                # Without a device there is nothing to allocate: one rung.
                and one.allocation
                in ({allocation} if allocation == "per_packet" else {allocation, ""})
                for rate in one.rates(measurements).values()
            ]
            if rates:
                one, best = max(rates, key=lambda found: found[1].value)
                label = ", ".join(filter(None, (engine, WORDS.get(one.allocation, ""))))
                ladders.setdefault(panel, []).append((engine, label, best))
    if not ladders:
        return None
    labels = list(dict.fromkeys(label for rungs in ladders.values() for _, label, _ in rungs))
    with figure_style():
        figure, all_axes = make_panels(-(-len(ladders) // 2), 2, 0.9 + 0.27 * len(labels))
        for axes, (panel, rungs) in zip(all_axes, ladders.items(), strict=False):
            before = None
            end = 1.5 * max(rate.value * 1e-6 for _, _, rate in rungs)
            for engine, label, rate in rungs:
                row = labels.index(label)
                mega = rate.scaled(1e-6)
                axes.barh(row, mega.value, height=0.62, color=ENGINE_COLOURS[engine], alpha=0.85)
                if np.isfinite(mega.lower):
                    axes.hlines(row, mega.lower, mega.upper, color=INK, lw=1.2)
                gain = "" if before is None else f", × {numbers.significant(rate.value / before)}"
                # At the edge, over whatever part of the interval reaches there.
                axes.annotate(
                    f"{numbers.significant(mega.value)}{gain}",
                    (0.995 * end, row),
                    ha="right",
                    va="center",
                    fontsize=7.5,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
                )
                before = rate.value
            axes.set_xlim(0.0, end)
            axes.set_ylim(len(labels) - 0.4, -0.6)
            axes.set_yticks(range(len(labels)), labels)
            axes.grid(visible=False, axis="y")
            axes.set_title(f"{panel[0]}, {panel[1]}")
            axes.set_xlabel("million queued rays a second")
        for axes in all_axes[len(ladders) :]:
            axes.set_axis_off()
    return figure


Span = Mapping[str, object]


def plot_timeline(renders: Sequence[tuple[str, Sequence[Span]]], title: str) -> Figure | None:
    """Copies, kernels and the queue's own work over time, one block of rows a render.

    renders: label and spans; each is drawn from its first span on, as long as the shortest render's
    spans reach, but at least four packets of the slowest. None without spans.
    """
    drawn = [(label, _sorted(spans)) for label, spans in renders if spans]
    if not drawn:
        return None
    rows: list[tuple[str, str]] = []
    for label, spans in drawn:
        lanes = sorted({int(str(span["lane"])) for span in spans})
        rows += [(label, f", stream {lane + 1}" if len(lanes) > 1 else "") for lane in lanes]
    window = max(_four_packets(spans) for _, spans in drawn)
    with figure_style():
        figure, (axes,) = make_panels(1, 1, 0.9 + 0.34 * len(rows))
        row = 0
        for _, spans in drawn:
            start = float(str(spans[0]["begin"]))
            lanes = sorted({int(str(span["lane"])) for span in spans})
            for lane in lanes:
                for span in spans:
                    begin = float(str(span["begin"])) - start
                    if span["lane"] != lane or begin > window:
                        continue
                    width = min(float(str(span["end"])) - start, window) - begin
                    axes.barh(
                        row,
                        1e3 * width,
                        left=1e3 * begin,
                        height=0.74,
                        color=WORK_COLOURS[str(span["kind"])],
                        lw=0,
                    )
                row += 1
        names = [f"{label}{lane}" for label, lane in rows]
        axes.set_yticks(range(len(rows)), names)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlim(0.0, 1e3 * window)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("milliseconds")
        axes.set_title(title)
        seen = {str(span["kind"]) for _, spans in drawn for span in spans}
        handles = [Patch(color=WORK_COLOURS[k], label=k) for k in WORK_COLOURS if k in seen]
        figure.legend(handles=handles, loc="outside upper left", ncols=6, borderaxespad=0.2)
    return figure


def _sorted(spans: Sequence[Span]) -> list[Span]:
    return sorted(spans, key=lambda span: float(str(span["begin"])))


def _four_packets(spans: Sequence[Span]) -> float:
    """Seconds from the first span to the end of the fourth kernel."""
    start = float(str(spans[0]["begin"]))
    ends = [float(str(span["end"])) - start for span in spans if span["kind"] == "trace"]
    return ends[min(3, len(ends) - 1)] if ends else float(str(spans[-1]["end"])) - start
