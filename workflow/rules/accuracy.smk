# The total error of all methods: `snakemake total_error --configfile studies/accuracy/accuracy_biases.yaml`, of the
# experiment accuracy, and of the stored scatter and worth of control variates of the default study.
ACCURACY = config.get("accuracy")
TOTAL = ACCURACY.get("total") if ACCURACY else None


rule total_error:
    input:
        f"{RESULTS}/tables/accuracy_total.csv",
        f"{RESULTS}/tables/accuracy_split.csv",
        expand(f"{RESULTS}/figures/accuracy_total.{{format}}", format=["png", "pdf"]),
    message:
        "The total error of all methods is in {input[0]}"


rule weigh_total_error:
    input:
        costs=f"{RESULTS}/tables/accuracy_cost.csv",
        variance="studies/accuracy/results/variance_reduction/variance_reduction.csv",
    output:
        methods=f"{RESULTS}/tables/accuracy_methods.csv",
        points=f"{RESULTS}/tables/accuracy_total.csv",
        splits=f"{RESULTS}/tables/accuracy_split.csv",
        figures=expand(
            f"{RESULTS}/figures/accuracy_total.{{format}}", format=["png", "pdf"]
        ),
    params:
        design=ACCURACY,
        joint=DESIGNS["accuracy"].parameters["joint"] if TOTAL else None,
        measured=CONFIGURATION.statistics.control_variates,
    script:
        "../scripts/weigh_total_error.py"
