"""Tables of the study of packets: laws, work, prices, memory."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from harness.report import numbers
from harness.report.study import WORDS, Panel, Variant, panels_of
from harness.report.tables import Cell, Column, Table, columns_of, number_cell
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.schema import parse_case
from harness.tables.study import RAY_BYTES

NINE_TENTHS = 0.9


def _groups(
    variants: Sequence[Variant], rows: Sequence[tuple[Variant, list[Cell]]]
) -> list[tuple[str, list[list[Cell]]]]:
    return [
        (
            f"{scene}, {model}",
            [cells for variant, cells in rows if variant.panel == (scene, model)],
        )
        for scene, model in panels_of(variants)
    ]


def _identity(variant: Variant) -> list[Cell]:
    return [Cell(variant.tracer, kind="tracer"), Cell(variant.label, kind="text")]


def _record(variant: Variant) -> dict[str, object]:
    return {
        "scene": variant.scene,
        "model": variant.model,
        "tracer": variant.tracer,
        "engine": variant.engine,
        "order": variant.order,
        "allocation": variant.allocation,
    }


IDENTITY = [Column("tracer", kind="text"), Column("engine", kind="text")]


def smallest_reaching(
    rates: dict[int, Interval], r_inf: Interval, share: float = NINE_TENTHS
) -> int | None:
    """The smallest launch whose measured rate reaches a share of R; None if none does."""
    return min((n for n, rate in rates.items() if rate.value >= share * r_inf.value), default=None)


def law_table(measurements: Measurements, variants: Sequence[Variant]) -> Table | None:
    """T0, R and N_1/2 of every engine, and where the law fails; None where none was fitted."""
    rows, records = [], []
    best: dict[tuple[Panel, str], float] = {}
    for variant in variants:
        r_inf = variant.find(measurements, "r_inf")
        if r_inf is not None:
            key = (variant.panel, variant.tracer)
            best[key] = max(best.get(key, 0.0), r_inf.value)
    for variant in variants:
        r_inf = variant.find(measurements, "r_inf")
        if r_inf is None:
            continue
        empty, half = (variant.find(measurements, name) for name in ("launch_seconds", "n_half"))
        found = {
            name: variant.find(measurements, f"law_{name}")
            for name in ("scatter", "runs_p_value", "kink_p_value", "kink_rays", "kink_ratio")
        }
        reaching = smallest_reaching(variant.rates(measurements), r_inf)
        share = r_inf.value / best[variant.panel, variant.tracer]
        kink, ratio = found["kink_rays"], found["kink_ratio"]
        fails = "–"
        if kink is not None and ratio is not None:
            fails = f"from {numbers.significant(kink.value)} rays on × "
            fails += numbers.significant(ratio.value, 2)
        rows.append(
            (
                variant,
                [
                    *_identity(variant),
                    number_cell(empty, 1e6),
                    number_cell(r_inf, 1e-6),
                    number_cell(half, 1e-3),
                    Cell(numbers.significant(share, 2)),
                    Cell(f"{reaching:,}" if reaching else numbers.MISSING),
                    number_cell(found["scatter"], 100.0, 2),
                    Cell(fails, kind="text"),
                ],
            )
        )
        record = _record(variant) | columns_of("launch_seconds", empty)
        record |= columns_of("r_inf", r_inf) | columns_of("n_half", half)
        record |= {name: value.value if value else None for name, value in found.items()}
        records.append(record | {"share_of_fastest": share, "reaches_90_percent_at": reaching})
    if not rows:
        return None
    columns = [
        *IDENTITY,
        Column("T₀", "µs"),
        Column("R∞", "M rays/s"),
        Column("N½", "thousand rays"),
        Column("R∞ over the fastest’s"),
        Column("90 % of R∞ from", "rays a launch"),
        Column("scatter", "%"),
        Column("a further ray takes", kind="text"),
    ]
    return Table("launch_laws", columns, _groups(variants, rows), pd.DataFrame(records))


def work_table(
    measurements: Measurements, variants: Sequence[Variant], sizes: Sequence[int]
) -> Table | None:
    """At each size where ratios are taken: launches, fill, copies, kernels, queue, energy.

    The page shows the scenes that have a law; the file has all of them.
    """
    rows, records = [], []
    names = ("launches", "packet_fill", "peak_queue_bytes", "bytes_moved", "copy_seconds")
    names += ("kernel_seconds", "queue_seconds", "allocation_seconds", "overlap", "joules")
    lawful = {one.panel for one in variants if one.find(measurements, "r_inf") is not None}
    for variant in variants:
        swept = {name: variant.sweep(measurements, name) for name in names}
        rates = variant.rates(measurements)
        every = variant.sweep(measurements, "rays_per_second", rays="all")
        for size in sizes:
            if size not in rates:
                continue
            found = {name: values.get(size) for name, values in swept.items()}
            queue = found["peak_queue_bytes"]
            length = f"{queue.value / RAY_BYTES:,.0f} rays" if queue else ""
            rows.append(
                (
                    variant,
                    [
                        *_identity(variant),
                        Cell(f"{size:,}"),
                        number_cell(rates[size], 1e-6),
                        number_cell(every.get(size), 1e-6),
                        number_cell(found["launches"]),
                        number_cell(found["packet_fill"], 100.0),
                        Cell(numbers.size(queue.value) if queue else numbers.MISSING, length),
                        Cell(_size(found["bytes_moved"])),
                        *(Cell(_time(found[name])) for name in names[4:8]),
                        number_cell(found["overlap"], 100.0, 2),
                        number_cell(found["joules"]),
                    ],
                )
            )
            record = _record(variant) | {"size": size} | columns_of("queued_rays", rates[size])
            records.append(
                record | {name: value.value if value else None for name, value in found.items()}
            )
    if not rows:
        return None
    columns = [
        *IDENTITY,
        Column("launch", "rays, or samples"),
        Column("queued rays", "M/s"),
        Column("all rays", "M/s"),
        Column("launches"),
        Column("fill", "%"),
        Column("peak queue"),
        Column("bytes moved"),
        Column("copies"),
        Column("kernels"),
        Column("queue"),
        Column("allocation"),
        Column("overlap", "%"),
        Column("energy", "J"),
    ]
    shown = [one for one in variants if one.panel in lawful] or variants
    return Table("launch_work", columns, _groups(shown, rows), pd.DataFrame(records))


def _size(interval: Interval | None) -> str:
    return (
        numbers.MISSING if interval is None or not interval.value else numbers.size(interval.value)
    )


def _time(interval: Interval | None) -> str:
    return numbers.MISSING if interval is None else numbers.seconds(interval.value)


def price_table(measurements: Measurements, sizes: Sequence[int]) -> Table | None:
    """What integers cost over floats, and allocating for each packet over once, scene by scene.

    The page shows the sizes of a launch where there are repeats enough, and packets that are taken
    first in, first out where that is a choice; the file has all.
    """
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for row in measurements.rows:
        if row.quantity not in {"determinism_price", "reallocation_price"} or row.status != "ok":
            continue
        case = parse_case(row.case)
        size = int(case.get("packet", case.get("samples", 0)))
        kind = row.quantity.removesuffix("_price")
        order, allocation = str(case.get("order", "")), str(case.get("allocation", ""))
        label = ", ".join(filter(None, (row.engine, order, WORDS.get(allocation, ""))))
        if kind == "determinism" or (size in sizes and order != "lifo"):
            groups.setdefault(f"{row.scene}, {row.model}", []).append(
                [
                    Cell(kind, kind="text"),
                    Cell(row.tracer, kind="tracer"),
                    Cell(label, kind="text"),
                    Cell(f"{size:,}"),
                    number_cell(row.interval),
                    Cell(str(row.interval.n)),
                ]
            )
        records.append(
            {
                "scene": row.scene,
                "model": row.model,
                "tracer": row.tracer,
                "engine": row.engine,
                "order": order,
                "allocation": allocation,
                "size": size,
                "price": kind,
                **columns_of("ratio", row.interval),
                "repeats": row.interval.n,
            }
        )
    if not records:
        return None
    columns = [
        Column("price of", kind="text"),
        Column("tracer", kind="text"),
        Column("engine", kind="text"),
        Column("launch", "rays, or samples"),
        Column("time over the time without"),
        Column("repeats"),
    ]
    return Table("prices", columns, list(groups.items()), pd.DataFrame(records))


def memory_table(measurements: Measurements) -> Table | None:
    """What waits in the queue over the samples of an image, in layers and in packets."""
    found: dict[tuple[str, str, str], dict[int, dict[str, float]]] = {}
    packets: dict[tuple[str, str, str], set[int]] = {}
    for row in measurements.rows:
        if row.quantity != "peak_queue_bytes" or row.status != "ok":
            continue
        case = parse_case(row.case)
        if "samples" not in case or "packet" not in case:
            continue
        key = (row.scene, row.model, row.tracer)
        name = "layers" if row.engine == "layers" else str(case.get("order", ""))
        found.setdefault(key, {}).setdefault(int(case["samples"]), {})[name] = row.interval.value
        if row.engine == "packets":
            packets.setdefault(key, set()).add(int(case["packet"]))
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for key, by_samples in found.items():
        for samples, peaks in sorted(by_samples.items()):
            sizes = [peaks.get(name) for name in ("layers", "fifo", "lifo")]
            packet = max(packets.get(key, {0}))
            groups.setdefault(f"{key[0]}, {key[1]}", []).append(
                [
                    Cell(key[2], kind="tracer"),
                    Cell(f"{samples:,}"),
                    *(Cell(numbers.size(s) if s is not None else numbers.MISSING) for s in sizes),
                    Cell(f"{packet:,}"),
                ]
            )
            records.append(
                {
                    **dict(zip(("scene", "model", "tracer"), key, strict=True)),
                    "samples": samples,
                    "packet": packet,
                    **{f"{name}_bytes": peaks.get(name) for name in ("layers", "fifo", "lifo")},
                }
            )
    if not records:
        return None
    columns = [
        Column("tracer", kind="text"),
        Column("samples of the image"),
        Column("layers of the whole image"),
        Column("packets, fifo"),
        Column("packets, lifo"),
        Column("packet", "rays"),
    ]
    return Table("queue_memory", columns, list(groups.items()), pd.DataFrame(records))
