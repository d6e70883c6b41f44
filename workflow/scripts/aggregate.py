"""Join all cases of an ensemble in one dataset, few realisations at a time."""

import json
from pathlib import Path

from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import chosen_effects, write_ensemble
from studies.frame.yaml_files import provenance

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        stated = json.loads(snakemake.params.stated)
        attributes = {
            "title": f"closure of rough joints, study {stated['study']['name']}",
            "ensemble": snakemake.params.ensemble,
            "references": "Rezaei Niya & Selvadurai, Modeling the Approach of Non-mated Rock "
            "Fracture Surfaces Under Quasi-static Normal Load Cycles",
            "key": snakemake.params.key,
        } | provenance(stated)
        if snakemake.input.effects:
            attributes["effects_chosen"] = chosen_effects(
                snakemake.input.effects, snakemake.params.effects_keys
            )
        if snakemake.input.walls:
            from studies.frame.scanned_walls import (
                described,  # imported here, as few studies have scans
            )

            walls_keys = snakemake.params.walls_keys
            files = {Path(file).stem: file for file in snakemake.input.walls}
            walls = {rock: read_checked(file, walls_keys[rock]) for rock, file in files.items()}
            attributes["walls"] = described(walls)
        write_ensemble(
            snakemake.input.joints,
            snakemake.params.key_of,
            snakemake.params.cases,
            attributes,
            snakemake.output[0],
            log,
        )
