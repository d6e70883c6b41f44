# The assessment of a study in its report: numerics and effects, compared on a few joints of base
# cases (`assessment: null` switches this off), and the ranking of the joints by hardness.


if PLAN is not None:

    rule assess_joints:
        input:
            surfaces=lambda w: surfaces_assessed(w.rock),
            kernels=lambda w: kernel_files(PLAN.points[w.rock]),
        output:
            f"{RESULTS}/assessed/{{rock}}.nc",
        log:
            f"{RESULTS}/logs/assess_joints/{{rock}}.log",
        group:
            "closures"
        conda:
            ENVIRONMENT
        params:
            points=lambda w: PLAN.points[w.rock],
            quantities=ASSESSED_QUANTITIES,
            key=lambda w: assessed_key(w.rock),
            code=code("assess_joints.py", titles=False),
        message:
            "Close joints of {wildcards.rock} by other numerics and effects, for the report"
        script:
            "../scripts/assess_joints.py"

    rule tabulate_assessed:
        input:
            study=f"{RESULTS}/study.nc",
            pool=f"{RESULTS}/pool.nc" if POOL == "pool" else [],
            joints=collect(f"{RESULTS}/assessed/{{rock}}.nc", rock=PLAN.points),
            # that of make assess, if it was made
            larger=[
                file
                for file in [f"{RESULTS}/tables/assessment.csv"]
                if PLAN.points and os.path.exists(file)
            ],
        output:
            differences=f"{RESULTS}/tables/study_assessment.csv",
            cost=f"{RESULTS}/tables/study_assessment_cost.csv",
        log:
            f"{RESULTS}/logs/tabulate_assessed.log",
        conda:
            ENVIRONMENT
        params:
            keys_of_datasets=KEYS,
            keys_of_joints={rock: assessed_key(rock) for rock in PLAN.points},
            plan=PLAN._replace(points={}),
            effects={name: rock.effects for name, rock in STUDY.rocks.items()},
            within=STUDY.assessment.within,
            conditions=base_conditions(STUDY),
            code=code("tabulate_assessed.py"),
        message:
            "Tabulate what the numerics of the study reached, and what its effects add"
        script:
            "../scripts/tabulate_assessed.py"


rule rank_joints:
    input:
        study=f"{RESULTS}/study.nc",
    output:
        f"{RESULTS}/tables/study_hardness.csv",
    log:
        f"{RESULTS}/logs/rank_joints.log",
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        within=(STUDY.assessment or AssessmentSection()).within,
        jumps=STUDY.numerics.breakage == "resolved",
        code=code("rank_joints.py"),
    message:
        "Rank the joints of the study by hardness"
    script:
        "../scripts/rank_joints.py"


rule draw_panels:
    input:
        hardness=rules.rank_joints.output[0],
        differences=(
            f"{RESULTS}/tables/study_assessment.csv"
            if "study_accuracy" in FIRST_PANELS
            else []
        ),
    output:
        [
            report(
                f"{RESULTS}/figures/{figure}.png",
                caption=f"../report/{figure}.rst",
                category="Figures of the study",
                labels={"figure": figure},
            )
            for figure in FIRST_PANELS
        ],
        collect(f"{RESULTS}/figures/{{figure}}.pdf", figure=FIRST_PANELS),
    log:
        f"{RESULTS}/logs/draw_panels.log",
    conda:
        ENVIRONMENT
    params:
        titles=STUDY.titles,
        within=None if STUDY.assessment is None else STUDY.assessment.within,
        code=code("draw_panels.py"),
    message:
        "Draw the panels of the report's first screen"
    script:
        "../scripts/draw_panels.py"
