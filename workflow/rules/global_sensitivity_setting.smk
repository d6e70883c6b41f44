# What the rules of global sensitivity share: the design, what is closed, and its seals. No rules here.
from jointclosure.config.contradictions import OTHER_TARGETS
from jointclosure.studies.global_sensitivity import design as global_design

TOGETHER = config.get("global_sensitivity")
TOGETHER_DESIGN = global_design.design_of(config) if TOGETHER else None
TOGETHER_BLOCKS = (
    {str(block.start): block for block in TOGETHER_DESIGN.blocks()} if TOGETHER else {}
)
TOGETHER_FILES = [
    f"{RESULTS}/global_sensitivity/{rock}.{first}.nc"
    for rock in (TOGETHER_DESIGN.rocks if TOGETHER else [])
    for first in TOGETHER_BLOCKS
]
TOGETHER_TABLES = ["indices", "elasticities", "conclusions", "margins"]
TOGETHER_FIGURES = ["indices", "convergence", "conclusions"]


def together_keys(rock):
    """The part of the configuration that the joints of a rock depend on."""
    unused = {*OTHER_TARGETS.values()} - {"global_sensitivity"}
    keys = {name: part for name, part in config.items() if name not in unused}
    study = config["study"] | {"rocks": [rock], "pool": None}
    return keys | {"study": study, "rocks": {rock: config["rocks"][rock]}}


def together_told(rock, first):
    """What the closing of some rows is told: nothing of how many rows follow them."""
    rows, keys = TOGETHER_BLOCKS[first], together_keys(rock)
    design = TOGETHER_DESIGN.of_rows(rows)
    section = keys["global_sensitivity"] | {
        "rows": design.rows,
        "rows_per_job": design.rows_per_job,
    }
    return {
        "design": to_plain(design),
        "configuration": keys | {"global_sensitivity": section},
        "rows": [rows.start, rows.stop],
    }
