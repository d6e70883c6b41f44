"""Run of a program with its output in a log, of which what is for the user is shown."""

import re
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from subprocess import Popen
from typing import TextIO

from process_group import EndRequest, end_group, group, shell_status

from jointclosure.storage.logs import SHOWN

STEPS = re.compile(r"\d+ of \d+ steps \(\d+%\) done")
"""Line of Snakemake after each of its jobs."""
MEMORY = (
    "a process was killed, as systems do that run out of memory. "
    "What is finished stays; start again with fewer jobs at once (CORES=1)"
)
KILLED = (f"exit status {128 + signal.SIGKILL}", "died with <Signals.SIGKILL")


def follow(command: list[str], stream: TextIO, log: Path, request: EndRequest) -> int:
    """Run a command with its output in a log, show what is for the user; its exit status."""
    shown = []
    if not request:
        start = log.stat().st_size
        with group(command, stream) as process:
            for line in lines_of(log, start, process):
                if request:
                    say("ending: the jobs at work are interrupted (again: they are killed)")
                    end_group(process, request)
                    break
                if line.startswith(SHOWN) or STEPS.match(line):
                    shown.append(line.removeprefix(SHOWN).rstrip())
                    say(shown[-1])
    if request:
        say(str(request))
        return 128 + request.signal
    if process.returncode:
        lines = log.read_bytes()[start:].decode(errors="replace").splitlines()
        if process.returncode == -signal.SIGKILL or any(
            end in line for end in KILLED for line in lines
        ):
            print(MEMORY, file=sys.stderr)
        failed = [line for line in shown if " failed: " in line]
        print("\n".join(failed or (f"    {line[:300]}" for line in lines[-40:])), file=sys.stderr)
        print(f"The run failed or was ended; its whole log is {log}", file=sys.stderr)
    elif not shown:
        say("nothing was left to do")
    return shell_status(process.returncode)


def say(text: str) -> None:
    """Print a line at once."""
    print(text, flush=True)


def lines_of(log: Path, start: int, process: Popen) -> Iterator[str]:
    """Generate the lines that a process writes to a file, and "" if there is none for a while."""
    with open(log, encoding="utf-8", errors="replace") as written:
        written.seek(start)
        part = ""
        while True:
            over = process.poll() is not None
            while piece := written.readline():
                part += piece
                if part.endswith("\n"):
                    yield part
                    part = ""
            if over:
                return
            yield ""
            time.sleep(0.2)
