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
        seals_of("estimate_readings", "weigh_readings", "draw_readings"),
    message:
        "Which reading gives the paper's table is known as far as it can be told"


rule compile_readings:
    input:
        before=ranking_before,
        seals=ranking_seal_before,
    output:
        f"{RESULTS}/logs/readings_kernels_{{round}}.txt",
    log:
        f"{RESULTS}/logs/compile_readings/{{round}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_readings/{{round}}.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_entering,
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of the readings in round {wildcards.round}"
    script:
        "../scripts/compile_kernels.py"


rule estimate_readings:
    input:
        f"{RESULTS}/logs/readings_kernels_{(READING_ROUNDS or ['none'])[0]}.txt",
    output:
        f"{RESULTS}/tables/readings_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_readings.json",
    log:
        f"{RESULTS}/logs/estimate_readings.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_readings.tsv"
    priority: 100
    conda:
        ENVIRONMENT
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
        code=code_of("estimate_readings"),
    message:
        "Estimate the core-minutes, by one joint in every reading"
    script:
        "../scripts/estimate_readings.py"


rule close_reading:
    input:
        kernels_of_round,
    output:
        f"{READINGS_FOLDER}/{{reading}}/{{rock}}.{{first}}.nc",
        seal=f"{RESULTS}/seals/close_reading/{{reading}}/{{rock}}.{{first}}.json",
    log:
        f"{RESULTS}/logs/close_reading/{{reading}}/{{rock}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_reading/{{reading}}/{{rock}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda w: reading_told(w.reading, w.rock, w.first)["settings"],
        code=code_of("close_reading"),
    message:
        "Close {wildcards.rock} from surface {wildcards.first} on: {wildcards.reading}"
    script:
        "../scripts/close_reading.py"


checkpoint rank_readings:
    input:
        closed=closed_for_round,
        before=ranking_before,
        paper=PAPER_TABLE_3,
        seals=seals_for_round,
    output:
        f"{RESULTS}/tables/readings_round_{{round}}.csv",
        seal=f"{RESULTS}/seals/rank_readings/{{round}}.json",
    log:
        f"{RESULTS}/logs/rank_readings/{{round}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/rank_readings/{{round}}.tsv"
    conda:
        ENVIRONMENT
    params:
        design=lambda wildcards: to_plain(READINGS_DESIGN),
        configuration=lambda wildcards: config,
        number=lambda wildcards: READING_ROUNDS.index(wildcards.round),
        folder=READINGS_FOLDER,
        question=lambda wildcards: reading_question(),
        made_with=lambda wildcards: readings_with(closed_for_round(wildcards)),
        code=code_of("rank_readings"),
    message:
        "Rank the readings of round {wildcards.round}"
    script:
        "../scripts/rank_readings.py"


rule weigh_readings:
    input:
        closed=closed_in_all_rounds,
        rankings=[ranking_of(number) for number in range(len(READING_ROUNDS))],
        paper=PAPER_TABLE_3,
        seals=seals_in_all_rounds,
    output:
        table=f"{RESULTS}/tables/readings.csv",
        implied=f"{RESULTS}/tables/readings_implied.csv",
        markdown=f"{RESULTS}/tables/readings.md",
        seal=f"{RESULTS}/seals/weigh_readings.json",
    log:
        f"{RESULTS}/logs/weigh_readings.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_readings.tsv"
    conda:
        ENVIRONMENT
    params:
        design=lambda wildcards: to_plain(READINGS_DESIGN),
        rankings=[ranking_of(number) for number in range(len(READING_ROUNDS))],
        folder=READINGS_FOLDER,
        question=lambda wildcards: reading_question(),
        made_with=lambda wildcards: readings_with(closed_in_all_rounds(wildcards)),
        code=code_of("weigh_readings"),
    message:
        "Put the readings of all rounds together"
    script:
        "../scripts/weigh_readings.py"


rule draw_readings:
    input:
        table=f"{RESULTS}/tables/readings.csv",
        implied=f"{RESULTS}/tables/readings_implied.csv",
        paper=PAPER_TABLE_3,
        seals=seals_of("weigh_readings"),
    output:
        figures=expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=READING_FIGURES,
            format=["png", "pdf"],
        ),
        seal=f"{RESULTS}/seals/draw_readings.json",
    log:
        f"{RESULTS}/logs/draw_readings.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_readings.tsv"
    conda:
        ENVIRONMENT
    params:
        draws=READINGS["draws"] if READINGS else None,
        code=code_of("draw_readings"),
    message:
        "Draw how likely Table 3 is in each reading"
    script:
        "../scripts/draw_readings.py"
