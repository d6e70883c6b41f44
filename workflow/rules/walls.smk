# Scans of the rocks whose walls were measured (`rocks.<rock>.walls`): read, checked, brought to the grid.


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
        walls=lambda wildcards: ROCKS[wildcards.rock].walls,
        digests=lambda wildcards: wall_digests(ROCKS[wildcards.rock].walls),
        grid=CONFIGURATION.grid,
        jrc_relation=CONFIGURATION.surface.jrc_relation,
        unusual_values=CONFIGURATION.study.unusual_values == "allow",
        realizations=max(
            ensemble.configuration.study.realizations
            for ensemble in ENSEMBLES.values()
        ),
    script:
        "../scripts/prepare_walls.py"
