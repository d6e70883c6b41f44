# Cases whose walls were measured (`rocks.<rock>.walls`): scans are read, checked and cut into joints.
import re

from jointclosure.scans import file_digest

MEASURED = [case for case in SURFACES if ROCKS[CASES[case].rock].get("walls")]
WALL_CODE = source_digest(
    "scans",
    "surface",
    "randomness",
    "study/measured_walls",
    "study/wall_settings",
    "dataset",
)


def wall_files(wildcards):
    """The scans of a rock."""
    return wall_settings.wall_files(ROCKS[wildcards.rock]["walls"])


rule prepare_walls:
    input:
        # contents count and not the time of a file: they are among the parameters
        lambda wildcards: [ancient(file) for file in wall_files(wildcards).values()],
    output:
        f"{RESULTS}/walls/{{rock}}.nc",
    log:
        f"{RESULTS}/logs/prepare_walls/{{rock}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/prepare_walls/{{rock}}.tsv"
    priority: 1
    conda:
        ENVIRONMENT
    params:
        walls=lambda wildcards: ROCKS[wildcards.rock]["walls"],
        digests=lambda wildcards: {
            side: file_digest(file) for side, file in wall_files(wildcards).items()
        },
        grid=config["grid"],
        jrc_relation=config["surface"]["jrc_relation"],
        realizations=config["study"]["realizations"],
        code=WALL_CODE,
    message:
        "Read and check the measured walls of {wildcards.rock}"
    script:
        "../scripts/prepare_walls.py"


rule cut_surfaces:
    input:
        lambda wildcards: f"{RESULTS}/walls/{CASES[wildcards.case].rock}.nc",
    output:
        f"{RESULTS}/cases/{{case}}.surfaces.nc",
    log:
        f"{RESULTS}/logs/cut_surfaces/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/cut_surfaces/{{case}}.tsv"
    wildcard_constraints:
        case="|".join(map(re.escape, MEASURED)) or "(?!)",
    conda:
        ENVIRONMENT
    params:
        seeds=lambda wildcards: [
            cases.wall_seed(config, CASES[wildcards.case], realization)
            for realization in range(config["study"]["realizations"])
        ],
        order_seed=lambda wildcards: cases.window_seed(config, CASES[wildcards.case]),
        grid=config["grid"],
        normalise=config["surface"]["normalise"],
        code=WALL_CODE,
    message:
        "Cut the surface pairs of {wildcards.case} out of the measured walls"
    script:
        "../scripts/cut_surfaces.py"


# the file of a case's surfaces is made by one or the other
ruleorder: cut_surfaces > make_surfaces
