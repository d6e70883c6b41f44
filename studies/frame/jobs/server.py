"""Job server: a process that has loaded modules and kernels, and that forks for each job of a run.

A job of a second would otherwise spend most of its time on its start. `JobServer` starts the server
from the main process of Snakemake; jobs run `server_client.py` in place of Python. The server
imports the modules of a job's script, loads the kernels that are compiled by then, and forks; the
fork takes the environment and the streams of the job, and runs the script as Python does.

The server and its forks are in the process group of Snakemake. They end with Snakemake, which alone
holds the other end of the server's standard input, and forks with the server. A fork is killed if
its client ends before it. Without an answer from a server the client runs the script by Python.
"""

import atexit
import contextlib
import gc
import glob
import importlib
import json
import os
import runpy
import selectors
import shlex
import signal
import socket
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import NoReturn

from jointclosure.engine.forks import end_with_parent, run_forked

CLIENT = Path(__file__).with_name("server_client.py")
ADDRESS = Path(".snakemake/jobs.socket")
"""Socket in the folder of a run, by a relative path, as its length is limited."""
_IGNORED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that the server leaves to its jobs and to Snakemake."""
_REQUEST = {"script", "folder", "environment"}
_SECONDS = 1.0
"""Within which a client that has begun its request must complete it."""
_SHARED = ("snakemake.io", "snakemake.iocontainers", "snakemake.logging", "scipy.stats")
"""Modules that scripts load while they run: Snakemake's in each of them, scipy's in analyses."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class JobServer:
    """Server of the jobs of this process, in the present folder. It ends with this process.

    Parameters
    ----------
    scripts : path
        Folder of the scripts of jobs.
    notes : str
        Pattern of the notes that the script ``compile_kernels.py`` writes, now or later. Its
        function ``load`` loads the kernels of a note.

    Raises
    ------
    OSError
        If the file system of the folder has no sockets.
    """

    def __init__(self, scripts: str | Path, notes: str):
        ADDRESS.parent.mkdir(exist_ok=True)
        ADDRESS.unlink(missing_ok=True)
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(ADDRESS))
            ADDRESS.chmod(0o600)  # whoever connects can run code
            listener.listen(128)  # jobs that start before the server is ready wait
            number = listener.fileno()
            command = [sys.executable, "-P", "-m", __name__, str(number)]
            self._process = subprocess.Popen(
                [*command, str(scripts), notes],
                stdin=subprocess.PIPE,
                pass_fds=[number],
                env=os.environ | dict.fromkeys(_THREADS, "1"),
            )
        atexit.register(self.end)

    def prefix(self) -> str:
        """Return the text before the command of a job in bash: Python and its script."""
        words = [sys.executable, "-I", "-S", str(CLIENT), str(ADDRESS)]
        return f"set -euo pipefail; exec {shlex.join(words)}"

    def end(self) -> None:
        """End the server, and jobs that are left."""
        assert self._process.stdin
        self._process.stdin.close()
        self._process.wait()
        ADDRESS.unlink(missing_ok=True)


class _Loop:
    """Loop over requests of clients, ends of clients, and ends of jobs."""

    def __init__(self, listener: socket.socket, notes: str):
        self._listener, self._notes = listener, notes
        self._loaded: set[tuple[Path, int]] = set()
        self._clients: dict[int, socket.socket] = {}
        self._woken, self._waking = socket.socketpair()
        self._woken.setblocking(False)
        self._waking.setblocking(False)
        signal.signal(signal.SIGCHLD, lambda *_: None)  # only to wake the loop
        signal.set_wakeup_fd(self._waking.fileno(), warn_on_full_buffer=False)
        self._selector = selectors.DefaultSelector()
        self._watch(listener, self._accept)
        self._watch(self._woken, self._report)
        self._watch(sys.stdin, sys.exit)

    def _watch(self, file, reaction) -> None:
        self._selector.register(file, selectors.EVENT_READ, reaction)

    def serve(self) -> NoReturn:
        """Serve until the standard input ends."""
        try:
            while True:
                for key, _ in self._selector.select():
                    key.data()
        finally:
            for job in self._clients:
                os.kill(job, signal.SIGKILL)

    def _accept(self) -> None:
        """Wait for the request of a new client, beside all others."""
        client, _ = self._listener.accept()
        client.settimeout(_SECONDS)
        self._watch(client, partial(self._start, client))

    def _start(self, client: socket.socket) -> None:
        """Fork for the job of a client."""
        self._selector.unregister(client)
        try:
            request, streams = _received(client)
        except (OSError, ValueError):  # the client has ended, is stopped, or is none of ours
            client.close()
            return
        self._load(Path(request["script"]))
        gc.freeze()  # a fork that collects garbage does not copy what it shares
        server = os.getpid()
        job = os.fork()
        if not job:
            end_with_parent(server)
            self._leave(client)
            run_forked(partial(_run, request), streams)
        for stream in streams:
            os.close(stream)
        self._clients[job] = client
        _send(client, b"+")
        self._watch(client, lambda: self._kill(job))

    def _load(self, script: Path) -> None:
        """Load what a job shares with later ones: modules, and kernels once they are compiled."""
        with contextlib.suppress(Exception):  # the job raises it again, in its log
            importlib.import_module(script.name.split(".")[1])  # <random>.<name of the script>.py
        for note in map(Path, glob.glob(self._notes)):
            if (version := (note, note.stat().st_mtime_ns)) not in self._loaded:
                self._loaded.add(version)
                importlib.import_module("compile_kernels").load(note)

    def _leave(self, client: socket.socket) -> None:
        """Close the files of the server in a fork."""
        signal.set_wakeup_fd(-1)
        self._selector.close()
        for file in (self._listener, self._woken, self._waking, client, *self._clients.values()):
            file.close()

    def _kill(self, job: int) -> None:
        """Kill the job of a client that has ended, unless it has ended as well."""
        if job in self._clients:
            self._forget(job)
            os.kill(job, signal.SIGKILL)

    def _forget(self, job: int) -> None:
        client = self._clients.pop(job)
        self._selector.unregister(client)
        client.close()

    def _report(self) -> None:
        """Send the status of ended jobs to their clients."""
        self._woken.recv(1 << 16)
        with contextlib.suppress(ChildProcessError):  # no job is left
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                job, status = ended
                if job in self._clients:
                    code = os.waitstatus_to_exitcode(status)
                    _send(self._clients[job], bytes([128 - code if code < 0 else code]))
                    self._forget(job)


def _received(client: socket.socket) -> tuple[dict, list[int]]:
    """Receive the request of a client, and its standard streams."""
    data, streams, _, _ = socket.recv_fds(client, 1 << 16, 3)
    try:
        while not data.endswith(b"\n") and (part := client.recv(1 << 16)):
            data += part
        request = json.loads(data)
        if len(streams) != 3 or not isinstance(request, dict) or request.keys() != _REQUEST:
            raise ValueError("not the request of a client")
    except (OSError, ValueError):
        for stream in streams:
            os.close(stream)
        raise
    return request, streams


def _send(client: socket.socket, data: bytes) -> None:
    with contextlib.suppress(OSError):  # the client has ended
        client.send(data)


def _run(request: dict) -> None:
    """Run the script of a job as Python does."""
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv = [request["script"]]
    sys.path.insert(0, os.path.dirname(request["script"]))
    runpy.run_path(request["script"], run_name="__main__")


def main(listener: str, scripts: str, notes: str) -> NoReturn:
    """Serve jobs on an open listening socket."""
    for number in _IGNORED:
        signal.signal(number, signal.SIG_IGN)
    for module in _SHARED:
        importlib.import_module(module)
    sys.path.append(scripts)
    _Loop(socket.socket(fileno=int(listener)), notes).serve()


if __name__ == "__main__":
    main(*sys.argv[1:])
