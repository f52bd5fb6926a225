"""The report: one page that needs nothing else."""


rule report:
    input:
        samples=f"{RESULTS}/samples.parquet",
        measurements=f"{RESULTS}/measurements.csv",
        settings=f"{RESULTS}/settings.json",
        sources=module_sources("harness.report.write"),
        texts=package_sources("harness/report", "harness/captions", "harness/schemas"),
    output:
        f"{RESULTS}/report.html",
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
