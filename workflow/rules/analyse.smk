# Statistics of a study: correlations, indifference intervals, claims, checks.


rule fit_correlations:
    message:
        "Fit the correlations of mean and standard deviation"
    input:
        f"{RESULTS}/study.nc",
    output:
        correlations=f"{RESULTS}/tables/correlations.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
    params:
        code=ANALYSIS_CODE,
    log:
        f"{RESULTS}/logs/fit_correlations.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_correlations.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/fit_correlations.py"


rule find_indifference_intervals:
    message:
        "Find the indifference intervals and their confidence intervals"
    input:
        study=f"{RESULTS}/study.nc",
        paper=PAPER_TABLE_3,
    output:
        f"{RESULTS}/tables/table_3_indifference.csv",
    params:
        statistics=config["statistics"],
        root_seed=config["study"]["root_seed"],
        draws=config["study"]["draws"],
        code=ANALYSIS_CODE,
    log:
        f"{RESULTS}/logs/find_indifference_intervals.log",
    benchmark:
        f"{RESULTS}/benchmarks/find_indifference_intervals.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/find_indifference_intervals.py"


rule judge_claims:
    message:
        "Hold the paper's claims against this study"
    input:
        study=f"{RESULTS}/study.nc",
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
    output:
        f"{RESULTS}/tables/claims.csv",
    params:
        code=ANALYSIS_CODE,
    log:
        f"{RESULTS}/logs/judge_claims.log",
    benchmark:
        f"{RESULTS}/benchmarks/judge_claims.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/judge_claims.py"


rule check_results:
    message:
        "Check the results"
    input:
        f"{RESULTS}/study.nc",
    output:
        f"{RESULTS}/tables/checks.csv",
    params:
        effects=config["effects"],
        numerics=config["numerics"],
        realizations=config["study"]["realizations"],
        code=ANALYSIS_CODE,
    log:
        f"{RESULTS}/logs/check_results.log",
    benchmark:
        f"{RESULTS}/benchmarks/check_results.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/check_results.py"
