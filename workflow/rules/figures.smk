# Figures of the study, as PNG for the report and as PDF.


rule draw_figures:
    input:
        study=f"{RESULTS}/study.nc",
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        surfaces=lambda w: closed_surfaces("cases", next(iter(CASES["cases"])))[0],
        fits=f"{RESULTS}/tables/measured_fit.csv" if MEASURED else [],
        curves=ancient([curve.measured.file for curve in MEASURED.values()]),
        flow=f"{RESULTS}/tables/hydraulic_aperture.csv" if STUDY.flow else [],
    output:
        [
            report(
                f"{RESULTS}/figures/{figure}.png",
                caption=f"../report/{figure}.rst",
                category="Figures of the study",
                labels={"figure": figure},
            )
            for figure in FIGURES_OF_STUDY
        ],
        collect(f"{RESULTS}/figures/{{figure}}.pdf", figure=FIGURES_OF_STUDY),
    log:
        f"{RESULTS}/logs/draw_figures.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        rocks=STUDY.rocks,
        measured=MEASURED,
        contents=[file_digest(curve.measured.file) for curve in MEASURED.values()],
        seating_stress=STUDY.seating_stress,
        wall_strength_ratio=STUDY.output.wall_strength_ratio,
        code=code("draw_figures.py"),
    message:
        "Draw the figures of the study"
    script:
        "../scripts/draw_figures.py"


rule draw_predictive:
    input:
        study=f"{RESULTS}/study.nc",
        lengths=rules.predict_table_3.output.lengths,
        paper=PAPER_TABLE_3,
    output:
        report(
            f"{RESULTS}/figures/table_3_predictive.png",
            caption="../report/table_3_predictive.rst",
            category="Figures of the study",
            labels={"figure": "table_3_predictive"},
        ),
        f"{RESULTS}/figures/table_3_predictive.pdf",
    log:
        f"{RESULTS}/logs/draw_predictive.log",
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        rocks=STUDY.rocks,
        code=code("draw_predictive.py"),
    message:
        "Draw what repetitions of the study would publish as Table 3"
    script:
        "../scripts/draw_predictive.py"
