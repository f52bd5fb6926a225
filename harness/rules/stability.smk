"""Numerical stability: rays at the edges and vertices of a mesh, through every tracer."""

STABILITY_FILES = stability_scene_files(SETTINGS)
MODE_FILES = mode_scene_files(SETTINGS)


localrules:
    stability,


rule stability:
    input:
        expand(f"{RESULTS}/stability/{{scene}}/stability.json", scene=STABILITY_FILES),
        expand(f"{RESULTS}/stability/modes/{{scene}}.json", scene=MODE_FILES),
        [f"{RESULTS}/stability/{job}.json" for job in SETTINGS["stability"]["suites"]],
    message:
        "Stability: {input}"


rule cracks:
    input:
        settings=f"{RESULTS}/settings.json",
        scene=lookup(within=STABILITY_FILES, dpath="{stability_scene}"),
        sources=sorted({*tracing_sources(), *module_sources("harness.stability.job")}),
    output:
        f"{RESULTS}/stability/{{stability_scene}}/stability.json",
    log:
        f"{RESULTS}/logs/stability-{{stability_scene}}.log",
    wildcard_constraints:
        stability_scene="|".join(map(re.escape, STABILITY_FILES)) or "none",
    conda:
        "../envs/haste.yaml"
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.stability_scene}: rays at its edges and vertices through every tracer"
    shell:
        "{params.python:q} -m harness stability --settings {input.settings:q} "
        "--scene {wildcards.stability_scene:q} --threads {threads} 2>&1 | tee -i {log:q}"


rule modes:
    input:
        settings=f"{RESULTS}/settings.json",
        scene=lookup(within=MODE_FILES, dpath="{mode_scene}"),
        sources=sorted({*tracing_sources(), *module_sources("harness.stability.modes")}),
    output:
        f"{RESULTS}/stability/modes/{{mode_scene}}.json",
    log:
        f"{RESULTS}/logs/modes-{{mode_scene}}.log",
    wildcard_constraints:
        mode_scene="|".join(map(re.escape, MODE_FILES)) or "none",
    conda:
        "../envs/haste.yaml"
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.mode_scene}: the same samples in every precision"
    shell:
        "{params.python:q} -m harness modes --settings {input.settings:q} "
        "--scene {wildcards.mode_scene:q} --threads {threads} 2>&1 | tee -i {log:q}"


rule surfaces:
    input:
        settings=f"{RESULTS}/settings.json",
        sources=sorted(
            {*tracing_sources(), *module_sources("harness.stability.surfaces")}
        ),
    output:
        f"{RESULTS}/stability/surfaces.json",
    log:
        f"{RESULTS}/logs/surfaces.log",
    conda:
        "../envs/haste.yaml"
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "Rays that leave surfaces, of every tracer"
    shell:
        "{params.python:q} -m harness surfaces --settings {input.settings:q} "
        "--threads {threads} 2>&1 | tee -i {log:q}"


rule sweeps:
    input:
        settings=f"{RESULTS}/settings.json",
        sources=sorted(
            {*tracing_sources(), *module_sources("harness.stability.sweeps")}
        ),
    output:
        f"{RESULTS}/stability/sweeps.json",
    log:
        f"{RESULTS}/logs/sweeps.log",
    conda:
        "../envs/haste.yaml"
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "Scenes with a known answer at their extremes, by every tracer"
    shell:
        "{params.python:q} -m harness sweeps --settings {input.settings:q} "
        "--threads {threads} 2>&1 | tee -i {log:q}"
