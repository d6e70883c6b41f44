# Tables and figures in the paper's layout.


rule write_tables:
    input:
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        # they precede Table 3 by paired tests
        elasticities=(
            f"{RESULTS}/tables/elasticities.csv"
            if CONFIGURATION.study.draws == "common"
            else []
        ),
    output:
        rocks=f"{RESULTS}/tables/table_1_rocks.csv",
        cases=f"{RESULTS}/tables/table_2_cases.csv",
        latex=f"{RESULTS}/tables/table_3_indifference.tex",
        markdown=f"{RESULTS}/tables/table_3_indifference.md",
    priority: EARLY
    params:
        rocks=to_plain(ROCKS),
    script:
        "../scripts/write_tables.py"


rule draw_figures:
    input:
        study=f"{RESULTS}/study.nc",
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        surfaces=f"{RESULTS}/cases/{next(iter(CASES['cases']))}.0.surfaces.nc",
        curves=CURVE_FILES,
        fits=f"{RESULTS}/tables/measured_fit.csv" if CURVES else [],
        flow=f"{RESULTS}/tables/hydraulic_aperture.csv" if FLOW else [],
    output:
        figures=drawn(STUDY_FIGURES),
    priority: EARLY
    params:
        rocks=to_plain(ROCKS),
        curves=to_plain(CURVES),
        seating_stress=CONFIGURATION.seating_stress,
        wall_strength_ratio=CONFIGURATION.output.wall_strength_ratio,
        surfaces=surfaces_of("cases", next(iter(CASES["cases"])), "0"),
    script:
        "../scripts/draw_figures.py"


if POOL_FIGURES:

    rule draw_pool_figures:
        input:
            drawn=f"{RESULTS}/predictive.nc",
            paper=PAPER,
        output:
            figures=drawn(POOL_FIGURES),
        params:
            rocks=to_plain(ROCKS),
            realizations=CONFIGURATION.study.realizations,
        script:
            "../scripts/draw_pool_figures.py"
