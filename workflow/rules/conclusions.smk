# Evidence for each of the paper's conclusions: `snakemake conclusions`.


rule conclusions:
    input:
        f"{RESULTS}/tables/conclusions.csv",
    message:
        "The judged conclusions of the paper are in {input[0]}"


# Readings and choices are those that were run here, or else the published ones.
rule conclude:
    input:
        claims=f"{RESULTS}/tables/claims.csv",
        jrc_range=beside("docs/results/jrc_range/jrc_range_claims.csv"),
        readings=beside("docs/results/conclusions/earlier_readings.csv"),
        choices=beside(
            "results/global_sensitivity/tables/global_sensitivity_conclusions.csv",
            "docs/results/global_sensitivity/global_sensitivity_conclusions.csv",
        ),
        margins=beside(
            "results/global_sensitivity/tables/global_sensitivity_margins.csv",
            "docs/results/global_sensitivity/global_sensitivity_margins.csv",
        ),
    output:
        table=f"{RESULTS}/tables/conclusions.csv",
    script:
        "../scripts/conclude.py"
