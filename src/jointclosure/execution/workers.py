"""Work shared among worker processes that run `work`, with one task at a time for each of them.

Unlike the processes of `multiprocessing`, workers never run the script of the caller again, and if
a worker dies only its current task is lost. Workers are killed when their caller ends, also during
a task.
"""

import ctypes
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

from jointclosure.inputs import check_count

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
_PR_SET_PDEATHSIG = 1


class ProcessLostError(RuntimeError):
    """Error of a task whose worker process ended before the task was done."""


class Failed(NamedTuple):
    """Result of a task that failed, with the exception that it raised, or a `ProcessLostError`."""

    error: Exception


def number_of_workers(workers: int | None) -> int:
    """Return the number of worker processes: ``workers``, or by default all available processors.

    These are the processors that this process may use. Raise `InputError` if ``workers`` is not a
    whole number of at least 1.
    """
    if workers is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    check_count("workers", workers)
    return workers


def in_processes(
    function: Callable[..., Any], tasks: Sequence[tuple], workers: int, apart: bool = False
) -> Iterator[tuple[int, Any]]:
    """Generate (place, result or `Failed`) of tasks of a function, in the order in which they end.

    The function must be one of a module that can be imported, and a task is the tuple of arguments
    of one call. The place is the index of the task. With one worker the calls are made in the
    current process, unless ``apart``. Workers are killed when the generator ends or is closed.
    """
    if workers == 1 and not apart:
        for place, task in enumerate(tasks):
            yield place, _answer(function, task)
        return
    pool = _Workers()
    try:
        yield from _as_finished(partial(pool.ask, function), tasks, workers, pool.stop)
    finally:  # a thread may have started a worker after all were stopped
        pool.stop()


def in_threads(
    function: Callable[..., Any], tasks: Sequence[Any], threads: int
) -> Iterator[tuple[int, Any]]:
    """Generate (place, result) of tasks of a function in threads, in the order in which they end.

    The function is called with a task, and with a function that it must call now and then, which
    raises `InterruptedError` once the results are no longer wanted. An exception of a task is
    raised here.
    """
    ended = threading.Event()

    def going_on(*_: Any) -> None:
        if ended.is_set():
            raise InterruptedError

    yield from _as_finished(lambda task: function(task, going_on), tasks, threads, ended.set)


def _as_finished(
    call: Callable[[Any], Any], tasks: Sequence[Any], threads: int, stop: Callable[[], None]
) -> Iterator[tuple[int, Any]]:
    """Generate (place, result) of the tasks of ``call`` in threads, in the order in which they end.

    ``stop`` is called at the end, or when the caller takes no more results; it must end those calls
    that are still running.
    """
    with ThreadPoolExecutor(max(1, min(threads, len(tasks)))) as pool:
        waiting = {pool.submit(call, task): place for place, task in enumerate(tasks)}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        finally:  # tasks whose results are not requested are not started
            pool.shutdown(wait=False, cancel_futures=True)
            stop()


class _Workers:
    """Worker processes: one for each thread that uses it, started at the thread's first call."""

    def __init__(self) -> None:
        self._of_thread = threading.local()
        self._all: list[subprocess.Popen] = []

    def ask(self, function: Callable[..., Any], task: tuple) -> Any:
        """Return the result of a call of a function in the worker of this thread, or `Failed`.

        If the worker ends during the call, the thread gets a new worker at its next call.
        """
        worker = getattr(self._of_thread, "worker", None) or self._start()
        assert worker.stdin is not None  # both are pipes
        assert worker.stdout is not None
        try:
            pickle.dump((function, task), worker.stdin)
            worker.stdin.flush()
            return pickle.load(worker.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            self._of_thread.worker = None
            worker.kill()
            ended = f"its process ended with code {worker.wait()} before it was done"
            return Failed(ProcessLostError(ended))

    def _start(self) -> subprocess.Popen:
        environment = os.environ | dict.fromkeys(_ONE_THREAD, "1")
        environment["PYTHONPATH"] = os.pathsep.join(path or os.getcwd() for path in sys.path)
        worker = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import work; work({os.getpid()})"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
        )
        self._all.append(worker)
        self._of_thread.worker = worker
        return worker

    def stop(self) -> None:
        """Kill every worker."""
        for worker in self._all:
            worker.kill()
            worker.wait()
            for pipe in filter(None, (worker.stdin, worker.stdout)):
                with suppress(BrokenPipeError):  # the worker has already ended
                    pipe.close()


def _answer(function: Callable[..., Any], task: tuple) -> Any:
    try:
        return function(*task)
    except Exception as error:
        return Failed(error)


def end_with_parent(parent: int) -> None:
    """Have this process killed when the process that made it ends, or has ended already."""
    prctl = getattr(ctypes.CDLL(None), "prctl", None)  # of Linux only
    if prctl is None or prctl(_PR_SET_PDEATHSIG, signal.SIGKILL):
        threading.Thread(target=_kill_without, args=(parent,), daemon=True).start()
    elif os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def _kill_without(parent: int) -> None:
    """Wait until this process has another parent than ``parent``, and kill this process then."""
    while os.getppid() == parent:
        time.sleep(0.2)
    os.kill(os.getpid(), signal.SIGKILL)


def work(parent: int) -> None:
    """Answer the requests of a parent process on standard input, until it or the input ends.

    A request is a pickled pair of a function and its arguments; its pickled result, or `Failed`,
    goes to standard output. What the function prints goes to standard error instead.
    """
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted too, and ends this
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    while True:
        try:
            function, task = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(_answer(function, task), answers)
        answers.flush()
