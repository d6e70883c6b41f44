"""Run of Snakemake with its log in a file: progress, failures, and end."""

import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO

from process_group import EndRequest, ForkedGroup, end_group, kill_group, shell_status

from jointclosure.engine.forks import run_forked
from jointclosure.engine.progress import WorkflowProgress
from studies.frame.jobs.logbook import failed_log

SHOWN = "jointclosure: "
"""Prefix of the lines of the log that are shown to the user."""
OWN_RESULTS = "The study's own tables and figures are in {folder}; its pool adds ranges"
KILLED = "exit status 137"
MEMORY = (
    "its process was killed, as systems do that run out of memory. "
    "What is finished stays; start again with fewer jobs at once (CORES=1)"
)
SECONDS, PART = 30.0, 0.1
"""Time or share of jobs between two lines on progress without a terminal."""


def follow(snakemake: Callable[[], object], stream: TextIO, log: Path, request: EndRequest) -> int:
    """Run Snakemake with its log in a file, show its progress, and return its exit status.

    ``snakemake`` is called in a forked process.
    """
    console = Console()
    if request:
        return ended(console, request)
    start = log.stat().st_size
    with open(os.devnull, encoding="utf-8") as empty:
        streams = [empty.fileno(), stream.fileno(), stream.fileno()]
        process = ForkedGroup(lambda: run_forked(snakemake, streams))
    progress, early = WorkflowProgress(), False
    try:
        for line in lines_of(log, start, process):
            if request:
                console.say("ending: the jobs at work are interrupted (again: they are killed)")
                end_group(process, request)
                return ended(console, request)
            progress.read(line)
            if line.startswith(SHOWN):
                console.say(line.removeprefix(SHOWN).rstrip())
            if not early and (early := own_results_complete(progress)):
                console.say(OWN_RESULTS.format(folder=log.parent.parent))
            console.show(progress)
    finally:  # no process is left, whatever ends this one
        kill_group(process)
    console.clear()
    written = log.read_bytes()[start:].decode(errors="replace")
    if process.returncode:
        lost = process.returncode == -signal.SIGKILL
        print(f"Snakemake: {MEMORY}" if lost else failures(written), file=sys.stderr)
        print(f"The run failed or was ended; its whole log is {log}", file=sys.stderr)
    elif progress.total:
        console.say(f"{progress.done} of {progress.total} jobs done")
        for line in repeated(written):
            console.say(line)
    else:
        console.say("nothing was left to do")
    return shell_status(process.returncode)


def own_results_complete(progress: WorkflowProgress) -> bool:
    """Return whether the study's own tables and figures are complete, and its pool is not."""
    own = progress.finished("write_tables", "draw_figures")
    return own and progress.awaited("aggregate_pool")


def ended(console: "Console", request: EndRequest) -> int:
    """Print how an ended run can be continued, and return its exit status."""
    console.say(str(request))
    return 128 + request.signal


def lines_of(log: Path, start: int, process: ForkedGroup) -> Iterator[str]:
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


class Console:
    """Progress as one renewed line on a terminal, or as occasional lines elsewhere."""

    def __init__(self, stream: TextIO | None = None):
        self._stream = sys.stdout if stream is None else stream
        self._renewed = self._stream.isatty()
        self._shown, self._at, self._part = "", time.monotonic(), 0.0

    def show(self, progress: WorkflowProgress) -> None:
        """Show the progress, if the last line is old enough."""
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
        """Print a line that stays."""
        self.clear()
        print(text, file=self._stream, flush=True)

    def clear(self) -> None:
        """Remove the renewed line."""
        if self._shown:
            self._renew("")

    def _renew(self, text: str) -> None:
        print("\r" + text.ljust(len(self._shown)), end="", file=self._stream, flush=True)
        if not text:
            print("\r", end="", file=self._stream, flush=True)
        self._shown = text


def failures(log_text: str) -> str:
    """Describe the failed rules in a log of Snakemake, with the end of their logs."""
    failed = dict.fromkeys(_FAILED.findall(log_text))
    parts = [part for rule, log in failed if (part := _failure(rule, Path(log), log_text))]
    return "\n\n".join(parts) or _end(log_text, 40)


def _failure(rule: str, log: Path, log_text: str) -> str:
    """Describe a failed job; empty if the log of Snakemake alone has the reason."""
    text = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
    if not re.search("^failed: ", text, re.MULTILINE) and (log.is_file() or KILLED in log_text):
        return f"{rule} failed without an error in {log}: {MEMORY}\n{_end(text, 3)}".rstrip()
    return text and f"{rule} failed; the end of {log}:\n{_end(text, 12)}"


def repeated(log_text: str) -> list[str]:
    """Describe jobs that failed and were repeated, from the log of a successful run."""
    failed = dict.fromkeys(_FAILED.findall(log_text))
    return [
        f"a job of {rule} failed and was repeated; its log is {failed_log(log)}"
        for rule, log in failed
    ]


_FAILED = re.compile(
    r"^Error in rule (\w+):\n(?:    .*\n)*?    log: (.+?)(?:, .*)? \(check", re.MULTILINE
)
"""Failed job and its log; a cluster's log may follow it."""


def _end(text: str, lines: int) -> str:
    return "\n".join(f"    {line[:300]}" for line in text.splitlines()[-lines:])
