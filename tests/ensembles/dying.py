"""Task whose worker dies; workers import this module, so that it imports little."""

import os
import signal


def kill_worker_once(walls, reading, marker):
    """Close a joint; once, kill the process at a joint whose first height is 0."""
    from jointclosure.ensembles.simulation import simulate_row

    if walls[0][0, 0] == 0.0 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return simulate_row(walls, reading)
