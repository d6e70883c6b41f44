# Tables 1 to 3 in the paper's layout, and tables for studies with measured curves or flow.


rule write_tables:
    input:
        intervals=f"{RESULTS}/tables/table_3_indifference.csv",
        closures=f"{RESULTS}/tables/max_closure.csv",
        # they are shown above Table 3 if its tests are paired
        elasticities=(
            f"{RESULTS}/tables/elasticities.csv"
            if STUDY.study.draws == "common"
            else []
        ),
    output:
        rocks=f"{RESULTS}/tables/table_1_rocks.csv",
        cases=f"{RESULTS}/tables/table_2_cases.csv",
        intervals=f"{RESULTS}/tables/table_3_indifference.md",
    log:
        f"{RESULTS}/logs/write_tables.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        rocks=STUDY.rocks,
        code=code("write_tables.py"),
    message:
        "Write Tables 1 to 3 in the paper's layout"
    script:
        "../scripts/write_tables.py"


rule state_configuration:
    output:
        f"{RESULTS}/tables/configuration.json",
    log:
        f"{RESULTS}/logs/state_configuration.log",
    priority: 3
    conda:
        ENVIRONMENT
    params:
        stated=configuration_text(STUDY.stated),
    message:
        "State all keys of the study"
    script:
        "../scripts/state_configuration.py"


rule fit_measured:
    input:
        study=f"{RESULTS}/study.nc",
        curves=ancient([curve.measured.file for curve in MEASURED.values()]),
    output:
        f"{RESULTS}/tables/measured_fit.csv",
    log:
        f"{RESULTS}/logs/fit_measured.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        curves=MEASURED,
        contents=[file_digest(curve.measured.file) for curve in MEASURED.values()],
        seating_stress=STUDY.seating_stress,
        code=code("fit_measured.py"),
    message:
        "Find the realisations that fit the measured curves best"
    script:
        "../scripts/fit_measured.py"


rule tabulate_flow:
    input:
        study=f"{RESULTS}/study.nc",
    output:
        f"{RESULTS}/tables/hydraulic_aperture.csv",
    log:
        f"{RESULTS}/logs/tabulate_flow.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        code=code("tabulate_flow.py"),
    message:
        "Tabulate mean and hydraulic apertures of all cases over stress"
    script:
        "../scripts/tabulate_flow.py"
