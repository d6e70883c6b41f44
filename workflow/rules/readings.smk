# Which reading of the paper gives its Table 3: `snakemake readings --configfile config/readings.yaml`.
# Rounds follow each other: who enters one is known when the one before is ranked, which is a checkpoint. Without the
# configuration's `readings` section there are none, and no rule here has work.
from jointclosure.studies.readings import design as readings

READINGS = config.get("readings")
READINGS_DESIGN = readings.design_of(config) if READINGS else None
READING_ROUNDS = [each.name for each in READINGS_DESIGN.rounds] if READINGS else []
READINGS_FOLDER = f"{RESULTS}/readings"
READING_FIGURES = ["readings_likelihood", "readings_sensitivity"]


def reading_settings(reading, rock, first=0):
    """Settings of all cases of a rock in a reading, for the block from a realisation on."""
    block = range(first, first + READINGS_DESIGN.block)
    return readings.settings_of(READINGS_DESIGN, config, reading, rock, block)


def ranking_of(number):
    """File that says who was kept in a round."""
    return f"{RESULTS}/tables/readings_round_{READING_ROUNDS[number]}.csv"


def ranking_before(wildcards):
    number = READING_ROUNDS.index(wildcards.round)
    return [ranking_of(number - 1)] if number else []


def entering_round(number):
    """Readings that enter a round, once the one before is ranked."""
    judged = None
    if number:
        before = checkpoints.rank_readings.get(round=READING_ROUNDS[number - 1])
        judged = read_csv(before.output[0])
    return readings.entering(READINGS_DESIGN, config, number, judged)


def closed_for_round(wildcards):
    number = READING_ROUNDS.index(wildcards.round)
    entered = entering_round(number)
    found = readings.files_of(READINGS_DESIGN, READINGS_FOLDER, number, entered)
    return [file for _, _, file in found]


def closed_in_all_rounds(wildcards):
    found = []
    for number, name in enumerate(READING_ROUNDS):
        ranked = read_csv(checkpoints.rank_readings.get(round=name).output[0])
        entered = ranked.reading.tolist()
        found += readings.files_of(READINGS_DESIGN, READINGS_FOLDER, number, entered)
    return list(dict.fromkeys(file for _, _, file in found))


def kernels_of_round(wildcards):
    """The round whose kernels a reading needs: pairs are not known before theirs."""
    rounds = (
        each.name for each in READINGS_DESIGN.rounds if each.candidates == "pairs"
    )
    name = READING_ROUNDS[0]
    if wildcards.reading in READINGS_DESIGN.pairs:
        name = next(rounds)
    return f"{RESULTS}/logs/readings_kernels_{name}.txt"


def kernels_entering(wildcards, input):
    """Kernels of the readings that enter a round."""
    number = READING_ROUNDS.index(wildcards.round)
    judged = read_csv(input.before[0]) if number else None
    entered = readings.entering(READINGS_DESIGN, config, number, judged)
    first = [reading_settings(name, READINGS_DESIGN.rocks[0])[0] for name in entered]
    return kernels_of(
        (each.case.effects, each.choices, each.numerics) for each in first
    )


def reading_question():
    """What readings are asked, as plain data."""
    return {
        "parameters": {
            name: {
                parameter: [
                    list(levels),
                    cases.base_case(name, rock).property(parameter),
                ]
                for parameter, levels in rock.levels.items()
            }
            for name, rock in ROCKS.items()
        },
        "draws": READINGS["draws"],
        "significance": CONFIGURATION.statistics.significance,
        "repetitions": READINGS["repetitions"],
        "groups": READINGS["groups"],
        "root_seed": CONFIGURATION.study.root_seed,
    }


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
    log:
        f"{RESULTS}/logs/close_reading/{{reading}}/{{rock}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_reading/{{reading}}/{{rock}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda w: to_plain(reading_settings(w.reading, w.rock, int(w.first))),
        code=code_of("close_reading"),
    message:
        "Close {wildcards.rock} from surface {wildcards.first} on: {wildcards.reading}"
    script:
        "../scripts/close_reading.py"


checkpoint rank_readings:
    input:
        closed_for_round,
        before=ranking_before,
        paper=PAPER_TABLE_3,
    output:
        f"{RESULTS}/tables/readings_round_{{round}}.csv",
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
        code=code_of("rank_readings"),
    message:
        "Rank the readings of round {wildcards.round}"
    script:
        "../scripts/rank_readings.py"


rule weigh_readings:
    input:
        closed_in_all_rounds,
        rankings=[ranking_of(number) for number in range(len(READING_ROUNDS))],
        paper=PAPER_TABLE_3,
    output:
        table=f"{RESULTS}/tables/readings.csv",
        implied=f"{RESULTS}/tables/readings_implied.csv",
        markdown=f"{RESULTS}/tables/readings.md",
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
    output:
        expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=READING_FIGURES,
            format=["png", "pdf"],
        ),
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
