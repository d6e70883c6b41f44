"""Plan how many surfaces of each case are simulated next, for the requested accuracy."""

import json

from jointclosure.storage.files import read_csv, read_text, write_text
from jointclosure.storage.logs import logging_to
from studies.frame.datasets import read_joints
from studies.paper.accuracy import (
    START,
    Counts,
    describe_reached,
    next_counts,
    reached_table,
    start_counts,
)

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        read, params = snakemake.input, snakemake.params
        (accuracy,), number = params.accuracy, int(snakemake.wildcards.round)
        if number == 0:
            following = start_counts(read_csv(read.price), accuracy) if read.price else START
            counts = following
        else:
            former = json.loads(read_text(read.plan))
            counts = Counts(former["cases"], former["finest"])
            study, finest = (
                read_joints(read[name], params.key_of[name], params.cases)
                for name in ("cases", "finest")
            )
            table = reached_table(study, finest, accuracy, params.significance)
            following = next_counts(table, accuracy, counts)
            log.show(describe_reached(table, accuracy, ended=following is None))
        if following is not None:
            counts = following
            log.show(
                f"accuracy: closes {counts.surfaces} surfaces of each case, and "
                f"{counts.differences} of them by the finest numerics too"
            )
        plan = {"round": number, "cases": counts.surfaces, "finest": counts.differences}
        write_text(json.dumps(plan | {"ended": following is None}), snakemake.output.plan)
