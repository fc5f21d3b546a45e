"""What MuJoCo warns of, for people: without this it goes to a file, MUJOCO_LOG.TXT, in the working directory."""

from __future__ import annotations

import atexit
import logging
import warnings
from collections import deque

import mujoco

_log = logging.getLogger(__name__)
_pending: deque[str] = deque(maxlen=100)


def hear() -> None:
    """Take what MuJoCo warns of in this process, from now on; of an attached model it would warn Python as well."""
    mujoco.set_mju_user_warning(_pending.append)
    warnings.filterwarnings("ignore", "Attach conflict", UserWarning)


def taken() -> list[str]:
    """Return the warnings since the last call, oldest first. What nobody takes is logged at the program's end."""
    found = [f"MuJoCo: {' '.join(text.split())}" for text in _pending] if _pending else []
    _pending.clear()
    return found


@atexit.register
def _log_the_rest() -> None:
    for text in taken():
        _log.warning(text)
