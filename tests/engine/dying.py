"""Tasks whose worker dies; workers import them, so that this module imports little."""

import os
import signal


def die_or_double(number):
    """End the process if the number is negative, else double it."""
    if number < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * number


def kill_worker_once(walls, reading, marker):
    """Close a joint, but end the process at the first one that begins at height 0."""
    from jointclosure.engine.joints import close_joint

    if walls[0][0, 0] == 0.0 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return close_joint(walls, reading)
