"""Commands on finished studies, one module each, as in `jointclosure.cli`; and their files."""

COMMANDS = {
    "compare": "list the differences between two studies",
    "report": "write a page on a finished study",
    "engineering": "tabulate curves and stiffness of a study, with bands over its joints",
    "plan": "compute how many surfaces a precision or a power needs",
    "repeat": "repeat one realisation of a study",
}
"""Names of the modules and their purposes; modules are imported when they are used."""
