# A requested accuracy (study.accuracy): surfaces are added, round by round, until it is reached.
#
# Each round simulates the joints of its plan, and from these the plan of the next round is made.
# The study has the joints of the last round.


if STUDY.study.accuracy is not None:

    rule price_accuracy:
        input:
            surfaces=[
                surfaces_of("cases", point.settings.case.label, 0, 0)
                for point in first_points("cases")
            ],
            kernels=kernel_files(first_points("cases") + first_points("finest")),
        output:
            f"{RESULTS}/tables/accuracy_price.csv",
        log:
            f"{RESULTS}/logs/price_accuracy.log",
        conda:
            ENVIRONMENT
        params:
            points={name: first_points(name) for name in ("cases", "finest")},
            cases={
                rock: sum(case.rock == rock for case in CASES["cases"].values())
                for rock in sorted(STUDY.rocks)
            },
            code=code("price_accuracy.py", titles=False),
        message:
            "Measure what a joint takes by the study's numerics and by the finest ones"
        script:
            "../scripts/price_accuracy.py"

    checkpoint plan_accuracy:
        input:
            price=lambda w: (
                rules.price_accuracy.output[0]
                if w.round == "0" and STUDY.study.accuracy.budget_core_minutes
                else []
            ),
            cases=lambda w: joints_of_round("cases", int(w.round) - 1),
            finest=lambda w: joints_of_round("finest", int(w.round) - 1),
            plan=lambda w: (
                f"{RESULTS}/accuracy/round_{int(w.round) - 1}.json"
                if w.round != "0"
                else []
            ),
        output:
            plan=f"{RESULTS}/accuracy/round_{{round}}.json",
        log:
            f"{RESULTS}/logs/plan_accuracy/{{round}}.log",
        wildcard_constraints:
            round="[0-9]+",
        priority: 2
        conda:
            ENVIRONMENT
        params:
            accuracy=[STUDY.study.accuracy],
            significance=STUDY.statistics.significance,
            cases=list(CASES["cases"].values()),
            key_of={name: keys_of(name) for name in ("cases", "finest")},
            code=code("plan_accuracy.py", titles=False),
        message:
            "Plan the surfaces of round {wildcards.round} for the requested accuracy"
        script:
            "../scripts/plan_accuracy.py"

    use rule aggregate as aggregate_finest with:
        input:
            joints=lambda w: closed_joints("finest"),
            effects=[],
            walls=collect(f"{RESULTS}/walls/{{rock}}.nc", rock=SCANNED),
        output:
            f"{RESULTS}/finest.nc",
        log:
            f"{RESULTS}/logs/aggregate_finest.log",
        params:
            ensemble="finest",
            cases=list(CASES["finest"].values()),
            key_of=keys_of("finest"),
            key=dataset_key("finest"),
            stated=configuration_text(closed_keys(STUDY.stated)),
            code=code("aggregate.py", titles=False),
        message:
            "Join the joints that were closed by the finest numerics"

    rule tabulate_accuracy:
        input:
            study=f"{RESULTS}/study.nc",
            finest=f"{RESULTS}/finest.nc",
        output:
            f"{RESULTS}/tables/accuracy_reached.csv",
        log:
            f"{RESULTS}/logs/tabulate_accuracy.log",
        conda:
            ENVIRONMENT
        params:
            key_of={"study": KEYS["study"], "finest": dataset_key("finest")},
            accuracy=[STUDY.study.accuracy],
            significance=STUDY.statistics.significance,
            code=code("tabulate_accuracy.py"),
        message:
            "Tabulate results by two levels, the study's numerics and the finest, and their errors"
        script:
            "../scripts/tabulate_accuracy.py"
