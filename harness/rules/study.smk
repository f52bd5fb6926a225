"""The study of packets: one job a scene and model, every engine in launches of every size."""


rule study:
    input:
        settings=f"{RESULTS}/settings.json",
        scene=lookup(within=STUDY_FILES, dpath="{study_scene}"),
        sources=sorted({*tracing_sources(), *module_sources("harness.measure.study")}),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/study/{{study_scene}}/{{study_model}}/studied.json",
    log:
        f"{RESULTS}/logs/study-{{study_scene}}-{{study_model}}.log",
    wildcard_constraints:
        study_scene="|".join(map(re.escape, STUDY_FILES)) or "none",
        study_model="whitted|haste|path",
    conda:
        "../envs/haste.yaml"
    # The machine is the job's alone, so that no time is taken while something else runs.
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.study_scene} in {wildcards.study_model}: launches of every size"
    shell:
        "{params.python:q} -m harness study --settings {input.settings:q} "
        "--scene {wildcards.study_scene:q} --model {wildcards.study_model:q} "
        "--threads {threads} 2>&1 | tee -i {log:q}"
