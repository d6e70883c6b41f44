# What the rules of readings share: who enters a round, what is closed for it, and its seals. No rules here.
from jointclosure.experiments.readings import design as readings

READINGS = config.get("readings")
READINGS_DESIGN = readings.design_of(config) if READINGS else None
READING_ROUNDS = [each.name for each in READINGS_DESIGN.rounds] if READINGS else []
READINGS_FOLDER = f"{RESULTS}/readings"
READING_FIGURES = ["readings_likelihood", "readings_sensitivity"]


def reading_settings(reading, rock, first=0):
    """Settings of all cases of a rock in a reading, for the block from a realisation on."""
    block = range(first, first + READINGS_DESIGN.block)
    return readings.settings_of(READINGS_DESIGN, config, reading, rock, block)


def reading_told(reading, rock, first):
    """What the closing of a block is told."""
    return {
        "settings": to_plain(reading_settings(reading, rock, int(first))),
        "code": code_of("close_reading"),
    }


def reading_seal(file):
    """The seal of a block that was closed."""
    block = Path(file).relative_to(READINGS_FOLDER).with_suffix("")
    return seals_of(f"close_reading/{block}")[0]


def readings_with(files):
    """The digests of settings that seals of blocks must have."""
    return {
        reading_seal(file): settings_digest(
            reading_told(Path(file).parent.name, *Path(file).stem.split("."))
        )
        for file in files
    }


def readings_there():
    """Blocks that are there and that this configuration may ask for."""
    for seal in sorted(Path(f"{RESULTS}/seals/close_reading").glob("*/*.json")):
        reading, rock = seal.parent.name, seal.stem.split(".")[0]
        if READINGS and READINGS_DESIGN.has(reading) and rock in READINGS_DESIGN.rocks:
            if readings.can_be_run(READINGS_DESIGN, config, reading):
                yield f"{READINGS_FOLDER}/{reading}/{seal.stem}.nc"


def ranking_of(number):
    """File that says who was kept in a round."""
    return f"{RESULTS}/tables/readings_round_{READING_ROUNDS[number]}.csv"


def ranking_seal(number):
    return seals_of(f"rank_readings/{READING_ROUNDS[number]}")[0]


def ranking_before(wildcards):
    number = READING_ROUNDS.index(wildcards.round)
    return [ranking_of(number - 1)] if number else []


def ranking_seal_before(wildcards):
    number = READING_ROUNDS.index(wildcards.round)
    return [ranking_seal(number - 1)] if number else []


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


def seals_for_round(wildcards):
    closed = [reading_seal(file) for file in closed_for_round(wildcards)]
    return closed + ranking_seal_before(wildcards)


def seals_in_all_rounds(wildcards):
    closed = [reading_seal(file) for file in closed_in_all_rounds(wildcards)]
    return closed + [ranking_seal(number) for number in range(len(READING_ROUNDS))]


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


READINGS_WITH = readings_with(readings_there())
