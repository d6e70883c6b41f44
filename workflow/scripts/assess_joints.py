"""Simulate joints of a rock's base case with other numerics and effects, on its surfaces."""

from itertools import islice

from jointclosure.joint.warmup import prepare_kernels
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import write_netcdf
from studies.assessment.report_plan import ends_variant
from studies.frame.settings import walls_in
from studies.frame.simulation import close_points
from studies.frame.yaml_files import provenance

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        points, quantities = snakemake.params.points, snakemake.params.quantities
        settings = points[0].settings
        walls = list(islice(walls_in(snakemake.input.surfaces, settings), settings.realizations))
        # before a joint is timed
        prepare_kernels(point.settings.conditions.model for point in points)
        joints = close_points(points, quantities, log, walls, ends_variant)
        joints = joints.assign_attrs(provenance(snakemake.config) | {"key": snakemake.params.key})
        write_netcdf(joints, snakemake.output[0])
