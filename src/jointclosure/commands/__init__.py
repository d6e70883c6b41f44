"""The commands of the command line, a module each: `add_to` declares it, `run` does it."""

COMMANDS = {
    "close": "close the joint whose two walls were scanned",
    "simulate": "close one joint of random walls",
    "fit": "the mismatch of the joint whose closure was measured",
    "roughness": "slopes, JRC, Hurst exponent, curvature and peaks of a scanned wall",
    "compare": "what moved between two studies",
    "report": "a finished study, or a joint, as one page to read",
    "engineering": "a study's curves and stiffness, with bands over its joints",
    "plan": "how many surfaces a precision or a power needs",
    "repeat": "one realisation of a study again",
    "doctor": "is the environment fit for a study, and what to do where it is not",
}
"""Names of the modules, and what each does: they are imported when they are asked for."""
