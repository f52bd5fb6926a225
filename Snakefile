"""From scene files to a report: `snakemake all`. The settings are explained in config/README.md."""

from snakemake.utils import min_version

min_version("9.0")


configfile: "config/quick.yaml"


include: "harness/rules/common.smk"
include: "harness/rules/scenes.smk"
include: "harness/rules/features.smk"
include: "harness/rules/truth.smk"
include: "harness/rules/measure.smk"
include: "harness/rules/rays.smk"
include: "harness/rules/stability.smk"
include: "harness/rules/study.smk"
include: "harness/rules/tables.smk"
include: "harness/rules/report.smk"


localrules:
    all,


rule all:
    input:
        f"{RESULTS}/report.html",
        f"{RESULTS}/samples.parquet",
        f"{RESULTS}/measurements.csv",
    message:
        "Everything is there: {input}"
