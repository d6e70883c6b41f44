# What each of the paper's conclusions rests on, of all studies that were run: `snakemake conclusions`.


rule conclusions:
    input:
        f"{RESULTS}/tables/conclusions.csv",
        seals_of("conclude"),
    message:
        "What is left of the paper's conclusions is in {input[0]}"


rule conclude:
    input:
        claims=f"{RESULTS}/tables/claims.csv",
        jrc_range=f"{RESULTS}/tables/jrc_range_claims.csv",
        readings=ancient(beside("readings")[0]),
        choices=ancient(beside("choices")[0]),
        margins=ancient(beside("margins")[0]),
        seals=seals_of("judge_claims", "draw_jrc_range")
        + beside("readings")[1]
        + beside("choices")[1],
    output:
        table=f"{RESULTS}/tables/conclusions.csv",
        seal=f"{RESULTS}/seals/conclude.json",
    log:
        f"{RESULTS}/logs/conclude.log",
    benchmark:
        f"{RESULTS}/benchmarks/conclude.tsv"
    conda:
        ENVIRONMENT
    params:
        made_with=STUDY_WITH,
        code=code_of("conclude"),
    message:
        "Put together what each conclusion rests on"
    script:
        "../scripts/conclude.py"
