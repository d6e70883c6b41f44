"""Write all keys of the study; its dataset has only those that may change closures."""

from jointclosure.storage.files import write_text
from jointclosure.storage.logs import logging_to

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        write_text(snakemake.params.stated, snakemake.output[0])
