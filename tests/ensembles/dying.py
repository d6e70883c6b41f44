"""A task whose worker dies; workers import it, so that this module imports little."""

import os
import signal


def kill_worker_once(walls, reading, marker):
    """Close a joint, but end the process at the first one that begins at height 0."""
    from jointclosure.ensembles.joints import close_joint

    if walls[0][0, 0] == 0.0 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return close_joint(walls, reading)
