"""What the rules share: the checked settings, and the files that a result depends on."""

import json
import re
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError

# Snakemake has the folder of the Snakefile on its path only while it reads it from there.
sys.path.insert(0, workflow.basedir)

from harness.locks import join_runs
from harness.measure.config import ConfigError, check_config
from harness.measure.inputs import (
    mode_scene_files,
    module_sources,
    package_sources,
    price_files,
    ray_scene_files,
    scene_files,
    stability_scene_files,
    study_files,
    tracing_sources,
)
from harness.preflight import check_run
from harness.scene import SceneError

try:
    SETTINGS = check_config(config)
    check_run(SETTINGS)
except (ConfigError, SceneError) as error:
    raise WorkflowError(str(error)) from None

# Held until this process ends, before Snakemake takes its own.
RUNS = join_runs(Path(".snakemake"))
RESULTS = SETTINGS["results_dir"].rstrip("/")
SCENES = list(SETTINGS.scenes)
SCENE_FILES = scene_files(SETTINGS)
PRICE_FILES = price_files(SETTINGS)
STUDY_FILES = study_files(SETTINGS)
PYTHON = sys.executable


wildcard_constraints:
    scene="|".join(map(re.escape, SCENES)),


localrules:
    settings,


rule settings:
    output:
        f"{RESULTS}/settings.json",
    log:
        f"{RESULTS}/logs/settings.log",
    conda:
        "../envs/haste.yaml"
    params:
        run=SETTINGS["preset"],
        values=json.dumps(SETTINGS.values, sort_keys=True),
    message:
        "Settings of the run {params.run}"
    shell:
        "(printf '%s\\n' {params.values:q} > {output:q}.partial "
        "&& mv {output:q}.partial {output:q}) 2> {log:q}"
