"""The report: one page that needs nothing else, and the same with every image at full size."""

from harness.report.kinds import PUBLISHED_FIGURES, figure_category


rule report:
    input:
        samples=f"{RESULTS}/samples.parquet",
        measurements=f"{RESULTS}/measurements.csv",
        settings=f"{RESULTS}/settings.json",
        baseline=sorted(map(str, Path("results/baseline").glob("*.json"))),
        sources=module_sources("harness.report.write"),
        texts=package_sources(
            "harness/report", "harness/viewer", "harness/captions", "harness/schemas"
        ),
    output:
        page=report(
            f"{RESULTS}/report.html",
            caption="../captions/report.rst",
            category="Report",
        ),
        bundle=f"{RESULTS}/report.zip",
        figures=report(
            directory(f"{RESULTS}/figures"),
            patterns=["{figure}.svg"],
            caption="../captions/figure.rst",
            category=figure_category,
            labels={"figure": "{figure}"},
        ),
        tables=report(
            directory(f"{RESULTS}/tables"),
            patterns=["{table}.csv"],
            caption="../captions/table.rst",
            category="Tables",
            labels={"table": "{table}"},
        ),
    log:
        f"{RESULTS}/logs/report.log",
    conda:
        "../envs/haste.yaml"
    params:
        python=PYTHON,
    message:
        "Report of the run"
    shell:
        "{params.python:q} -m harness report --settings {input.settings:q} 2>&1 | tee -i {log:q}"


rule published_figures:
    input:
        runs=sorted(map(str, Path("results/published").glob("*/measurements.csv*"))),
        sources=module_sources("harness.report.published"),
    output:
        expand("docs/images/{figure}.svg", figure=PUBLISHED_FIGURES),
    log:
        "results/logs/published_figures.log",
    conda:
        "../envs/haste.yaml"
    params:
        python=PYTHON,
    message:
        "Figures of the published runs, for the documentation"
    shell:
        "{params.python:q} -m harness published 2>&1 | tee -i {log:q}"
