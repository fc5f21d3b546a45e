"""The process that takes the head camera's pictures: a setup comes in, then shots; for each a picture goes out.

A process of its own, because a picture takes longer than a tick where there is no graphics card, and because whatever
goes wrong between MuJoCo and the system's OpenGL then ends here. It is the first to notice, so that nothing heavy is
imported before it can say so.
"""

from __future__ import annotations

import os
import pickle
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from humanoid_bt.plant.opengl import CHOICE

if TYPE_CHECKING:
    from humanoid_bt.plant.rendering import Camera

_NICE = 19  # whatever the run does comes first


def ready(setup: bytes, slowest: float) -> tuple[Camera | None, str]:
    """Return the camera, or None and why there is none.

    Args:
        setup: a pickled :class:`~humanoid_bt.plant.rendering.Setup`.
        slowest: what a picture may take of the processor [s].
    """
    try:
        from humanoid_bt.plant.rendering import Camera, first_shot  # noqa: PLC0415  # it may fail, see above

        camera = Camera(pickle.loads(setup))
        camera.take(first_shot())
        began = time.process_time()  # not the wall clock: a machine that is busy with a run is no slower one
        camera.take(first_shot())
        took = time.process_time() - began
    except Exception as error:  # whatever MuJoCo, PyOpenGL and the driver raise
        why = str(error).strip().split("\n", maxsplit=1)[0] or type(error).__name__
        return None, f"there is no OpenGL to render with ({why})"
    if took > slowest:
        return None, f"a picture takes {1000 * took:.0f} ms of the processor here, more than {1000 * slowest:.0f} ms"
    return camera, ""


def main() -> None:
    """Answer the setup with "" or what is wrong, then every shot with a picture, until the input ends."""
    with suppress(OSError):
        os.nice(_NICE)
    if sys.platform == "linux":
        os.environ.setdefault(CHOICE, "egl")  # it needs no display
    source, sink = sys.stdin.buffer, sys.stdout.buffer
    with suppress(EOFError, BrokenPipeError):
        camera, why = ready(*pickle.load(source))
        answer: Any = why
        while True:
            pickle.dump(answer, sink)
            sink.flush()
            if camera is None:
                return
            answer = camera.take(pickle.load(source))


if __name__ == "__main__":
    main()
