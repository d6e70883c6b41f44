"""Tabulate the accuracy of a study's numerics, and what its effects add and cost."""

from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from studies.assessment.larger_assessment import with_larger
from studies.assessment.report_tables import assessed_table, cost_table
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        read, params, output = snakemake.input, snakemake.params, snakemake.output
        files = {"study": read.study} | ({"pool": read.pool} if read.pool else {})
        datasets = {
            name: read_checked(file, params.keys_of_datasets[name], without=CURVES)
            for name, file in files.items()
        }
        joints = {
            rock: read_checked(file, params.keys_of_joints[rock])
            for rock, file in zip(params.keys_of_joints, read.joints, strict=True)
        }
        table = assessed_table(
            datasets["study"], joints, params.plan, params.effects, params.within
        )
        cost = cost_table(list(datasets.values()), joints, params.plan)
        if read.larger:
            table, count = with_larger(
                table,
                read_csv(read.larger[0]),
                params.conditions,
                params.plan.stated,
                params.within,
            )
            cost["joints_of_make_assess"] = count
        write_csv(table, output.differences)
        write_csv(cost, output.cost)
