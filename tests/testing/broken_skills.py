"""Skills that break one rule of the contract each, and some that keep them all."""

SKILLS = '''
import random
import threading
import time

import numpy as np

from humanoid_bt import Key, PerceptName, Skill, Status, param, result


class Good(Skill):
    """Hold the right hand up for a moment."""

    resources = ("right_hand",)
    bounded = True

    target: PerceptName = param("ball", doc="Percept whose side it is for.")
    duration: float = param(0.1, unit="s", above=0, doc="How long.")

    left: float = result(unit="s", doc="How long it still takes.")

    def initialise(self) -> None:
        self._since = self.robot.clock.now()

    def update(self) -> Status:
        track = self.robot.track(self.target)
        if track is None:
            return self.fail(self.robot.why_unseen(self.target))
        self.robot.move_hand("right", self.place())
        self.left = self.duration - (self.robot.clock.now() - self._since)
        if self.left > 1e-6:
            return self.running(f"{self.left:.2f} s to go")
        return self.succeed(f"held for {self.duration:.2f} s")

    def place(self):
        return self.robot.state.hands["right"] + np.array([0.0, 0.0, 0.1])


class Tally(Skill):
    """Add one to a key."""

    runs = False

    into: Key = param(doc="Key that counts.")

    def update(self) -> Status:
        self.into.set((self.into.value if self.into.is_set else 0) + 1)
        return self.succeed("counted 1 more")


class Exceptions(Good):
    """Divide by zero after a while."""

    def update(self) -> Status:
        status = super().update()
        return status if self.left > 0.06 else 1 // 0


class Blocking(Good):
    """Wait for something in one tick."""

    def place(self):
        if 0.05 < self.robot.clock.now() - self._since < 0.07:
            time.sleep(0.02)  # what a service takes to answer
        return super().place()


class Hanging(Good):
    """Wait for ever."""

    def update(self) -> Status:
        for _ in range(1500):  # three times what is taken for ever
            try:
                time.sleep(0.01)
            except Exception:
                pass


class Halting(Good):
    """Forget to call the base class."""

    def stop(self, new_status: Status) -> None:
        self.status = new_status


class Stubborn(Good):
    """Raise when it is halted."""

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID:
            raise RuntimeError("not now")


class Endless(Stubborn):
    """Raise when it is halted, and never end by itself."""

    def update(self) -> Status:
        status = super().update()
        return self.running("on and on") if status is Status.SUCCESS else status


class Clinging(Good):
    """Wait for something when it is halted."""

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID:
            time.sleep(2.0)


class Unready(Good):
    """Raise in setup."""

    def setup(self, **kwargs) -> None:
        super().setup(**kwargs)
        raise OSError("no such device")


class OnlyOnce(Good):
    """Take in setup what there is only one of."""

    taken = []

    def setup(self, **kwargs) -> None:
        super().setup(**kwargs)
        if self.taken:
            raise OSError("the device is busy")
        self.taken.append(self)


class SlowStart(Good):
    """Read a file when it starts, and never end."""

    def initialise(self) -> None:
        super().initialise()
        time.sleep(0.03)

    def update(self) -> Status:
        status = super().update()
        return self.running("on and on") if status is Status.SUCCESS else status


class Warming(Good):
    """Be slow to start, the first times."""

    cold = [None] * 8

    def initialise(self) -> None:
        super().initialise()
        if self.cold:
            self.cold.pop()
            time.sleep(0.03)


class Leaving(Good):
    """Leave a thread behind that commands on."""

    def initialise(self) -> None:
        super().initialise()
        threading.Thread(target=self.command_on, daemon=True).start()

    def command_on(self) -> None:
        until = time.monotonic() + 1.0
        while time.monotonic() < until:
            self.robot.move_hand("right", [0.3, -0.2, 1.0])
            time.sleep(0.001)


class Wordless(Good):
    """Say nothing while it waits."""

    def update(self) -> Status:
        status = super().update()
        if status is Status.RUNNING:
            self.feedback_message = ""
        return status


class Terse(Good):
    """Speak only of what is not as it should be."""

    def update(self) -> Status:
        status = super().update()
        if status is Status.RUNNING and not self.robot.state.stop_reason:
            self.feedback_message = ""
        return status


class Restarting(Good):
    """Count ticks over all of its lives."""

    ticks = 0

    def update(self) -> Status:
        self.ticks += 1
        status = super().update()
        return status if self.ticks < 8 else self.succeed(f"{self.ticks} ticks")


class Remembering(Good):
    """Keep the place from which it started first."""

    home = None

    def place(self):
        if self.home is None:
            self.home = self.robot.state.hands["right"].copy()
        return self.home + np.array([0.0, 0.0, 0.1])


class Unfinished(Good):
    """Clean up when it ends, and not when it is halted."""

    begun = False

    def initialise(self) -> None:
        super().initialise()
        self._left_over, self.begun = self.begun, True

    def update(self) -> Status:
        if self._left_over:
            return self.fail(f"{self.target!r} is held already")
        return super().update()

    def terminate(self, new_status: Status) -> None:
        if new_status is not Status.INVALID:
            self.begun = False


class Rested(Good):
    """Take for granted that the robot has not moved."""

    def initialise(self) -> None:
        super().initialise()
        if self._since > 0.05:
            raise RuntimeError("the hand is up")


class Ending(Good):
    """Say that it never ends."""

    ends = False


class Tireless(Good):
    """Say that it never ends, and give up when it sees nothing."""

    ends = bounded = False

    def update(self) -> Status:
        status = super().update()
        return self.running("on and on") if status is Status.SUCCESS else status


class Instant(Good):
    """Say that it never runs."""

    runs = False


class Undecided(Good):
    """Fail to say what it commands."""

    @classmethod
    def resources_for(cls, values):
        return {"cup": ("right_hand",)}[values["target"]]


class Greedy(Good):
    """Declare more than it commands."""

    resources = ("right_hand", "gaze")


class Commands(Good):
    """Look, too."""

    def update(self) -> Status:
        self.robot.look_at([1.0, 0.0, 1.0])
        return super().update()


class Percepts(Good):
    """Look out for something else, too."""

    def update(self) -> Status:
        self.robot.track("door")
        return super().update()


class Snapshot(Good):
    """Move the hand in place."""

    def place(self):
        hand = self.robot.state.hands["right"]
        hand += np.array([0.0, 0.0, 0.1])
        return hand


class Pushing(Good):
    """Move what was seen."""

    def update(self) -> Status:
        if track := self.robot.track(self.target):
            track.position_world[2] += 0.1
        return super().update()


class Reasons(Good):
    """Fail, and do not say why."""

    def update(self) -> Status:
        return super().update() if self.robot.track(self.target) else self.fail("not possible")


class Silent(Good):
    """Fail, and say nothing."""

    def update(self) -> Status:
        return super().update() if self.robot.track(self.target) else self.fail("")


class Counting(Good):
    """Fail with a number."""

    note: str = param("", doc="Said beside it.")

    def update(self) -> Status:
        return super().update() if self.robot.track(self.target) else self.fail(f"nothing within 3 m{self.note}")


class Naming(Counting):
    """Fail with a name."""

    def update(self) -> Status:
        return super().update() if self.robot.track(self.target) else self.fail(f"no {self.target} anywhere")


class Noted(Counting):
    """Fail with what it was given to say, which may be nothing."""

    def update(self) -> Status:
        return super().update() if self.robot.track(self.target) else self.fail(f"not possible{self.note}")


class Obeying(Good):
    """Give up when the robot is stopped, for the same reason."""

    def update(self) -> Status:
        stopped = self.robot.state.stop_reason
        return self.fail(f"stopped: {stopped}") if stopped else super().update()


class Sameness(Good):
    """Throw dice."""

    def place(self):
        return super().place() + 0.01 * random.random()


class Unseeded(Good):
    """Throw dice of its own, without a seed."""

    def initialise(self) -> None:
        super().initialise()
        self._dice = np.random.default_rng()

    def place(self):
        return super().place() + 0.01 * self._dice.random(3)


class Clock(Good):
    """Look at the wall clock."""

    def initialise(self) -> None:
        super().initialise()
        self._began = time.monotonic()


class Estop(Good):
    """Take for granted that the robot follows."""

    def update(self) -> Status:
        status = super().update()
        if self.robot.state.stop_reason:
            raise RuntimeError("the hand does not move")
        return status


class Lost(Good):
    """Take for granted that the thing was seen."""

    def update(self) -> Status:
        self.bearing = self.robot.track(self.target).bearing
        return super().update()


class Resuming(Good):
    """Take for granted that what was stopped stays so."""

    def initialise(self) -> None:
        super().initialise()
        self._stopped = False

    def update(self) -> Status:
        stopped = bool(self.robot.state.stop_reason)
        if self._stopped and not stopped:
            raise RuntimeError("where is the hand?")
        self._stopped = stopped
        status = super().update()
        return self.running("on and on") if status is Status.SUCCESS else status
'''
