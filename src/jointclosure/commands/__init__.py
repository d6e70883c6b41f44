"""Commands of the command line, one module each: `add_to` declares it, `run` executes it."""

COMMANDS = {
    "close": "close the joint whose two walls were scanned",
    "simulate": "close one joint of random walls",
    "fit": "find the mismatch wavelength of a joint from its measured closure",
    "validate": "compare the model with three measured joints whose files are public",
    "roughness": "compute slopes, JRC, Hurst exponent, curvature and peaks of a scanned wall",
    "compare": "list the differences between two studies",
    "report": "write a page on a finished study, or on a joint",
    "engineering": "tabulate curves and stiffness of a study, with bands over its joints",
    "plan": "compute how many surfaces a precision or a power needs",
    "repeat": "repeat one realisation of a study",
    "doctor": "check whether the environment is ready for a study",
}
"""Names of the modules and their purposes; modules are imported when they are used."""
