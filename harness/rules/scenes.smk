"""What belongs to the scenes and is made here: generated meshes, and the thumbnails."""

import re

from harness.measure.config import find_scene, standard_scenes
from harness.measure.inputs import files_of_scene
from harness.scene.generated import generated_scenes
from harness.thumbnails import SHEET_SCENES

GENERATED = {
    name: [f"scenes/{name}/{file}" for file in scene.files]
    for name, scene in generated_scenes().items()
}


localrules:
    generate,
    thumbnails,


rule generate:
    input:
        list(GENERATED.values()),
    message:
        "Every generated file is there"


# One rule a scene: each writes other files.
for scene, scene_outputs in GENERATED.items():

    rule:
        name:
            re.sub(r"\W", "_", f"generate_{scene}")
        input:
            package_sources("scenes/generators"),
        output:
            scene_outputs,
        log:
            f"{RESULTS}/logs/generate/{scene}.log",
        conda:
            "../envs/haste.yaml"
        params:
            python=PYTHON,
            scene=scene,
        message:
            "{params.scene}: {output}"
        shell:
            "{params.python:q} -m harness generate --scene {params.scene:q} > {log:q} 2>&1"


rule thumbnails:
    input:
        expand("scenes/{folder}/thumbnail.png", folder=standard_scenes()),
        "docs/images/scenes.jpg",
    message:
        "Every thumbnail is there"


rule thumbnail:
    input:
        scene=lambda wildcards: files_of_scene(find_scene(wildcards.folder)),
        sources=package_sources("harness/scene"),
    output:
        "scenes/{folder}/thumbnail.png",
    log:
        f"{RESULTS}/logs/thumbnails/{{folder}}.log",
    wildcard_constraints:
        folder="|".join(standard_scenes()),
    conda:
        "../envs/haste.yaml"
    threads: workflow.cores
    params:
        python=PYTHON,
    message:
        "{wildcards.folder}: thumbnail"
    shell:
        "{params.python:q} -m harness thumbnails --scene {wildcards.folder:q} "
        "--threads {threads} > {log:q} 2>&1"


rule sheet:
    input:
        thumbnails=expand("scenes/{folder}/thumbnail.png", folder=SHEET_SCENES),
        sources=["harness/thumbnails.py"],
    output:
        "docs/images/scenes.jpg",
    log:
        f"{RESULTS}/logs/sheet.log",
    conda:
        "../envs/haste.yaml"
    params:
        python=PYTHON,
    message:
        "The picture of the README"
    shell:
        "{params.python:q} -m harness sheet > {log:q} 2>&1"
