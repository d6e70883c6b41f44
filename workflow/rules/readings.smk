# Which reading of the paper gives its Table 3: `snakemake readings --configfile config/readings.yaml`.
# Rounds follow each other: who enters one is known when the one before is ranked, which is a checkpoint. Without the
# configuration's `readings` section there are none, and no rule here has work.


wildcard_constraints:
    reading="[a-z0-9_-]+",
    rock="[a-z0-9_]+",
    round="[a-z0-9_]+",


rule readings:
    input:
        f"{RESULTS}/tables/readings_estimate.csv",
        f"{RESULTS}/tables/readings.csv",
        f"{RESULTS}/tables/readings.md",
        expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=READING_FIGURES,
            format=["png", "pdf"],
        ),
    message:
        "Which reading gives the paper's table is known as far as it can be told"


rule compile_readings:
    input:
        before=ranking_before,
    output:
        f"{RESULTS}/logs/readings_kernels_{{round}}.txt",
    params:
        kernels=kernels_entering,
    script:
        "../scripts/compile_kernels.py"


rule estimate_readings:
    input:
        f"{RESULTS}/logs/readings_kernels_{(READING_ROUNDS or ['none'])[0]}.txt",
    output:
        f"{RESULTS}/tables/readings_estimate.csv",
    priority: 100
    params:
        design=lambda wildcards: to_plain(READINGS_DESIGN),
        rocks=lambda wildcards: {
            rock: to_plain(reading_settings(readings.AS_CONFIGURED, rock))
            for rock in READINGS_DESIGN.rocks
        },
        readings=lambda wildcards: {
            name: to_plain(reading_settings(name, READINGS_DESIGN.rounds[0].rocks[0]))
            for name, each in READINGS_DESIGN.singles.items()
            if each.run == name
        },
    script:
        "../scripts/estimate_readings.py"


rule close_reading:
    input:
        kernels_of_round,
    output:
        f"{READINGS_FOLDER}/{{reading}}/{{rock}}.{{first}}.nc",
    params:
        settings=lambda w: to_plain(reading_settings(w.reading, w.rock, int(w.first))),
    script:
        "../scripts/close_reading.py"


checkpoint rank_readings:
    input:
        closed=closed_for_round,
        before=ranking_before,
        paper=PAPER_TABLE_3,
    output:
        f"{RESULTS}/tables/readings_round_{{round}}.csv",
    params:
        design=lambda wildcards: to_plain(READINGS_DESIGN),
        configuration=lambda wildcards: config,
        number=lambda wildcards: READING_ROUNDS.index(wildcards.round),
        folder=READINGS_FOLDER,
        question=lambda wildcards: reading_question(),
    script:
        "../scripts/rank_readings.py"


rule weigh_readings:
    input:
        closed=closed_in_all_rounds,
        rankings=[ranking_of(number) for number in range(len(READING_ROUNDS))],
        paper=PAPER_TABLE_3,
    output:
        table=f"{RESULTS}/tables/readings.csv",
        implied=f"{RESULTS}/tables/readings_implied.csv",
        markdown=f"{RESULTS}/tables/readings.md",
    params:
        design=lambda wildcards: to_plain(READINGS_DESIGN),
        rankings=[ranking_of(number) for number in range(len(READING_ROUNDS))],
        folder=READINGS_FOLDER,
        question=lambda wildcards: reading_question(),
    script:
        "../scripts/weigh_readings.py"


rule draw_readings:
    input:
        table=f"{RESULTS}/tables/readings.csv",
        implied=f"{RESULTS}/tables/readings_implied.csv",
        paper=PAPER_TABLE_3,
    output:
        figures=expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=READING_FIGURES,
            format=["png", "pdf"],
        ),
    params:
        draws=READINGS["draws"] if READINGS else None,
    script:
        "../scripts/draw_readings.py"
