"""The ground truth of a scene, rendered by Mitsuba in independent batches."""


rule truth:
    input:
        settings=f"{RESULTS}/settings.json",
        features=ancient(f"{RESULTS}/features.txt"),
        scene=lookup(within=SCENE_FILES, dpath="{scene}"),
        sources=module_sources("harness.measure.truth"),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/scenes/{{scene}}/truth.json",
    log:
        f"{RESULTS}/logs/truth-{{scene}}.log",
    conda:
        "../envs/haste.yaml"
    # The machine is the job's alone, so that no time is taken while something else runs.
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.scene}: ground truth"
    shell:
        "{params.python:q} -m harness truth --settings {input.settings:q} "
        "--scene {wildcards.scene:q} --threads {threads} 2>&1 | tee -i {log:q}"
