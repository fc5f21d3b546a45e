"""A run in lockstep as other terminals reach it: it tells what it does, and obeys the e-stop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.messages import Mode, State
from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale, lockstep_root
from humanoid_bt.link.segment import LinkError
from humanoid_bt.link.wire import encode_state, state_room
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.estop_follower import EStopFollower, Tell
from humanoid_bt.realtime.live_tree import TreeTeller
from humanoid_bt.tree.tree import Tree


class LockstepLink:
    """The folder of one run in lockstep, with the few channels that it needs.

    Args:
        info: what runs.
        joints: names of the robot's joints.
        supervisor: what stops the robot.
        tell: is told of resets.

    Raises:
        LinkError: there is no place for it.
    """

    def __init__(self, info: RunInfo, joints: Sequence[str], supervisor: Supervisor, tell: Tell) -> None:
        clean_stale()
        self._folder = folder = RunFolder.create(info, lockstep_root())
        try:
            channels.create_lockstep_channels(folder, state=state_room(joints))
        except LinkError:
            folder.close()
            raise
        self._teller = TreeTeller(folder)
        self._states = channels.writer(folder, "state")
        self._estop = EStopFollower(channels.estop(folder), supervisor, tell)
        self._mode: Mode | None = None

    def obey(self) -> None:
        """Do what the e-stop says; a look costs less than a microsecond while it says nothing new."""
        self._estop.poll()

    def reset(self, source: str) -> None:
        """Reset a latched stop, and what was raised from outside; raises LinkError if that cannot be written."""
        self._estop.reset(source)

    def sensed(self, state: State) -> None:
        """Show a state in which the mode is another than before at once."""
        if state.mode is not self._mode:
            self._show(state)

    def tell(self, status: Mapping[str, object], state: State, tree: Tree) -> None:
        """Tell what goes on, as :meth:`TreeTeller.tell`."""
        self._show(state)
        self._teller.tell(status, tree)

    def _show(self, state: State) -> None:
        self._mode = state.mode
        self._states.write(encode_state(state))

    def close(self) -> None:
        """Let go of the channels and remove the folder."""
        self._teller.close()
        self._states.close()
        self._estop.close()
        self._folder.close()
