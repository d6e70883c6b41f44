# Surfaces of the joints of every case: made from a JRC, or cut out of scanned walls.


rule make_surfaces:
    output:
        f"{RESULTS}/surfaces/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.nc",
    log:
        f"{RESULTS}/logs/make_surfaces/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.log",
    wildcard_constraints:
        rock="|".join(SYNTHETIC) or "none",
    priority: lambda w: priority_of(w.ensemble)
    group:
        "closures"
    conda:
        ENVIRONMENT
    params:
        surfaces=lambda w: surface_settings(point_of(w).settings),
        code=code("make_surfaces.py", titles=False),
    message:
        "Make the surfaces of {wildcards.rock}, {wildcards.change} ({wildcards.ensemble})"
    script:
        "../scripts/make_surfaces.py"


rule prepare_walls:
    input:
        # a new time of a file does not matter; its digest is among the settings
        scans=lambda w: ancient(scan_files(w.rock)),
    output:
        f"{RESULTS}/walls/{{rock}}.nc",
    log:
        f"{RESULTS}/logs/prepare_walls/{{rock}}.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        settings=lambda w: scan_settings(w.rock),
        key=lambda w: walls_key(w.rock),
        code=code("prepare_walls.py", titles=False),
    message:
        "Read the scanned walls of {wildcards.rock}, register them, put them on the grid"
    script:
        "../scripts/prepare_walls.py"


rule cut_windows:
    input:
        walls=f"{RESULTS}/walls/{{rock}}.nc",
    output:
        f"{RESULTS}/surfaces/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.nc",
    log:
        f"{RESULTS}/logs/cut_windows/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.log",
    wildcard_constraints:
        rock="|".join(SCANNED) or "none",
    priority: lambda w: priority_of(w.ensemble)
    group:
        "closures"
    conda:
        ENVIRONMENT
    params:
        windows=lambda w: surface_settings(point_of(w).settings),
        walls_key=lambda w: walls_key(w.rock),
        code=code("cut_windows.py", titles=False),
    message:
        "Cut joints out of the scanned walls of {wildcards.rock} ({wildcards.ensemble})"
    script:
        "../scripts/cut_windows.py"
