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
            ancient(str(file))
            for scan in wall_files(ROCKS[wildcards.rock].walls).values()
            for file in files_of(scan)
        ],
    output:
        f"{RESULTS}/walls/{{rock}}.nc",
    priority: EARLY
    params:
        walls=lambda wildcards: to_plain(ROCKS[wildcards.rock].walls),
        digests=lambda wildcards: slices.wall_digests(ROCKS[wildcards.rock].walls),
        grid=to_plain(CONFIGURATION.grid),
        jrc_relation=CONFIGURATION.surface.jrc_relation,
        unusual_values=CONFIGURATION.study.unusual_values == "allow",
        realizations=max(part.study.realizations for part in ENSEMBLES.values()),
    script:
        "../scripts/prepare_walls.py"


rule cut_surfaces:
    input:
        lambda wildcards: f"{RESULTS}/walls/{rock_of(wildcards)}.nc",
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.surfaces.nc",
    wildcard_constraints:
        case="|".join(map(re.escape, sorted(SCANNED))) or "(?!)",
    priority: lambda wildcards: EARLY if wildcards.ensemble == "cases" else 0
    params:
        settings=lambda wildcards: surfaces_of(
            wildcards.ensemble, wildcards.case, wildcards.first
        ),
    script:
        "../scripts/cut_surfaces.py"


# the file of a case's surfaces is made by one or the other
ruleorder: cut_surfaces > make_surfaces
