"""The benchmark of rays: one job a scene, every tracer on the same rays, in turn."""

RAY_FILES = ray_scene_files(SETTINGS)


rule rays:
    input:
        settings=f"{RESULTS}/settings.json",
        scene=lookup(within=RAY_FILES, dpath="{ray_scene}"),
        sources=sorted({*tracing_sources(), *module_sources("harness.measure.rays")}),
        schema="harness/schemas/settings.schema.yaml",
    output:
        f"{RESULTS}/rays/{{ray_scene}}/replayed.json",
    log:
        f"{RESULTS}/logs/rays-{{ray_scene}}.log",
    wildcard_constraints:
        ray_scene="|".join(map(re.escape, RAY_FILES)) or "none",
    conda:
        "../envs/haste.yaml"
    # The machine is the job's alone, so that no time is taken while something else runs.
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.ray_scene}: the same rays through every tracer"
    shell:
        "{params.python:q} -m harness rays --settings {input.settings:q} "
        "--scene {wildcards.ray_scene:q} --threads {threads} 2>&1 | tee -i {log:q}"
