# How well effects are chosen at random conditions: `snakemake effects_auto --configfile config/effects.yaml`.
# Without a section `ablation.validation` no rule here has work.
from jointclosure.effects import design

VALIDATION = CONFIGURATION.ablation.validation if CONFIGURATION.ablation else None
CHOICE_TABLES = ["effects_auto.csv", "effects_auto_summary.csv"]
VALIDATED_WITH = {
    seals_of(f"validate_choice/{number}")[0]: settings_digest(
        {
            "settings": to_plain(design.validation_settings(CONFIGURATION)),
            "code": code_of("validate_choice"),
        }
    )
    for number in range(VALIDATION.scenes if VALIDATION else 0)
}


wildcard_constraints:
    rock="[a-z][a-z0-9_]*",


rule effects_auto:
    input:
        expand(
            f"{RESULTS}/{{output}}",
            output=(
                [
                    *(f"tables/{table}" for table in CHOICE_TABLES),
                    *(f"figures/effects_auto.{format}" for format in ("png", "pdf")),
                ]
                if VALIDATION
                else []
            ),
        ),
        seals_of(*(["sum_up_choices"] if VALIDATION else [])),
    message:
        "How well effects are chosen is known"


rule validate_choice:
    input:
        f"{RESULTS}/logs/effects_kernels.txt",
    output:
        f"{RESULTS}/effects/random_scene_{{number}}.csv",
        seal=f"{RESULTS}/seals/validate_choice/{{number}}.json",
    log:
        f"{RESULTS}/logs/validate_choice/{{number}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/validate_choice/{{number}}.tsv"
    wildcard_constraints:
        number=r"\d+",
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: to_plain(design.validation_settings(CONFIGURATION)),
        code=code_of("validate_choice"),
    message:
        "Hold selected effects against all of them at random conditions {wildcards.number}"
    script:
        "../scripts/validate_choice.py"


rule sum_up_choices:
    input:
        scenes=expand(
            f"{RESULTS}/effects/random_scene_{{number}}.csv",
            number=range(VALIDATION.scenes) if VALIDATION else [],
        ),
        seals=list(VALIDATED_WITH),
    output:
        scenes=f"{RESULTS}/tables/effects_auto.csv",
        summary=f"{RESULTS}/tables/effects_auto_summary.csv",
        figures=expand(
            f"{RESULTS}/figures/effects_auto.{{format}}", format=["png", "pdf"]
        ),
        seal=f"{RESULTS}/seals/sum_up_choices.json",
    log:
        f"{RESULTS}/logs/sum_up_choices.log",
    benchmark:
        f"{RESULTS}/benchmarks/sum_up_choices.tsv"
    conda:
        ENVIRONMENT
    params:
        made_with=VALIDATED_WITH,
        code=code_of("sum_up_choices"),
    message:
        "Sum up how well effects were chosen"
    script:
        "../scripts/sum_up_choices.py"
