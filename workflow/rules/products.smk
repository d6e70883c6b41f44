# Tables, figures and checks of a study: a rule for each of its products (`studies.frame.products`).

for NAME, PRODUCT in PLANNED.items():

    rule:
        name:
            NAME
        input:
            **{
                name: ancient(path) if path and name in BESIDE else path
                for name, path in PLAN.inputs(PRODUCT).items()
            },
        output:
            # Snakemake's report shows the PNG, and reads captions from the folder of this file
            files=[
                (
                    report(path, caption=caption(path).resolve(), category="Figures")
                    if path.endswith(".png")
                    else path
                )
                for path in map(PLAN.file, PRODUCT.files(PLAN))
            ],
        priority: EARLY if PRODUCT.early else 0
        params:
            settings=PLAN.settings(PRODUCT),
            code=PRODUCT.code,
        message:
            PRODUCT.title
        script:
            "../scripts/make_product.py"


# evidence for each of the paper's conclusions
rule conclusions:
    input:
        f"{RESULTS}/tables/conclusions.csv",
    message:
        "The judged conclusions of the paper are in {input[0]}"
