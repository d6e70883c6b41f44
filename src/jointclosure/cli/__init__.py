"""Commands of the command line, one module each, whose docstring is the text of its help.

`declare` adds the arguments of a command to its parser, `run` executes it and returns its status.
"""

COMMANDS = {
    "close": "simulate a joint whose two walls were scanned",
    "assess": "assess such a joint: cost of accuracy, hardness, and the effects that it needs",
    "simulate": "simulate a joint of two random walls",
    "fit": "estimate the mismatch wavelength of a joint from its measured closure",
    "validate": "find mechanisms and constants that are compatible with a measured curve",
    "roughness": "compute slopes, JRC, Hurst exponent, curvature and peaks of a scanned wall",
    "report": "write a page about a joint from the folder that close wrote",
    "doctor": "check whether the environment is ready",
}
"""Names of the modules and their purposes; modules are imported when they are used."""
