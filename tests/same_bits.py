"""What a process computes where its libraries take the processor for another one."""

import os
import subprocess
import sys

PROCESSORS = {
    "without AVX-512": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR", "OPENBLAS_CORETYPE": "Haswell",
    },
    "without AVX2": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
        "OPENBLAS_CORETYPE": "Nehalem", "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4",
    },
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX"},
}  # fmt: skip
"""Environments, by what the libraries then take the processor for; on one that has none of it
already they change nothing."""


def printed(program: str, **environment: str) -> str:
    """What a Python program prints in such an environment."""
    return subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
