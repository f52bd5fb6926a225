"""The command that makes a row of a report again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.measure.config import ROOT
from harness.report.tables import Table
from harness.tables.read import MODELS, scene_names

FOLDER = "results/again"
"""Where the row's run is written, apart from the run that is reported."""
OF_RAYS = frozenset({"rays", "ray_ratios", "ray_hierarchies", "rays_skipped"})
OF_STUDY = frozenset({"launch_laws", "launch_work", "queue_memory", "prices"})
OF_FEATURES = frozenset({"features"})
OF_STABILITY = frozenset({"cracks", "precisions", "surfaces", "stability_trade"})
"""Tables of benchmarks that have jobs of their own; all others are of the scenes' jobs."""


def preset_option(provenance: Mapping[str, Any]) -> list[str]:
    """Arguments that name the settings of a run, none where they are the default."""
    run = str(provenance["run"])
    preset = Path("config") / f"{run}.yaml"
    return [] if run == "quick" or not (ROOT / preset).is_file() else ["--configfile", str(preset)]


def _flow(value: Any) -> str:
    """A value as Snakemake's --config reads it: YAML in one line, without quotes."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return str(value)


def _chosen(names: list[str], scene: str) -> list[str]:
    """The scene where it is among the names, all of them where a row is of no single one."""
    return [scene] if scene in names else names


def _study(config: Mapping[str, Any], *, wanted: bool, scene: str, model: str) -> dict[str, Any]:
    """The study of a row's scene and model, or none: panels can be emptied, not taken out."""
    panels = config.get("panels", {})
    elsewhere = config.get("elsewhere", {}).get("scenes", [])
    return {
        "panels": {
            name: [model] if wanted and name == scene and model in models else []
            for name, models in panels.items()
        },
        "elsewhere": {"scenes": [name for name in elsewhere if wanted and name == scene]},
    }


def _stability(table: str, config: Mapping[str, Any], scene: str) -> dict[str, Any]:
    """The jobs of stability that a row is of, or none."""
    meshes = config.get("scenes", [])
    modes = config.get("modes", {}).get("scenes", [])
    return {
        "scenes": _chosen(meshes, scene) if table == "cracks" else [],
        "modes": {"scenes": _chosen(modes, scene) if table == "precisions" else []},
        "suites": ["surfaces"] if table == "surfaces" else [],
    }


def _changes(table: str, config: Mapping[str, Any], scene: str, model: str) -> dict[str, Any]:
    """Settings under which no more is rendered than a row needs."""
    asked = config.get("scenes", [])
    asked = [asked] if isinstance(asked, str) else asked
    known = dict(zip(scene_names(asked), asked, strict=True))
    changes: dict[str, Any] = {"results_dir": FOLDER}
    if table in OF_RAYS | OF_STUDY | OF_FEATURES | OF_STABILITY:
        changes["scenes"] = []
    elif scene in known:
        changes["scenes"] = [known[scene]]
    # Every table of scenes has ratios, or ways to the picture of `path`.
    if model in MODELS and table not in OF_RAYS | OF_FEATURES | OF_STABILITY:
        changes["models"] = list(dict.fromkeys(["path", model]))
    # This one joins what the others of its page say.
    trade = table == "stability_trade"
    if "rays" in config and not trade:
        wanted = config["rays"].get("scenes", [])
        changes["rays"] = {"scenes": _chosen(wanted, scene) if table in OF_RAYS else []}
    if "features" in config:
        wanted = config["features"].get("scenes", [])
        changes["features"] = {"scenes": _chosen(wanted, scene) if table in OF_FEATURES else []}
    if "study" in config:
        changes["study"] = _study(
            config["study"], wanted=table in OF_STUDY, scene=scene, model=model
        )
    if "stability" in config and not trade:
        changes["stability"] = _stability(table, config["stability"], scene)
    return changes


def command_of(table: str, provenance: Mapping[str, Any], scene: str = "", model: str = "") -> str:
    """A command line that renders what a row is made of, and writes its report.

    Of the tracers all stay: a row says how one does beside the others in the same rounds. scene and
    model: empty where the row is of all of them.
    """
    changes = _changes(table, provenance.get("config", {}), scene, model)
    settings = [f"{key}={_flow(value)}" for key, value in changes.items()]
    return shlex.join(["./bench", "all", *preset_option(provenance), "--config", *settings])


def commands_of(table: Table, provenance: Mapping[str, Any]) -> list[str]:
    """The command of each row of a table, in the order of the page."""
    names = set(scene_names(provenance.get("config", {}).get("scenes", [])))
    names |= set(provenance.get("scenes", {})) | set(provenance.get("rays", {}))
    for part in ("stability", "features"):
        names |= set(provenance.get("config", {}).get(part, {}).get("scenes", []))
    rows = [(heading, row) for heading, group in table.groups for row in group]
    one_to_one = len(table.frame) == len(rows)
    records = table.frame.to_dict("records") if one_to_one else [{}] * len(rows)
    found = []
    for (heading, row), record in zip(rows, records, strict=True):
        # Where the file has more rows than the page, the page names the scene of its own.
        named = next((text for text in (heading, row[0].text) if text in names), "")
        scene, model = str(record.get("scene", named)), record.get("model")
        found.append(command_of(table.name, provenance, scene, str(model) if model else ""))
    return found
