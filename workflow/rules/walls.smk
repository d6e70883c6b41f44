# Cases whose walls were measured (`rocks.<rock>.walls`): scans are read, checked and cut into joints.
import re

SCANNED = {
    case.surface
    for ensemble in CASES.values()
    for case in ensemble.values()
    if ROCKS[case.rock].walls
}


rule prepare_walls:
    input:
        # contents count and not the time of a file: they are among the parameters
        lambda wildcards: [
            ancient(file) for file in wall_files(ROCKS[wildcards.rock].walls).values()
        ],
    output:
        f"{RESULTS}/walls/{{rock}}.nc",
        seal=f"{RESULTS}/seals/prepare_walls/{{rock}}.json",
    log:
        f"{RESULTS}/logs/prepare_walls/{{rock}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/prepare_walls/{{rock}}.tsv"
    priority: 1
    conda:
        ENVIRONMENT
    params:
        walls=lambda wildcards: preparing(wildcards.rock)["walls"],
        digests=lambda wildcards: preparing(wildcards.rock)["digests"],
        grid=to_plain(CONFIGURATION.grid),
        jrc_relation=CONFIGURATION.surface.jrc_relation,
        unusual_values=lambda wildcards: preparing(wildcards.rock)["unusual_values"],
        realizations=lambda wildcards: preparing(wildcards.rock)["realizations"],
        code=code_of("prepare_walls"),
    message:
        "Read and check the scanned walls of {wildcards.rock}"
    script:
        "../scripts/prepare_walls.py"


rule cut_surfaces:
    input:
        lambda wildcards: f"{RESULTS}/walls/{rock_of(wildcards)}.nc",
        seals=lambda wildcards: seals_of(f"prepare_walls/{rock_of(wildcards)}"),
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.surfaces.nc",
    log:
        f"{RESULTS}/logs/cut_surfaces/{{ensemble}}/{{case}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/cut_surfaces/{{ensemble}}/{{case}}.{{first}}.tsv"
    wildcard_constraints:
        case="|".join(map(re.escape, sorted(SCANNED))) or "(?!)",
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: surfaces_of(
            wildcards.ensemble, wildcards.case, wildcards.first
        ),
        made_with=WALLS_WITH,
    message:
        "Cut the surface pairs of {wildcards.case} from realisation {wildcards.first} on"
    script:
        "../scripts/cut_surfaces.py"


# the file of a case's surfaces is made by one or the other
ruleorder: cut_surfaces > make_surfaces
