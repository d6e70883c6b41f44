"""Close the joints of an experiment that are missing, and make its tables."""

from functools import partial
from pathlib import Path

from jointclosure.engine.cache import make_missing
from jointclosure.engine.ensembles import as_dataset, as_table, entries_of
from jointclosure.storage.files import read_csv, write_csv, write_text
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.experiments import checked, experiment_named
from studies.frame.files import provenance
from studies.frame.jobs import compile_all, job, listed

if __name__ == "__main__":
    with job(snakemake) as logbook:
        name, config = snakemake.params.experiment, snakemake.config
        experiment = experiment_named(name)
        design, folder = experiment.design(checked(config)), Path(snakemake.output.joints).parent
        entries = entries_of(name, design.jobs, experiment.quantities)
        prepare = partial(compile_all, design.kernels(), logbook)
        make_missing(entries, folder, snakemake.threads, logbook.show, "joints closed", prepare)
        joints = as_table(*(read_netcdf(entry.file(folder)) for entry in entries))
        dataset = as_dataset(joints).assign_attrs(provenance(config))
        write_netcdf(dataset, snakemake.output.joints)
        files = {key: read_csv(file) for key, file in design.files.items()}
        tables = experiment.tabulate(joints, design.parameters | files)
        for output in listed(snakemake.output.tables):
            table = tables[Path(output).name.removesuffix(".csv")]
            write_text(table, output) if isinstance(table, str) else write_csv(table, output)
            logbook(f"wrote {output}")
