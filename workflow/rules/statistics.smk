# Statistics of the study: covariates, correlations, indifference intervals, claims, checks.


if ADJUSTED:

    rule measure_covariates:
        input:
            study=f"{RESULTS}/study.nc",
        output:
            f"{RESULTS}/covariates.nc",
        log:
            f"{RESULTS}/logs/measure_covariates.log",
        priority: 2
        conda:
            ENVIRONMENT
        params:
            key=KEYS["study"],
            grid=joint_grid(STUDY),
            surface=synthesis(STUDY),
            surfaces=STUDY.statistics.control_variates,
            root_seed=STUDY.study.root_seed,
            code=code("measure_covariates.py"),
        message:
            "Measure the covariates of closed joints, and their means on further surfaces"
        script:
            "../scripts/measure_covariates.py"


if ADJUSTED and POOL == "pool":

    rule measure_pool_covariates:
        input:
            study=f"{RESULTS}/pool.nc",
            means=rules.measure_covariates.output[0],
        output:
            f"{RESULTS}/pool_covariates.nc",
        log:
            f"{RESULTS}/logs/measure_pool_covariates.log",
        conda:
            ENVIRONMENT
        params:
            key=KEYS["pool"],
            means_key=KEYS["study"],
            grid=joint_grid(STUDY),
            surface=synthesis(STUDY),
            code=code("measure_pool_covariates.py"),
        message:
            "Measure the covariates of the joints of the pool"
        script:
            "../scripts/measure_pool_covariates.py"


COVARIATES = rules.measure_covariates.output[0] if ADJUSTED else []
POOL_COVARIATES = (
    COVARIATES
    if POOL == "study" or not ADJUSTED
    else rules.measure_pool_covariates.output[0]
)


rule fit_correlations:
    input:
        study=f"{RESULTS}/study.nc",
        covariates=COVARIATES,
    output:
        correlations=f"{RESULTS}/tables/correlations.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
    log:
        f"{RESULTS}/logs/fit_correlations.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        code=code("fit_correlations.py"),
    message:
        "Fit quadratic correlations of mean and standard deviation, Eqs. (24) to (27)"
    script:
        "../scripts/fit_correlations.py"


rule find_indifference_intervals:
    input:
        study=f"{RESULTS}/study.nc",
        paper=PAPER_TABLE_3,
        covariates=COVARIATES,
    output:
        f"{RESULTS}/tables/table_3_indifference.csv",
    log:
        f"{RESULTS}/logs/find_indifference_intervals.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        # without the settings on which intervals do not depend
        statistics=[STUDY.statistics._replace(repetitions=0, control_variates=None)],
        root_seed=STUDY.study.root_seed,
        code=code("find_indifference_intervals.py"),
    message:
        "Find the indifference intervals, roots of quartics of a t test, Eqs. (28) and (29)"
    script:
        "../scripts/find_indifference_intervals.py"


rule fit_elasticities:
    input:
        pool=f"{RESULTS}/{POOL}.nc",
        covariates=POOL_COVARIATES,
    output:
        f"{RESULTS}/tables/elasticities.csv",
    log:
        f"{RESULTS}/logs/fit_elasticities.log",
    conda:
        ENVIRONMENT
    params:
        key=KEYS[POOL],
        code=code("fit_elasticities.py"),
    message:
        "Fit the elasticities of the closure"
    script:
        "../scripts/fit_elasticities.py"


rule predict_table_3:
    input:
        study=f"{RESULTS}/study.nc",
        pool=f"{RESULTS}/{POOL}.nc",
        paper=PAPER_TABLE_3,
    output:
        predictive=f"{RESULTS}/tables/table_3_predictive.csv",
        tests=f"{RESULTS}/tables/table_3_joint_tests.csv",
        lengths=f"{RESULTS}/predictive.nc",
    log:
        f"{RESULTS}/logs/predict_table_3.log",
    conda:
        ENVIRONMENT
    params:
        key_of={"study": KEYS["study"], "pool": KEYS[POOL]},
        significance=STUDY.statistics.significance,
        repetitions=STUDY.statistics.repetitions,
        root_seed=STUDY.study.root_seed,
        code=code("predict_table_3.py"),
    message:
        "Predict Table 3 in repetitions of the study, and test whether the paper's is one of them"
    script:
        "../scripts/predict_table_3.py"


rule judge_claims:
    input:
        study=f"{RESULTS}/study.nc",
        pool=f"{RESULTS}/{POOL}.nc",
        paper=PAPER_TABLE_3,
    output:
        claims=f"{RESULTS}/tables/claims.csv",
        margins=f"{RESULTS}/tables/claim_margins.csv",
    log:
        f"{RESULTS}/logs/judge_claims.log",
    conda:
        ENVIRONMENT
    params:
        key_of={"study": KEYS["study"], "pool": KEYS[POOL]},
        significance=STUDY.statistics.significance,
        repetitions=STUDY.statistics.repetitions,
        root_seed=STUDY.study.root_seed,
        code=code("judge_claims.py"),
    message:
        "Judge the paper's claims by the model and by the study"
    script:
        "../scripts/judge_claims.py"


rule check_results:
    input:
        datasets=collect(f"{RESULTS}/{{dataset}}.nc", dataset=CHECKED),
        plan=lambda w: reached_plan(),
    output:
        f"{RESULTS}/tables/checks.csv",
    log:
        f"{RESULTS}/logs/check_results.log",
    conda:
        ENVIRONMENT
    params:
        # key of the file, realisations of a case, and numerics, by ensemble
        ensembles={
            ensemble: (
                dataset_key(ensemble),
                ENSEMBLES[ensemble].study.realizations,
                ENSEMBLES[ensemble].numerics,
            )
            for ensemble in CHECKED.values()
        },
        code=code("check_results.py"),
    message:
        "Check what must hold for every joint"
    script:
        "../scripts/check_results.py"


# apart from the table, so that this remains when a check fails
rule require_checks:
    input:
        rules.check_results.output[0],
    output:
        f"{RESULTS}/logs/checks_passed.txt",
    log:
        f"{RESULTS}/logs/require_checks.log",
    conda:
        ENVIRONMENT
    message:
        "Fail if a check of the results has failed"
    script:
        "../scripts/require_checks.py"
