# A JRC that is known to a range only, from the joints of a finished study: `snakemake jrc_range`.


rule jrc_range:
    input:
        f"{RESULTS}/tables/jrc_range.csv",
        f"{RESULTS}/tables/jrc_range_claims.csv",
        seals_of("draw_jrc_range"),
    message:
        "What a JRC that is known to a range does is in {input[0]}"


rule draw_jrc_range:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        paper=PAPER_TABLE_3,
        seals=BOTH_SEALS,
    output:
        entries=f"{RESULTS}/tables/jrc_range.csv",
        found=f"{RESULTS}/tables/jrc_range_claims.csv",
        seal=f"{RESULTS}/seals/draw_jrc_range.json",
    log:
        f"{RESULTS}/logs/draw_jrc_range.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_jrc_range.tsv"
    conda:
        ENVIRONMENT
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
        made_with=STUDY_WITH,
        code=code_of("draw_jrc_range"),
    message:
        "Draw joints whose JRC is known to a range"
    script:
        "../scripts/draw_jrc_range.py"
