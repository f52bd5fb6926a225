"""What the scenes require: the first step, so that a bad scene ends a run before it has begun."""


# Nobody waits in a queue to hear that a scene cannot be rendered.
localrules:
    features,


rule features:
    input:
        settings=f"{RESULTS}/settings.json",
        scenes=list(SCENE_FILES.values()),
        sources=module_sources("harness.describe"),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/features.txt",
    log:
        f"{RESULTS}/logs/features.log",
    conda:
        "../envs/haste.yaml"
    params:
        python=PYTHON,
    message:
        "What the scenes require"
    # The list goes to the file; what is wrong goes to the terminal and to the log.
    shell:
        "{params.python:q} -m harness features --settings {input.settings:q} "
        "2>&1 > {output:q}.partial | tee -i {log:q} && mv {output:q}.partial {output:q}"
