# Test of the choice of effects at random conditions: `snakemake effects_auto --configfile studies/effects/effects.yaml`.
# Without a section `ablation.validation` no rule here has work.
from studies.effects.validation import validation_settings

VALIDATION = CONFIGURATION.ablation.validation if CONFIGURATION.ablation else None
CHOICE_TABLES = ["effects_auto.csv", "effects_auto_summary.csv"]
CHOICE_FIGURES = expand(
    f"{RESULTS}/figures/{{name}}.{{format}}",
    name=["effects_auto", "effects_regions"],
    format=["png", "pdf"],
)


rule effects_auto:
    input:
        [
            *expand(f"{RESULTS}/tables/{{table}}", table=CHOICE_TABLES),
            *CHOICE_FIGURES,
        ]
        if VALIDATION
        else [],
    message:
        "The choice of effects is tested"


rule validate_choice:
    output:
        scenes=f"{RESULTS}/tables/effects_auto.csv",
        summary=f"{RESULTS}/tables/effects_auto_summary.csv",
        figures=CHOICE_FIGURES,
    threads: workflow.cores
    params:
        settings=validation_settings(CONFIGURATION) if VALIDATION else None,
        kernels=DESIGNS["effects"].kernels() if VALIDATION else [],
    script:
        "../scripts/validate_choice.py"
