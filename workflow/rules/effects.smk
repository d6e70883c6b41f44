# What each effect adds, and what it costs: `snakemake effects --configfile config/effects.yaml`.
# Without an `ablation` section there are no runs, and no rule here has work.
from jointclosure.studies.effects import ablation, design

ABLATION = CONFIGURATION.ablation
SCENES = list(ablation.SCENES) if ABLATION else []
VALIDATION = ABLATION.validation if ABLATION else None
CHOICE_TABLES = ["effects_auto.csv", "effects_auto_summary.csv"]

SCENES_WITH = {
    seals_of(f"close_scene/{rock}.{scene}")[0]: settings_digest(
        {
            "conditions": conditions_of(rock),
            "design": to_plain(ABLATION),
            "code": code_of("close_scene"),
        }
    )
    for scene in SCENES
    for rock in ROCKS
}
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
    scene="[a-z_-]+",


rule effects:
    input:
        f"{RESULTS}/tables/effects_estimate.csv",
        f"{RESULTS}/tables/effects.csv",
        expand(f"{RESULTS}/figures/effects.{{format}}", format=["png", "pdf"]),
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
        seals_of(
            "estimate_effects",
            "weigh_effects",
            "draw_effects",
            *(["sum_up_choices"] if VALIDATION else []),
        ),
    message:
        "What each effect adds and costs is known"


rule compile_effects:
    output:
        f"{RESULTS}/logs/effect_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_effects.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_effects.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of(
            (effects, CONFIGURATION.choices, CONFIGURATION.numerics)
            for effects in ablation.SCENES.values()
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of all scenes"
    script:
        "../scripts/compile_kernels.py"


rule estimate_effects:
    input:
        f"{RESULTS}/logs/effect_kernels.txt",
    output:
        f"{RESULTS}/tables/effects_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_effects.json",
    log:
        f"{RESULTS}/logs/estimate_effects.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_effects.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        conditions=lambda wildcards: conditions_of(next(iter(ROCKS))),
        design=to_plain(ABLATION),
        rocks=len(ROCKS),
        code=code_of("estimate_effects"),
    message:
        "Estimate the core-hours, by one joint of the first rock in every scene"
    script:
        "../scripts/estimate_effects.py"


rule close_scene:
    input:
        f"{RESULTS}/logs/effect_kernels.txt",
    output:
        f"{RESULTS}/effects/{{rock}}.{{scene}}.nc",
        seal=f"{RESULTS}/seals/close_scene/{{rock}}.{{scene}}.json",
    log:
        f"{RESULTS}/logs/close_scene/{{rock}}.{{scene}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_scene/{{rock}}.{{scene}}.tsv"
    conda:
        ENVIRONMENT
    params:
        conditions=lambda wildcards: conditions_of(wildcards.rock),
        design=to_plain(ABLATION),
        code=code_of("close_scene"),
    message:
        "Close the surfaces of {wildcards.rock} with {wildcards.scene}"
    script:
        "../scripts/close_scene.py"


rule weigh_effects:
    input:
        runs=expand(
            f"{RESULTS}/effects/{{rock}}.{{scene}}.nc",
            rock=list(ROCKS),
            scene=SCENES,
        ),
        seals=list(SCENES_WITH),
    output:
        f"{RESULTS}/tables/effects.csv",
        seal=f"{RESULTS}/seals/weigh_effects.json",
    log:
        f"{RESULTS}/logs/weigh_effects.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_effects.tsv"
    conda:
        ENVIRONMENT
    params:
        runs=[[rock, scene] for rock in list(ROCKS) for scene in SCENES],
        made_with=SCENES_WITH,
        code=code_of("weigh_effects"),
    message:
        "Weigh what each effect adds against what it costs"
    script:
        "../scripts/weigh_effects.py"


rule draw_effects:
    input:
        f"{RESULTS}/tables/effects.csv",
        seals=seals_of("weigh_effects"),
    output:
        figures=expand(f"{RESULTS}/figures/effects.{{format}}", format=["png", "pdf"]),
        seal=f"{RESULTS}/seals/draw_effects.json",
    log:
        f"{RESULTS}/logs/draw_effects.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_effects.tsv"
    conda:
        ENVIRONMENT
    params:
        figure="effects",
        code=code_of("draw_table"),
    message:
        "Draw what each effect adds against what it costs"
    script:
        "../scripts/draw_table.py"


rule validate_choice:
    input:
        f"{RESULTS}/logs/effect_kernels.txt",
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
