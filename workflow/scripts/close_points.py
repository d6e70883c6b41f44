"""Close the joints at some points of an experiment."""

from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.simulation import close_points
from studies.frame.yaml_files import provenance

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        joints = close_points(snakemake.params.points, snakemake.params.quantities, log)
        joints = joints.assign_attrs(provenance(snakemake.config) | {"key": snakemake.params.key})
        write_netcdf(joints, snakemake.output[0])
