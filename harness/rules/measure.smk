"""One job a scene: every tracer in every model, in turn."""


rule measure:
    input:
        settings=f"{RESULTS}/settings.json",
        features=ancient(f"{RESULTS}/features.txt"),
        scene=lookup(within=SCENE_FILES, dpath="{scene}"),
        sources=tracing_sources(),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/scenes/{{scene}}/measured.json",
    log:
        f"{RESULTS}/logs/measure-{{scene}}.log",
    conda:
        "../envs/haste.yaml"
    # The machine is the job's alone, so that no time is taken while something else runs.
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.scene}: images and times of every tracer"
    shell:
        "{params.python:q} -m harness measure --settings {input.settings:q} "
        "--scene {wildcards.scene:q} --threads {threads} 2>&1 | tee -i {log:q}"
