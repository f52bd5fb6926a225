"""What the scenes require, the first step, so that a bad scene ends a run before it has begun; and
what it costs to have more, one job a scene."""


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


rule prices:
    input:
        settings=f"{RESULTS}/settings.json",
        scene=lookup(within=PRICE_FILES, dpath="{price_scene}"),
        sources=sorted({*tracing_sources(), *module_sources("harness.measure.prices")}),
        headers=package_sources("haste_cuda/core", "haste_cuda/cuda/kernels"),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/features/{{price_scene}}/priced.json",
    log:
        f"{RESULTS}/logs/features-{{price_scene}}.log",
    wildcard_constraints:
        price_scene="|".join(map(re.escape, PRICE_FILES)) or "none",
    conda:
        "../envs/haste.yaml"
    # The machine is the job's alone, so that no time is taken while something else runs.
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.price_scene}: the price of every feature"
    shell:
        "{params.python:q} -m harness prices --settings {input.settings:q} "
        "--scene {wildcards.price_scene:q} --threads {threads} 2>&1 | tee -i {log:q}"
