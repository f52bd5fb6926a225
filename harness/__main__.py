"""The steps of a run, one command each: ``python -m harness <command> --help``."""

import argparse
import errno
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from harness.measure.config import (
    ROOT,
    Config,
    ConfigError,
    find_scene,
    load_config,
    standard_scenes,
)
from harness.preflight import check_run
from harness.retarget import add_command, run_command
from harness.scene.checks import MODELS


def _truth(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.truth import truth_scene

    for scene in options.scene or config.scenes:
        truth_scene(config, scene, options.threads)
    return 0


def _measure(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.job import measure_scene

    for scene in options.scene or config.scenes:
        measure_scene(config, scene, options.threads)
    return 0


def _rays(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.rays import replay_scene

    for scene in options.scene or config.ray_scenes:
        replay_scene(config, scene, options.threads)
    return 0


def _prices(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.prices import price_scene

    for scene in options.scene or config.price_scenes:
        price_scene(config, scene, options.threads)
    return 0


def _stability(config: Config, options: argparse.Namespace) -> int:
    from harness.stability.job import measure_stability

    for scene in options.scene or config.stability_scenes:
        measure_stability(config, scene, options.threads)
    return 0


def _modes(config: Config, options: argparse.Namespace) -> int:
    from harness.stability.modes import compare_modes

    for scene in options.scene or config.mode_scenes:
        compare_modes(config, scene, options.threads)
    return 0


def _surfaces(config: Config, options: argparse.Namespace) -> int:
    from harness.stability.surfaces import measure_surfaces

    measure_surfaces(config, options.threads)
    return 0


def _sweeps(config: Config, options: argparse.Namespace) -> int:
    from harness.stability.sweeps import measure_sweeps

    measure_sweeps(config, options.threads)
    return 0


def _study(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.study import study_scene

    for scene, model in config.study_panels:
        if scene in (options.scene or [scene]) and model in (options.model or [model]):
            study_scene(config, scene, model, options.threads)
    return 0


def _tables(config: Config, options: argparse.Namespace) -> int:
    from harness.tables import write_tables

    write_tables(options.results or config.results_dir)
    return 0


def _report(config: Config, options: argparse.Namespace) -> int:
    from harness.report.write import write_report

    write_report(options.results or config.results_dir, options.baseline)
    return 0


def _check(config: Config, options: argparse.Namespace) -> int:
    from harness.gate import check

    results, judged = options.results or config.results_dir, options.speeds == "judged"
    return check(results, config["gate"], options.baseline, judge_speeds=judged)


def _baseline(config: Config, options: argparse.Namespace) -> int:
    from harness.baseline import renew
    from harness.bounds import GateSettings

    def agree() -> bool:
        if options.yes:
            return True
        if not sys.stdin.isatty():
            print("nobody to ask: --yes renews the baseline")
            return False
        return input(f"renew {options.baseline}? [y/N] ").strip().lower() in {"y", "yes"}

    results = options.results or config.results_dir
    return renew(results, options.baseline, GateSettings(**config["gate"]), agree)


def _compare(config: Config, options: argparse.Namespace) -> int:
    from harness.bounds import GateSettings
    from harness.compare import compare

    settings = GateSettings(**config["gate"])
    return compare(options.before, options.after, options.out, settings)


def _features(config: Config, options: argparse.Namespace) -> int:
    from harness.describe import describe_scene, format_description
    from harness.scene import SceneError

    asked = [*options.scenes, *(options.scene or [])]
    descriptions = []
    for name in asked or config.scenes:
        # A path is the caller's, also where a scene of the same name is shipped.
        path = Path(name)
        is_path = path.suffix == ".xml" or path.is_dir()
        source = path if asked and is_path else find_scene(name) if asked else config.scenes[name]
        size = (None, None) if asked else config.resolution(name)
        descriptions.append(describe_scene(source, *size))
        print(format_description(descriptions[-1], every_place=options.all))
    models = MODELS if asked else config["models"]
    refused = [(one.source, one.reasons(models)) for one in descriptions if one.reasons(models)]
    for source, reasons in refused if not asked else ():
        print(f"error: {SceneError(source, reasons)}", file=sys.stderr)
    return 1 if refused else 0


def _generate(config: Config, options: argparse.Namespace) -> int:
    del config
    from harness.generate import generate_scene
    from harness.scene.generated import generated_scenes

    scenes = generated_scenes()
    for name in options.scene or scenes:
        if name not in scenes:
            raise ConfigError(f"--scene {name}: nothing in it is generated")
        generate_scene(scenes[name])
        print(*scenes[name].paths, sep="\n")
    return 0


def _thumbnails(config: Config, options: argparse.Namespace) -> int:
    del config
    from harness.thumbnails import write_thumbnail

    for name in options.scene or standard_scenes():
        print(write_thumbnail(find_scene(name), options.threads))
    return 0


def _sheet(config: Config, options: argparse.Namespace) -> int:
    del config, options
    from harness.thumbnails import SHEET_SCENES, write_sheet

    folders = [find_scene(name) for name in SHEET_SCENES]
    print(write_sheet(folders, ROOT / "docs" / "images" / "scenes.jpg"))
    return 0


def _published(config: Config, options: argparse.Namespace) -> int:
    del config, options
    from harness.report.published import write_published

    for path, runs in write_published().items():
        print(f"{path}: {', '.join(runs)}")
    return 0


def _available(config: Config, options: argparse.Namespace) -> int:
    from harness.measure.crew import Crew

    with Crew(config["tracers"], options.threads, config["timeout_seconds"]) as crew:
        able = crew.probe(config["tracers"], "path")
        reasons = {row["tracer"]: row["reason"] for row in crew.rows}
    for tracer in config["tracers"]:
        print(f"{tracer:15} {'runs here' if tracer in able else reasons[tracer]}")
    return 0


NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""A full disk, a full share of it, a file larger than is allowed."""

BASELINE = ROOT / "results" / "baseline"

COMMANDS: dict[str, tuple[Callable[[Config, argparse.Namespace], int], str]] = {
    "truth": (_truth, "render the ground truth"),
    "measure": (_measure, "render and time every tracer"),
    "rays": (_rays, "trace the same rays with every tracer"),
    "prices": (_prices, "compile and time programs with more features than a scene requires"),
    "stability": (_stability, "count the rays that pass between triangles, of every tracer"),
    "modes": (_modes, "render the same samples in every precision, and compare"),
    "surfaces": (_surfaces, "count rays that hit their own surface, or leak past a close one"),
    "sweeps": (_sweeps, "push scenes with a known answer towards their extremes"),
    "study": (_study, "render with every engine, in launches of every size"),
    "tables": (_tables, "write samples.parquet and measurements.csv"),
    "report": (_report, "write report.html"),
    "check": (_check, "judge the tracers' bias; exit code 0 if all pass"),
    "baseline": (_baseline, "show what differs from the baseline, and renew it"),
    "compare": (_compare, "say what changed beyond noise between two runs; exit code 0 if nothing"),
    "features": (_features, "print what scenes require, and what of it is missing; 0 if nothing"),
    "generate": (_generate, "make the files of scenes that are not committed"),
    "thumbnails": (_thumbnails, "render the small pictures beside the scenes"),
    "sheet": (_sheet, "set those pictures side by side, for the README"),
    "published": (_published, "draw the main figures of the published runs, for docs/"),
    "available": (_available, "print which tracers this machine can run, and why not the others"),
}


JOBS = ("truth", "measure", "rays", "prices", "stability", "modes")
"""Commands that are one job a scene."""


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return number


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m harness", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, (_, text) in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument(
            "--settings",
            type=Path,
            metavar="FILE",
            help="settings (YAML or JSON) over those of config/quick.yaml",
        )
        if name == "features":
            command.add_argument(
                "scenes", nargs="*", metavar="SCENE", help="a scene's name, folder or Mitsuba file"
            )
            command.add_argument("--all", action="store_true", help="print every place")
        if name in {*JOBS, "study", "features", "generate", "thumbnails"}:
            command.add_argument(
                "--scene", action="append", metavar="NAME", help="this scene only; may be repeated"
            )
        if name in {"tables", "report", "check", "baseline"}:
            command.add_argument(
                "--results",
                type=Path,
                metavar="FOLDER",
                help="a run's folder, where it is not that of the settings",
            )
        if name in {"report", "check", "baseline"}:
            command.add_argument(
                "--baseline",
                type=Path,
                metavar="FOLDER",
                default=BASELINE,
                help="the baseline's folder (default: %(default)s)",
            )
        if name == "check":
            command.add_argument(
                "--speeds",
                choices=("judged", "told"),
                default="judged",
                help="whether a tracer fails that is slower than the baseline says; where others "
                "share the machine, as in continuous integration, it is better told only "
                "(default: %(default)s)",
            )
        if name == "baseline":
            command.add_argument("--yes", action="store_true", help="renew without asking")
        if name == "compare":
            command.add_argument("before", type=Path, help="a run's folder, or a published one")
            command.add_argument("after", type=Path, help="the folder that is set against it")
            command.add_argument(
                "--out",
                type=Path,
                metavar="FILE",
                help="write the report here (default: comparison.md in AFTER)",
            )
        if name == "study":
            command.add_argument(
                "--model", action="append", metavar="NAME", help="this model only; may be repeated"
            )
        if name in {*JOBS, "study", "surfaces", "sweeps", "available", "thumbnails"}:
            command.add_argument(
                "--threads",
                type=_positive,
                default=len(os.sched_getaffinity(0)),
                help="processor threads of a tracer (default: every core)",
            )
    add_command(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Exit codes: 0 done, 1 a verdict or an error, 130 interrupted."""
    options = _parser().parse_args(arguments)
    try:
        if options.command == "retarget":
            return run_command(options)
        config = load_config(options.settings)
        for scene in getattr(options, "scene", None) or []:
            own = {
                "rays": config.ray_scenes,
                "prices": config.price_scenes,
                "stability": config.stability_scenes,
                "modes": config.mode_scenes,
            }
            known = own.get(options.command, config.scenes)
            if options.command in JOBS and scene not in known:
                names = ", ".join(known) or "none"
                raise ConfigError(f"--scene {scene}: the settings name {names}")  # noqa: TRY301
        if options.command in {"truth", "measure"}:
            check_run(config, options.scene)
        return COMMANDS[options.command][0](config, options)
    except KeyboardInterrupt:
        print("interrupted; what was complete is kept", file=sys.stderr)
        return 130
    except ConfigError as error:
        return _refuse(error)
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        print(f"error: {error}; what was complete is kept", file=sys.stderr)
        return 1
    except _expected_errors() as error:
        return _refuse(error)


def _refuse(error: Exception) -> int:
    print(f"error: {error}", file=sys.stderr)
    return 1


def _expected_errors() -> tuple[type[Exception], ...]:
    """Errors whose message is all that a user needs; anything else is a defect and is traced."""
    from harness.rays.generate import RaysError
    from harness.scene import SceneError
    from harness.tables import ResultsError, SchemaError
    from reference.analytic import AnswerError

    return (SceneError, RaysError, ResultsError, SchemaError, AnswerError)


if __name__ == "__main__":
    sys.exit(main())
