"""The two tables of a run, from the files of all its scenes."""


rule tables:
    input:
        truth=expand(f"{RESULTS}/scenes/{{scene}}/truth.json", scene=SCENES),
        measured=expand(f"{RESULTS}/scenes/{{scene}}/measured.json", scene=SCENES),
        rays=expand(f"{RESULTS}/rays/{{scene}}/replayed.json", scene=RAY_FILES),
        prices=expand(f"{RESULTS}/features/{{scene}}/priced.json", scene=PRICE_FILES),
        stability=rules.stability.input,
        studies=[
            f"{RESULTS}/study/{scene}/{model}/studied.json"
            for scene, model in SETTINGS.study_panels
        ],
        settings=f"{RESULTS}/settings.json",
        sources=module_sources("harness.tables.write"),
        schemas=package_sources("harness/schemas"),
    output:
        f"{RESULTS}/samples.parquet",
        f"{RESULTS}/measurements.csv",
    log:
        f"{RESULTS}/logs/tables.log",
    conda:
        "../envs/haste.yaml"
    params:
        python=PYTHON,
    message:
        "Tables of the run"
    shell:
        "{params.python:q} -m harness tables --settings {input.settings:q} 2>&1 | tee -i {log:q}"
