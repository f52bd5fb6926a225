"""Writer of the report: report.html, figures/*.svg and tables/*.csv."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from harness.answers import judge_answers
from harness.bounds import settings_of
from harness.gate import judge
from harness.report.agreement_figure import plot_agreement
from harness.report.answers_figure import plot_answers
from harness.report.answers_table import answers_table
from harness.report.budget_table import budget_table, crossover_table
from harness.report.eye_rays_table import eye_rays_table
from harness.report.features import find_prices, plot_prices, price_list, priced_models
from harness.report.figures import plot_convergence, plot_packets, plot_plane
from harness.report.gallery import make_strip
from harness.report.knobs_table import knobs_table
from harness.report.ladder import find_rungs, ladder_table, plot_ladder
from harness.report.rays import (
    find_ray_rows,
    hierarchy_table,
    missing_table,
    optix_note,
    ratio_table,
    ray_table,
)
from harness.report.rays_figures import plot_ray_ratios, plot_ray_tests
from harness.report.stability_page import stability_parts, stability_tables
from harness.report.study import compared_sizes, find_variants, panels_of, timelines
from harness.report.study_figures import plot_ladder_bars, plot_throughput, plot_timeline
from harness.report.study_tables import law_table, memory_table, price_table, work_table
from harness.report.style import colour_of, save_svg
from harness.report.summary import (
    collect_facts,
    explain_gate,
    make_matrix,
    reproduce,
    summarise,
    warn_of_load,
)
from harness.report.tables import (
    Table,
    absence_table,
    error_table,
    packets_table,
    speed_table,
    times_table,
    verdict_table,
)
from harness.report.trade_figure import plot_trade
from harness.tables.lookup import read_measurements
from harness.tables.rays import RATIOS_TO, read_ray_jobs
from harness.tables.read import SceneJob, read_jobs
from harness.tables.study import read_study
from harness.tables.write import merge_provenance
from harness.whole_files import write_whole, written_whole

HERE = Path(__file__).resolve().parent
CAPTIONS = HERE.parent / "captions"


@dataclass(frozen=True, slots=True)
class Embedded:
    """A figure inside the page."""

    title: str
    svg: str
    caption: str


def _embed(svg: str, prefix: str) -> str:
    """Make an SVG file part of a page: no prologue, and ids that no other figure has."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", body)
    return re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', body)


def read_captions() -> dict[str, str]:
    """The texts of harness/captions, by name."""
    return {path.stem: path.read_text().strip() for path in sorted(CAPTIONS.glob("*.rst"))}


@dataclass
class _Figures:
    folder: Path
    names: list[str]

    def add(self, name: str, figure: Figure | None, title: str, caption: str) -> Embedded | None:
        if figure is None:
            return None
        path = self.folder / f"{name}.svg"
        save_svg(figure, path)
        self.names.append(path.name)
        return Embedded(title, _embed(path.read_text(), name), caption)


def _detail(job: SceneJob) -> str:
    parts = [f"{job.width} × {job.height}"]
    for noun in ("triangles", "spheres"):
        count = job.description.get(noun)
        if count:
            parts.append(f"{count:,} {noun}")
    return ", ".join([*parts, *(["caustic"] if job.caustic else [])])


def _write_csv(folder: Path, tables: list[Table | None]) -> None:
    for table in tables:
        if table is not None:
            with written_whole(folder / f"{table.name}.csv") as (path,):
                table.frame.to_csv(path, index=False, float_format="%.9g", lineterminator="\n")


def write_report(results_dir: Path) -> Path:
    """Write report.html with its figures and tables beside it; returns its path.

    Reads measurements.csv, which the tables' writer must have written before, and the images of the
    scene jobs. The page needs no other file; links lead to the CSV and SVG files beside it. Raises
    ResultsError for missing or damaged files.
    """
    jobs = read_jobs(results_dir)
    measurements = read_measurements(results_dir / "measurements.csv")
    settings = settings_of(jobs)
    judgements, absent = judge(jobs, settings)
    answers = judge_answers(jobs)
    ray_jobs = read_ray_jobs(results_dir)
    provenance = merge_provenance(jobs, ray_jobs)
    captions = read_captions()
    figures = _Figures(results_dir / "figures", [])
    # A known answer is one colour all over the image, and judged by more than the truth.
    pictured = [job for job in jobs if not job.description.get("answers")]
    panels = [(job.name, model) for job in jobs for model in job.models]
    scenes = [
        {
            "title": job.title,
            "detail": _detail(job),
            "strips": [
                strip
                for model in job.models
                if (strip := make_strip(job, model, judgements, settings.tile)) is not None
            ],
        }
        for job in pictured
    ]
    convergence = [
        figures.add(
            f"convergence-{job.name}",
            plot_convergence(measurements, job.name, job.models),
            job.title,
            "",
        )
        for job in jobs
    ]
    planes = [
        figures.add(
            f"plane-{job.name}", plot_plane(measurements, job.name, job.models), job.title, ""
        )
        for job in jobs
    ]
    trades = [
        figures.add(f"trade-{job.name}", plot_trade(measurements, job), job.title, "")
        for job in pictured
    ]
    rungs = find_rungs(measurements, jobs)
    ray_rows = find_ray_rows(measurements)
    optix = optix_note(ray_jobs)
    ray_figures = [
        figures.add(
            f"rays-{other}",
            plot_ray_ratios(ray_rows, other),
            f"Rays a second over {other}",
            f"{captions['ray_ratios']} {optix}".strip(),
        )
        for other in RATIOS_TO
    ]
    primitives = {job.name: job.primitives for job in ray_jobs}
    ray_figures.append(
        figures.add(
            "ray-tests", plot_ray_tests(ray_rows, primitives), "Tests a ray", captions["ray_tests"]
        )
    )
    prices = find_prices(measurements)
    feature_figures = [
        figures.add(f"features-{model}", plot_prices(prices, model), f"Features, {model}", "")
        for model in priced_models(prices)
    ]
    studies = read_study(results_dir)
    variants, sizes = find_variants(measurements), compared_sizes(studies)
    study_figures = [
        figures.add(
            f"study-ladder-{tracer}",
            plot_ladder_bars(measurements, variants, tracer),
            f"The ladder, {tracer}",
            captions["study_ladder"],
        )
        for tracer in dict.fromkeys(one.tracer for one in variants)
    ]
    study_figures += [
        figures.add(
            f"study-{scene}-{model}-{tracer}",
            plot_throughput(measurements, variants, (scene, model), tracer),
            f"{scene}, {model}, {tracer}",
            captions["study_throughput"],
        )
        for scene, model in panels_of(variants)
        for tracer in dict.fromkeys(one.tracer for one in variants)
    ]
    study_figures += [
        figures.add(
            f"study-timeline-{job.name}-{job.model}",
            plot_timeline(timelines(job), f"{job.name}, {job.model}"),
            f"Copies and kernels, {job.name}, {job.model}",
            captions["study_timeline"],
        )
        for job in studies
        if job.model in job.provenance["config"]["study"]["panels"].get(job.name, [])
    ]
    tables = {
        "verdicts": verdict_table(judgements),
        "skipped": absence_table(absent, jobs),
        "answers": answers_table(answers),
        "speed": speed_table(measurements, jobs),
        "errors": error_table(measurements, pictured),
        "sweep": packets_table(measurements, jobs),
        "engines": ladder_table(rungs),
        "times": times_table(measurements, jobs),
        "eye_rays": eye_rays_table(jobs),
        "rays": ray_table(ray_rows),
        "ray_ratios": ratio_table(ray_rows),
        "ray_hierarchies": hierarchy_table(ray_rows),
        "rays_skipped": missing_table(ray_rows),
        "budget": budget_table(measurements, pictured),
        "crossover": crossover_table(measurements, pictured),
        "launch_laws": law_table(measurements, variants),
        "launch_work": work_table(measurements, variants, sizes),
        "queue_memory": memory_table(measurements),
        "prices": price_table(measurements, sizes),
        "feature_prices": price_list(prices),
        "knobs": knobs_table(measurements, pictured),
        **stability_tables(measurements),
    }
    _write_csv(results_dir / "tables", list(tables.values()))
    environment = Environment(
        loader=FileSystemLoader(HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("page.html.j2").render(
        title="Haste: what speed costs in accuracy",
        subtitle=f"Ray tracers against a ground truth. Run “{provenance['run']}”.",
        css=(HERE / "page.css").read_text(),
        colour=colour_of,
        summary=summarise(jobs, judgements, absent, measurements),
        question=explain_gate(settings, judgements),
        warning=warn_of_load(jobs),
        matrix=make_matrix(jobs, judgements, absent),
        agreement=figures.add(
            "agreement", plot_agreement(judgements), "Agreement", captions["agreement"]
        ),
        answers_figure=figures.add(
            "answers", plot_answers(answers), "Known answers", captions["answers"]
        ),
        scenes=scenes,
        captions=captions,
        convergence=[figure for figure in convergence if figure],
        packets=figures.add("packets", plot_packets(measurements, panels), "Packet sizes", ""),
        ladder=figures.add("engines", plot_ladder(rungs), "Engines", ""),
        planes=[figure for figure in planes if figure],
        **stability_parts(measurements, results_dir, figures.add, captions),
        ray_figures=[figure for figure in ray_figures if figure],
        optix=optix,
        feature_figures=[figure for figure in feature_figures if figure],
        study_figures=[figure for figure in study_figures if figure],
        trades=[figure for figure in trades if figure],
        facts=collect_facts(provenance, jobs),
        provenance=json.dumps(provenance, indent=1, sort_keys=True),
        commands=reproduce(provenance, jobs),
        figure_names=figures.names,
        footer="Made by Haste from measurements.csv and the images of the run.",
        **tables,
    )
    path = results_dir / "report.html"
    write_whole(path, page)
    return path
