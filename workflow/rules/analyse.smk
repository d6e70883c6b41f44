# Statistics of a study: correlations, indifference intervals, claims, checks.


rule measure_covariates:
    input:
        ensemble=f"{RESULTS}/study.nc",
    output:
        f"{RESULTS}/covariates.nc",
    priority: EARLY
    params:
        grid=to_plain(CONFIGURATION.grid),
        surface=to_plain(CONFIGURATION.surface),
        surfaces=CONFIGURATION.statistics.control_variates,
        root_seed=CONFIGURATION.study.root_seed,
    script:
        "../scripts/measure_covariates.py"


if "pool" in ENSEMBLES:

    use rule measure_covariates as measure_pool_covariates with:
        input:
            ensemble=POOL,
            known=f"{RESULTS}/covariates.nc",
        output:
            f"{RESULTS}/pool_covariates.nc",
        priority: 0


rule fit_correlations:
    input:
        study=f"{RESULTS}/study.nc",
        covariates=COVARIATES,
    output:
        correlations=f"{RESULTS}/tables/correlations.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
    priority: EARLY
    script:
        "../scripts/fit_correlations.py"


rule fit_elasticities:
    input:
        ensemble=POOL,
        covariates=POOL_COVARIATES,
    output:
        f"{RESULTS}/tables/elasticities.csv",
    script:
        "../scripts/fit_elasticities.py"


rule find_indifference_intervals:
    input:
        study=f"{RESULTS}/study.nc",
        paper=PAPER,
        covariates=COVARIATES,
    output:
        f"{RESULTS}/tables/table_3_indifference.csv",
    priority: EARLY
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
    script:
        "../scripts/find_indifference_intervals.py"


rule fit_measured:
    input:
        study=f"{RESULTS}/study.nc",
        curves=CURVE_FILES,
    output:
        f"{RESULTS}/tables/measured_fit.csv",
    priority: EARLY
    params:
        curves=to_plain(CURVES),
        seating_stress=CONFIGURATION.seating_stress,
    script:
        "../scripts/fit_measured.py"


rule tabulate_flow:
    input:
        study=f"{RESULTS}/study.nc",
    output:
        f"{RESULTS}/tables/hydraulic_aperture.csv",
    priority: EARLY
    script:
        "../scripts/tabulate_flow.py"


rule reach_accuracy:
    input:
        study=f"{RESULTS}/study.nc",
        covariates=COVARIATES,
    output:
        f"{RESULTS}/tables/accuracy_reached.csv",
    params:
        wanted=to_plain(WANTED),
        preset=CONFIGURED.granted,
        rocks=measured_rocks(CONFIGURED.keys, read_plain(DEFAULT)),
        significance=CONFIGURATION.statistics.significance,
    script:
        "../scripts/reach_accuracy.py"


rule predict_table_3:
    input:
        pool=POOL,
        paper=PAPER,
    output:
        entries=f"{RESULTS}/tables/table_3_predictive.csv",
        joint=f"{RESULTS}/tables/table_3_joint_tests.csv",
        lengths=f"{RESULTS}/predictive.nc",
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
    script:
        "../scripts/predict_table_3.py"


rule judge_claims:
    input:
        study=f"{RESULTS}/study.nc",
        pool=POOL,
        paper=PAPER,
    output:
        claims=f"{RESULTS}/tables/claims.csv",
        margins=f"{RESULTS}/tables/claim_margins.csv",
    params:
        statistics=to_plain(CONFIGURATION.statistics),
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
    script:
        "../scripts/judge_claims.py"


rule check_results:
    input:
        ensembles=list(dict.fromkeys([f"{RESULTS}/study.nc", POOL])),
    output:
        f"{RESULTS}/tables/checks.csv",
    params:
        numerics=to_plain(CONFIGURATION.numerics),
        realizations={
            name: settled.study.realizations for name, settled in ENSEMBLES.items()
        },
    script:
        "../scripts/check_results.py"


# after the table is there to be read, also where a check fails
rule require_checks:
    input:
        f"{RESULTS}/tables/checks.csv",
    output:
        f"{RESULTS}/logs/checks_passed.txt",
    script:
        "../scripts/require_checks.py"
