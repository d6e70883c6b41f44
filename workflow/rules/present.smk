# Tables and figures in the paper's layout.


rule write_tables:
    input:
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        elasticities=f"{RESULTS}/tables/elasticities.csv",
        seals=seals_of("aggregate", "find_indifference_intervals", "fit_correlations"),
    output:
        rocks=f"{RESULTS}/tables/table_1_rocks.csv",
        cases=f"{RESULTS}/tables/table_2_cases.csv",
        latex=f"{RESULTS}/tables/table_3_indifference.tex",
        markdown=f"{RESULTS}/tables/table_3_indifference.md",
        seal=f"{RESULTS}/seals/write_tables.json",
    log:
        f"{RESULTS}/logs/write_tables.log",
    benchmark:
        f"{RESULTS}/benchmarks/write_tables.tsv"
    conda:
        ENVIRONMENT
    params:
        rocks=to_plain(ROCKS),
        made_with=STUDY_WITH,
        code=code_of("write_tables"),
    message:
        "Write Tables 1 to 3"
    script:
        "../scripts/write_tables.py"


rule draw_figures:
    input:
        study=f"{RESULTS}/study.nc",
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        drawn=f"{RESULTS}/predictive.nc",
        along=f"{RESULTS}/tables/along_curve.csv",
        paper=PAPER_TABLE_3,
        surfaces=f"{RESULTS}/cases/{next(iter(CASES['cases']))}.0.surfaces.nc",
        curves=CURVE_FILES,
        fits=f"{RESULTS}/tables/measured_fit.csv" if CURVES else [],
        flow=f"{RESULTS}/tables/hydraulic_aperture.csv" if FLOW else [],
        seals=seals_of(
            "aggregate",
            "find_indifference_intervals",
            "fit_correlations",
            "predict_table_3",
            "follow_stress",
            *(["fit_measured"] if CURVES else []),
            *(["tabulate_flow"] if FLOW else []),
        ),
    output:
        figures=[
            *[
                report(
                    f"{RESULTS}/figures/{figure}.png",
                    caption=CAPTIONS / f"{figure}.rst",
                    category="Figures",
                )
                for figure in FIGURES
            ],
            *expand(f"{RESULTS}/figures/{{figure}}.pdf", figure=FIGURES),
        ],
        seal=f"{RESULTS}/seals/draw_figures.json",
    log:
        f"{RESULTS}/logs/draw_figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_figures.tsv"
    conda:
        ENVIRONMENT
    params:
        rocks=to_plain(ROCKS),
        curves=to_plain(CURVES),
        seating_stress=CONFIGURATION.seating_stress,
        realizations=CONFIGURATION.study.realizations,
        wall_strength_ratio=CONFIGURATION.output.wall_strength_ratio,
        surfaces=surfaces_of("cases", next(iter(CASES["cases"])), "0"),
        made_with=STUDY_WITH,
        code=code_of("draw_figures"),
    message:
        "Draw the figures"
    script:
        "../scripts/draw_figures.py"
