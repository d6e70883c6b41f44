"""Run a script by the job server of this folder, or by Python if none answers.

`python -I -S server_client.py SOCKET PYTHON SCRIPT`, with the standard library only, as each job
starts this.
"""

import json
import os
import signal
import socket
import sys


def status_from(address: str, script: str) -> int | None:
    """Return the exit status of a script that the server runs; None if it does not run it."""
    request = {"script": script, "folder": os.getcwd(), "environment": dict(os.environ)}
    with socket.socket(socket.AF_UNIX) as server:
        try:
            server.connect(address)
            data = json.dumps(request).encode() + b"\n"
            sent = socket.send_fds(server, [data], [0, 1, 2])
            server.sendall(data[sent:])
            started = server.recv(1)
        except OSError:
            return None
        if not started:
            return None
        try:
            return (server.recv(1) or b"\1")[0]
        except OSError:  # the server has ended, and the job is not known to be complete
            return 1


if __name__ == "__main__":
    address, *command = sys.argv[1:]
    # an interrupt of the group reaches the job, which is waited for
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    one_thread = os.environ.get("OMP_NUM_THREADS", "1") == "1"  # as the server has loaded libraries
    status = status_from(address, command[-1]) if one_thread else None
    if status is None:
        signal.signal(signal.SIGINT, handler)
        os.execv(command[0], command)
    sys.exit(status)
