"""Commands of the command line, one module each, whose docstring is the text of its help.

`declare` adds the arguments of a command to its parser, `run` executes it and returns its status.
"""

COMMANDS = {
    "close": "close the joint whose two walls were scanned",
    "assess": "say what accuracy costs on that joint, how hard it is, and which effects it needs",
    "simulate": "close one joint of random walls",
    "fit": "find the mismatch wavelength of a joint from its measured closure",
    "validate": "find mechanisms and constants that are compatible with a measured curve",
    "roughness": "compute slopes, JRC, Hurst exponent, curvature and peaks of a scanned wall",
    "report": "write a page on a joint, from the folder of close",
    "doctor": "check whether the environment is ready",
}
"""Names of the modules and their purposes; modules are imported when they are used."""
