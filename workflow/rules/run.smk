# How a run starts and ends, and what it shows. No rules here.
import fcntl
import logging
import re
import shutil
import signal
import sys
import time

import psutil
from snakemake.logging import logger
from snakemake_interface_logger_plugins.common import LogEvent

from jointclosure.execution.progress import duration, remaining
from jointclosure.storage.files import read_csv
from jointclosure.storage.logs import reason_of_failure
from studies.frame.cases import expected_seconds
from studies.paper.tables_1_to_3 import closure_lines

HELD = []  # the locked file of a run, open until this process ends
INTERRUPTED = []  # times of the interrupts
JOB_SECONDS = 2.0  # roughly, of a job apart from the joints that it simulates
# Files that a user reads after a target was made
READ_NEXT = {
    "report": "report.html",
    "assessment": "tables/assessment.md",
    "conclusions": "tables/conclusions.csv",
}


class RunMessages(logging.Handler):
    """Handler that shows how long a run will still take, and why a job failed.

    The remaining time is estimated from the jobs that have ended, each weighted by the expected
    time of its joints. Time is measured from the moment when all kernels are compiled.
    """

    def __init__(self, dag):
        super().__init__()
        self.dag, self.start, self.shown = dag, time.monotonic(), 0.0
        self.costs, self.ended, self.before = {}, set(), set()
        self.plan()

    def plan(self):
        """Add the jobs of the present plan, as a checkpoint adds some and ended ones leave it."""
        self.costs |= {job.jobid: self.cost(job) for job in self.dag.needrun_jobs()}

    def emit(self, record):
        event = getattr(record, "event", None)
        if event == LogEvent.JOB_ERROR and not INTERRUPTED:  # which kills all jobs
            for log in record.log:
                print(
                    f"{record.rule_name} failed: {reason_of_failure(log)}; its log is {log}",
                    file=sys.stderr,
                )
        # if its progress is not shown, Snakemake reports only jobs that start
        if event == LogEvent.JOB_STARTED:
            self.ended |= {job.jobid for job in self.dag.finished_jobs}
            if self.compiles():
                self.start, self.before = time.monotonic(), set(self.ended)
            else:
                self.show_remaining()

    def compiles(self):
        """Return whether kernels are still to be compiled, for which other jobs wait."""
        return any(
            job.rule.name.startswith("compile_") and job.jobid not in self.ended
            for job in self.dag.needrun_jobs()
        )

    def show_remaining(self):
        """Show the remaining time, every ten seconds at most."""
        now = time.monotonic() - self.start
        if now - self.shown < 10.0:
            return
        self.plan()
        done = sum(self.costs.get(jobid, 0.0) for jobid in self.ended - self.before)
        left = sum(
            cost for jobid, cost in self.costs.items() if jobid not in self.ended
        )
        seconds = remaining(now, done, left)
        if seconds:
            self.shown = now
            jobs = f"{len(self.ended)} of {len(self.costs)} jobs are done"
            print(
                f"{jobs}, about {duration(seconds)} left",
                file=sys.stderr,
                flush=True,
            )

    @staticmethod
    def cost(job):
        """Return the expected processor time of a job [s]."""
        if job.rule.name == "close_joints":
            joints = int(job.wildcards.last) - int(job.wildcards.first) + 1
            of_joint = expected_seconds(ENSEMBLES[job.wildcards.ensemble])
            return JOB_SECONDS + joints * of_joint
        if job.rule.name == "close_points":
            points = POINTS[job.wildcards.experiment]()[job.wildcards.job]
            return JOB_SECONDS + joints_of(points) * expected_seconds(STUDY)
        if job.rule.name == "assess_joints":
            return JOB_SECONDS + PLAN.seconds / len(PLAN.points)
        return JOB_SECONDS


def interrupt(number, frame):
    """End the jobs, and at the first interrupt the run.

    `timeout` in the Makefile passes each interrupt on, so that a second one follows at once.
    """
    now = time.monotonic()
    is_first = not INTERRUPTED or now - INTERRUPTED[-1] > 1.0
    INTERRUPTED.append(now)
    if workflow.local_exec:
        for job in psutil.Process().children():
            job.kill()
    if is_first:
        raise KeyboardInterrupt


onstart:
    # Two runs of one study at once are refused. The kernel ends the lock with this process,
    # whatever ends it, so that no run ever needs to be unlocked.
    os.makedirs(RESULTS, exist_ok=True)
    HELD.append(open(f"{RESULTS}/.lock", "a"))
    try:
        fcntl.flock(HELD[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(f"another run of the study {STUDY.study.name} is at work here")
    # Snakemake gives the path of Python to a shell without quotes, whatever this folder is named.
    sys.executable = os.path.relpath(sys.executable)
    # A job replaces its shell. On Linux the kernel kills it when Snakemake ends, for any reason,
    # and it does not start if Snakemake has ended before the kernel was asked to do so. Jobs ignore
    # an interrupt from a terminal, at which Snakemake ends them.
    ends = "setpriv --pdeathsig KILL " if shutil.which("setpriv") else ""
    start = """sh -c 'trap "" INT; [ $PPID = "$0" ] && exec "$@"' """
    shell.prefix(f"set -euo pipefail; exec {ends}{start}{os.getpid()} ")
    signal.signal(signal.SIGINT, interrupt)
    # Lines on the selection of jobs are hidden, as the messages of rules announce jobs; so is the
    # command of a job that failed, as its log and `RunMessages` have the reason. After an interrupt
    # all jobs count as failed.
    hidden = re.compile(
        r"Select jobs to execute|Execute \d+ jobs|RuleException:\s+CalledProcessError"
    )
    of_interrupt = re.compile("WorkflowError:\\s+At least one job did not complete")
    for handler in logger.handlers:
        handler.addFilter(
            lambda record: not (
                hidden.match(record.getMessage())
                or (INTERRUPTED and of_interrupt.match(record.getMessage()))
            )
        )
    logger.addHandler(RunMessages(workflow.dag))


onsuccess:
    rules_of_run = {job.rule.name for job in workflow.dag.jobs}
    if "fit_correlations" in rules_of_run:
        closures = read_csv(f"{RESULTS}/tables/max_closure.csv")
        print("\n".join(closure_lines(closures)), file=sys.stderr)
    if "hard_cases" not in rules_of_run:
        read = [
            f"{RESULTS}/{file}"
            for rule, file in READ_NEXT.items()
            if rule in rules_of_run
        ]
        next_file = f"; read {' and '.join(read)}" if read else ""
        print(f"Results are in {RESULTS}/{next_file}", file=sys.stderr)


onerror:
    end = "interrupted" if INTERRUPTED else "The run failed or was ended"
    print(
        f"{end}. Finished jobs are kept, and the same command continues.",
        file=sys.stderr,
    )
