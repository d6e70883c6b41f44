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


wildcard_constraints:
    rock="[a-z][a-z0-9_]*",


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
    input:
        ancient(f"{RESULTS}/logs/effects_kernels.txt"),
    output:
        f"{RESULTS}/effects/random_scene_{{number}}.csv",
    wildcard_constraints:
        number=r"\d+",
    params:
        settings=(to_plain(validation_settings(CONFIGURATION)) if VALIDATION else None),
    script:
        "../scripts/validate_choice.py"


rule sum_up_choices:
    input:
        scenes=expand(
            f"{RESULTS}/effects/random_scene_{{number}}.csv",
            number=range(VALIDATION.scenes) if VALIDATION else [],
        ),
    output:
        scenes=f"{RESULTS}/tables/effects_auto.csv",
        summary=f"{RESULTS}/tables/effects_auto_summary.csv",
        figures=CHOICE_FIGURES,
    script:
        "../scripts/sum_up_choices.py"
