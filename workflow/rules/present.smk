# Tables and figures in the paper's layout.


rule write_tables:
    input:
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        elasticities=f"{RESULTS}/tables/elasticities.csv",
    output:
        rocks=f"{RESULTS}/tables/table_1_rocks.csv",
        cases=f"{RESULTS}/tables/table_2_cases.csv",
        latex=f"{RESULTS}/tables/table_3_indifference.tex",
        markdown=f"{RESULTS}/tables/table_3_indifference.md",
    params:
        rocks=to_plain(ROCKS),
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
    params:
        rocks=to_plain(ROCKS),
        curves=to_plain(CURVES),
        seating_stress=CONFIGURATION.seating_stress,
        realizations=CONFIGURATION.study.realizations,
        wall_strength_ratio=CONFIGURATION.output.wall_strength_ratio,
        surfaces=surfaces_of("cases", next(iter(CASES["cases"])), "0"),
    script:
        "../scripts/draw_figures.py"
