# A JRC that is known to a range only, from the joints of a finished study: `snakemake jrc_range`.


rule jrc_range:
    input:
        f"{RESULTS}/tables/jrc_range.csv",
        f"{RESULTS}/tables/jrc_range_claims.csv",
    message:
        "What a JRC that is known to a range does is in {input[0]}"


rule draw_jrc_range:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        paper=PAPER_TABLE_3,
    output:
        entries=f"{RESULTS}/tables/jrc_range.csv",
        found=f"{RESULTS}/tables/jrc_range_claims.csv",
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
    script:
        "../scripts/draw_jrc_range.py"
