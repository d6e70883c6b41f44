# Effect of a JRC that is only known within a range, from the joints of a finished study: `snakemake jrc_range`.


rule jrc_range:
    input:
        f"{RESULTS}/tables/jrc_range.csv",
        f"{RESULTS}/tables/jrc_range_claims.csv",
    message:
        "The effect of an uncertain JRC is in {input[0]}"


rule draw_jrc_range:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        paper=PAPER,
    output:
        entries=f"{RESULTS}/tables/jrc_range.csv",
        claims=f"{RESULTS}/tables/jrc_range_claims.csv",
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
    script:
        "../scripts/draw_jrc_range.py"
