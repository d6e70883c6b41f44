"""Snakemake run with its log in a file: a line on how far it is, what failed, and its end."""

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from process_group import EndRequest, end_group, kill_group, shell_status, start_group

from jointclosure.jobs.logbook import failed_log
from jointclosure.jobs.progress import WorkflowProgress

SHOWN = "jointclosure: "
"""Lines of the log that start so are for the user."""
SECONDS, PART = 30.0, 0.1
"""Between two lines on progress where no terminal is: so long, or so much of all jobs."""


def follow(command: list[str], stream: TextIO, log: Path, request: EndRequest) -> int:
    """Run Snakemake with its log in a file, and say how far it is; its exit status."""
    console = Console()
    if request:
        return ended(console, request)
    start = log.stat().st_size
    process = start_group(command, stdout=stream, stderr=stream)
    progress = WorkflowProgress()
    try:
        for line in lines_of(log, start, process):
            if request:
                console.say("ending: the jobs at work are interrupted (again: they are killed)")
                end_group(process, request)
                return ended(console, request)
            progress.read(line)
            if line.startswith(SHOWN):
                console.say(line.removeprefix(SHOWN).rstrip())
            console.show(progress)
    finally:  # of whatever ends this, nothing goes on
        kill_group(process)
    console.clear()
    written = log.read_bytes()[start:].decode(errors="replace")
    if process.returncode:
        print(failures(written), file=sys.stderr)
        print(f"The run failed or was ended; all that was said is in {log}", file=sys.stderr)
    elif progress.total:
        console.say(f"{progress.done} of {progress.total} jobs done")
        for line in repeated(written):
            console.say(line)
    else:
        console.say("nothing was left to do")
    return shell_status(process.returncode)


def ended(console: "Console", request: EndRequest) -> int:
    """Say how a run goes on that was asked to end; its exit status."""
    console.say(str(request))
    return 128 + request.signal


def lines_of(log: Path, start: int, process: subprocess.Popen) -> Iterator[str]:
    """Lines that a process writes to a file, as they come, and "" where none came for a while."""
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


class Console:
    """A line that is renewed on a terminal; elsewhere a line now and then."""

    def __init__(self, stream: TextIO | None = None):
        self._stream = sys.stdout if stream is None else stream
        self._renewed = self._stream.isatty()
        self._shown, self._at, self._part = "", time.monotonic(), 0.0

    def show(self, progress: WorkflowProgress) -> None:
        """Say how far it is, if it is time to."""
        if not progress.total:
            return
        now, part = time.monotonic(), progress.done / progress.total
        late, far = now - self._at > SECONDS, part >= self._part + PART
        if self._renewed and (now - self._at > 0.5):
            self._at = now
            self._renew(progress.text())
        elif not self._renewed and (late or far):
            self._at, self._part = now, part
            print(progress.text(), file=self._stream, flush=True)

    def say(self, text: str) -> None:
        """A line that stays."""
        self.clear()
        print(text, file=self._stream, flush=True)

    def clear(self) -> None:
        """Take the renewed line away."""
        if self._shown:
            self._renew("")

    def _renew(self, text: str) -> None:
        print("\r" + text.ljust(len(self._shown)), end="", file=self._stream, flush=True)
        if not text:
            print("\r", end="", file=self._stream, flush=True)
        self._shown = text


def failures(said: str) -> str:
    """What went wrong, of all that Snakemake said: each failed rule, and the end of its log."""
    found = dict.fromkeys(_FAILED.findall(said))
    parts = [
        f"{rule} failed; the end of {log}:\n{_end(Path(log).read_text(errors='replace'), 12)}"
        for rule, log in found
        if Path(log).is_file()
    ]
    return "\n\n".join(parts) or _end(said, 40)


def repeated(said: str) -> list[str]:
    """A line for each job that failed, of all that Snakemake said in a run that went well."""
    found = dict.fromkeys(_FAILED.findall(said))
    return [
        f"a job of {rule} failed and was repeated; its log is {failed_log(log)}"
        for rule, log in found
    ]


_FAILED = re.compile(
    r"^Error in rule (\w+):\n(?:    .*\n)*?    log: (.+?)(?:, .*)? \(check", re.MULTILINE
)
"""A failed job and its own log; a cluster's log may stand after it."""


def _end(text: str, lines: int) -> str:
    return "\n".join(f"    {line[:300]}" for line in text.splitlines()[-lines:])
