# Statistics of a study: correlations, indifference intervals, claims, checks.


rule measure_covariates:
    input:
        ensembles=list(dict.fromkeys([f"{RESULTS}/study.nc", POOL])),
        seals=BOTH_SEALS,
    output:
        covariates=(
            list(dict.fromkeys([COVARIATES, POOL_COVARIATES]))
            if VARIATES
            else f"{RESULTS}/covariates.nc"
        ),
        seal=f"{RESULTS}/seals/measure_covariates.json",
    log:
        f"{RESULTS}/logs/measure_covariates.log",
    benchmark:
        f"{RESULTS}/benchmarks/measure_covariates.tsv"
    conda:
        ENVIRONMENT
    params:
        grid=to_plain(CONFIGURATION.grid),
        surface=to_plain(CONFIGURATION.surface),
        surfaces=CONFIGURATION.statistics.control_variates,
        root_seed=CONFIGURATION.study.root_seed,
        made_with=STUDY_WITH,
        code=code_of("measure_covariates"),
    message:
        "Measure covariates, and make the surfaces that tell their means"
    script:
        "../scripts/measure_covariates.py"


rule reduce_variance:
    input:
        ensemble=POOL,
        covariates=POOL_COVARIATES,
        seals=POOL_SEALS + VARIATES_SEALS,
    output:
        f"{RESULTS}/tables/variance_reduction.csv",
        seal=f"{RESULTS}/seals/reduce_variance.json",
    log:
        f"{RESULTS}/logs/reduce_variance.log",
    benchmark:
        f"{RESULTS}/benchmarks/reduce_variance.tsv"
    conda:
        ENVIRONMENT
    params:
        realizations=CONFIGURATION.study.realizations,
        significance=CONFIGURATION.statistics.significance,
        root_seed=CONFIGURATION.study.root_seed,
        made_with=STUDY_WITH,
        code=code_of("reduce_variance"),
    message:
        "Measure what control variates are worth"
    script:
        "../scripts/reduce_variance.py"


rule fit_correlations:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        covariates=COVARIATES,
        pool_covariates=POOL_COVARIATES,
        seals=BOTH_SEALS + VARIATES_SEALS,
    output:
        correlations=f"{RESULTS}/tables/correlations.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        elasticities=f"{RESULTS}/tables/elasticities.csv",
        seal=f"{RESULTS}/seals/fit_correlations.json",
    log:
        f"{RESULTS}/logs/fit_correlations.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_correlations.tsv"
    conda:
        ENVIRONMENT
    params:
        made_with=STUDY_WITH,
        code=code_of("fit_correlations"),
    message:
        "Fit correlations and elasticities, with their standard errors"
    script:
        "../scripts/fit_correlations.py"


rule find_indifference_intervals:
    input:
        study=f"{RESULTS}/study.nc",
        paper=PAPER_TABLE_3,
        covariates=COVARIATES,
        seals=seals_of("aggregate") + VARIATES_SEALS,
    output:
        f"{RESULTS}/tables/table_3_indifference.csv",
        seal=f"{RESULTS}/seals/find_indifference_intervals.json",
    log:
        f"{RESULTS}/logs/find_indifference_intervals.log",
    benchmark:
        f"{RESULTS}/benchmarks/find_indifference_intervals.tsv"
    conda:
        ENVIRONMENT
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        made_with=STUDY_WITH,
        code=code_of("find_indifference_intervals"),
    message:
        "Find the indifference intervals and their confidence intervals"
    script:
        "../scripts/find_indifference_intervals.py"


rule fit_measured:
    input:
        study=f"{RESULTS}/study.nc",
        curves=CURVE_FILES,
        seals=seals_of("aggregate"),
    output:
        f"{RESULTS}/tables/measured_fit.csv",
        seal=f"{RESULTS}/seals/fit_measured.json",
    log:
        f"{RESULTS}/logs/fit_measured.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit_measured.tsv"
    conda:
        ENVIRONMENT
    params:
        curves=to_plain(CURVES),
        seating_stress=CONFIGURATION.seating_stress,
        made_with=STUDY_WITH,
        code=code_of("fit_measured"),
    message:
        "Find the realisations that fit the measured curves best"
    script:
        "../scripts/fit_measured.py"


rule tabulate_flow:
    input:
        study=f"{RESULTS}/study.nc",
        seals=seals_of("aggregate"),
    output:
        f"{RESULTS}/tables/hydraulic_aperture.csv",
        seal=f"{RESULTS}/seals/tabulate_flow.json",
    log:
        f"{RESULTS}/logs/tabulate_flow.log",
    benchmark:
        f"{RESULTS}/benchmarks/tabulate_flow.tsv"
    conda:
        ENVIRONMENT
    params:
        made_with=STUDY_WITH,
        code=code_of("tabulate_flow"),
    message:
        "Sum up the hydraulic apertures"
    script:
        "../scripts/tabulate_flow.py"


rule reach_accuracy:
    input:
        study=f"{RESULTS}/study.nc",
        covariates=COVARIATES,
        seals=seals_of("aggregate") + VARIATES_SEALS,
    output:
        f"{RESULTS}/tables/accuracy_reached.csv",
        seal=f"{RESULTS}/seals/reach_accuracy.json",
    log:
        f"{RESULTS}/logs/reach_accuracy.log",
    benchmark:
        f"{RESULTS}/benchmarks/reach_accuracy.tsv"
    conda:
        ENVIRONMENT
    params:
        wanted=to_plain(WANTED),
        preset=CONFIGURED.granted,
        significance=CONFIGURATION.statistics.significance,
        made_with=STUDY_WITH,
        code=code_of("reach_accuracy"),
    message:
        "Say what is reached of the accuracy that was wanted"
    script:
        "../scripts/reach_accuracy.py"


rule predict_table_3:
    input:
        pool=POOL,
        paper=PAPER_TABLE_3,
        seals=POOL_SEALS,
    output:
        entries=f"{RESULTS}/tables/table_3_predictive.csv",
        joint=f"{RESULTS}/tables/table_3_joint_tests.csv",
        lengths=f"{RESULTS}/predictive.nc",
        seal=f"{RESULTS}/seals/predict_table_3.json",
    log:
        f"{RESULTS}/logs/predict_table_3.log",
    benchmark:
        f"{RESULTS}/benchmarks/predict_table_3.tsv"
    conda:
        ENVIRONMENT
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
        made_with=STUDY_WITH,
        code=code_of("predict_table_3"),
    message:
        "Draw what repetitions of the study would publish in Table 3"
    script:
        "../scripts/predict_table_3.py"


rule judge_claims:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        paper=PAPER_TABLE_3,
        seals=BOTH_SEALS,
    output:
        claims=f"{RESULTS}/tables/claims.csv",
        margins=f"{RESULTS}/tables/claim_margins.csv",
        seal=f"{RESULTS}/seals/judge_claims.json",
    log:
        f"{RESULTS}/logs/judge_claims.log",
    benchmark:
        f"{RESULTS}/benchmarks/judge_claims.tsv"
    conda:
        ENVIRONMENT
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
        made_with=STUDY_WITH,
        code=code_of("judge_claims"),
    message:
        "Hold the paper's claims against the model and the study"
    script:
        "../scripts/judge_claims.py"


rule follow_stress:
    input:
        pool=POOL,
        seals=POOL_SEALS,
    output:
        f"{RESULTS}/tables/along_curve.csv",
        seal=f"{RESULTS}/seals/follow_stress.json",
    log:
        f"{RESULTS}/logs/follow_stress.log",
    benchmark:
        f"{RESULTS}/benchmarks/follow_stress.tsv"
    conda:
        ENVIRONMENT
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
        seating_stress=CONFIGURATION.seating_stress,
        made_with=STUDY_WITH,
        code=code_of("follow_stress"),
    message:
        "Follow elasticities and intervals along the closure curve"
    script:
        "../scripts/follow_stress.py"


rule check_results:
    input:
        ensembles=list(dict.fromkeys([f"{RESULTS}/study.nc", POOL])),
        seals=BOTH_SEALS,
    output:
        f"{RESULTS}/tables/checks.csv",
        seal=f"{RESULTS}/seals/check_results.json",
    log:
        f"{RESULTS}/logs/check_results.log",
    benchmark:
        f"{RESULTS}/benchmarks/check_results.tsv"
    conda:
        ENVIRONMENT
    params:
        numerics=to_plain(CONFIGURATION.numerics),
        realizations={
            name: settled.study.realizations for name, settled in ENSEMBLES.items()
        },
        made_with=STUDY_WITH,
        code=code_of("check_results"),
    message:
        "Check the results"
    script:
        "../scripts/check_results.py"


# after the table is there to be read, also where a check fails
rule require_checks:
    input:
        f"{RESULTS}/tables/checks.csv",
        seals=seals_of("aggregate", "check_results"),
    output:
        f"{RESULTS}/logs/checks_passed.txt",
    log:
        f"{RESULTS}/logs/require_checks.log",
    benchmark:
        f"{RESULTS}/benchmarks/require_checks.tsv"
    conda:
        ENVIRONMENT
    params:
        code=code_of("require_checks"),
    message:
        "See whether all checks passed"
    script:
        "../scripts/require_checks.py"
