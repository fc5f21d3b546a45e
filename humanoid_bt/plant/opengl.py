"""OpenGL on this machine: what to install for pictures, and what a wrong choice of it does."""

from __future__ import annotations

import os

from humanoid_bt.core.errors import UserError

INSTALL = "Debian: apt install libegl1 libgl1-mesa-dri (or libosmesa6)"
"""What to do where there is nothing to render with."""

CHOICE = "MUJOCO_GL"
"""Environment variable that chooses what MuJoCo renders with: egl, osmesa, glfw, or nothing."""


def see_that_mujoco_loads() -> None:
    """Import MuJoCo where the environment chooses an OpenGL: it loads that at once, in processes without pictures too.

    Raises:
        UserError: there is no such thing.
    """
    if not (chosen := os.environ.get(CHOICE)):
        return
    try:
        import mujoco  # noqa: F401, PLC0415 (it may fail, and takes a while)
    except Exception as error:  # whatever MuJoCo and PyOpenGL raise
        why = str(error).strip().split("\n", maxsplit=1)[0] or type(error).__name__
        hint = f"unset {CHOICE}: pictures are rendered with EGL or OSMesa, whichever is there. {INSTALL}"
        raise UserError(
            f"MuJoCo does not load with {CHOICE}={chosen}: {why}", hint=hint, code="wrong-choice"
        ) from error
