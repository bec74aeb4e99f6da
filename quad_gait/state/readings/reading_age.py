"""
How old a sensor's readings are, in the time of the odometry.

They may fall silent, come late, or be stamped by another clock than the odometry: none of them says
how the robot is now.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from quad_common.robot.leg_moments import GRAVITY
from quad_common.robot.robot import Robot
from quad_gait.state.readings.series_check import LONGEST_GAP

LEAST_MISSED = 4
"""Number of readings of the odometry without one of the sensor that make those missing."""

_LEAST_OLD = 10
"""Number of readings of the odometry in a row at which those of the sensor are old, though they
come, that make them missing: after a pause of the machine odometry may be the first to come."""


_PROMPT, _OFTEN = 0.06, 0.03
"""Age of a reading by which a robot can keep its balance [s]: of a sensor, at most; of odometry,
whose readings are what it decides at."""

_TIPPING, _TIPPING_OFTEN = 0.4, 0.25
"""The same, as fractions of the time constant with which a robot tips."""

_DRIFT = 1e-4
"""Rate at which two clocks drift apart at most [s/s]."""

_STEADILY = 10
"""Number of readings in a row that are to be as quick: a single stamp may be wrong."""

_OTHER_CLOCK = 10.0
"""Difference from the clock beyond which odometry is stamped by another one [s]."""

_MEMORY = 0.5
"""Time over which it is averaged for how much of it readings were older [s]."""

_LATE, _PROMPT_AGAIN = 0.2, 0.05
"""Part of the time from which on they are late, and below which they are not any more."""


class PromptAges(NamedTuple):
    """Ages of readings by which a robot can keep its balance."""

    sensors: float
    """Age of joint states, and of the imu's readings [s]."""
    odometry: float
    """Time from one odometry to the next [s]."""

    @classmethod
    def of(cls, robot: Robot) -> PromptAges:
        """Return those of a robot: the faster it tips, the less."""
        tipping = math.sqrt(robot.center_height / GRAVITY)
        return cls(min(_PROMPT, _TIPPING * tipping), min(_OFTEN, _TIPPING_OFTEN * tipping))


class TravelTime:
    """
    How much longer readings travel than the quickest of them, by a clock that may differ.

    What tells of the robot may come late all together: then nothing is older than the rest.
    """

    def __init__(self) -> None:
        self._least = math.inf
        self._last = 0.0
        self._recent: deque[float] = deque(maxlen=_STEADILY)

    def excess(self, stamp: float, now: float | None) -> float:
        """Take the stamp of a reading, and the time by the clock [s]; return the excess [s]."""
        if now is None or abs(now - stamp) > _OTHER_CLOCK:
            self._least = math.inf
            self._recent.clear()
            return 0.0
        self._recent.append(now - stamp)
        self._least += _DRIFT * max(now - self._last, 0.0)
        self._last = now
        if len(self._recent) == _STEADILY:
            self._least = min(self._least, max(self._recent))
        return max(now - stamp - self._least, 0.0)


class Lateness:
    """
    Tells whether readings were too old to keep the balance by for a good part of the time.

    Parameters
    ----------
    readings : str
        The readings, several of them, for the sentence.
    prompt : float
        Age up to which they are not late [s].
    """

    def __init__(self, readings: str, prompt: float) -> None:
        self._readings = readings
        self._prompt = prompt
        self._time = math.inf
        self._part = 0.0
        self.problem = ''
        """That they are late, as a sentence; empty if they are not."""

    def update(self, time: float, age: float | None) -> None:
        """Take how old the last reading is at a time [s]; None if there is none."""
        step = time - self._time
        self._time = time
        if age is None or not 0.0 < step <= LONGEST_GAP:
            return
        # Of the time since this was asked last, what went by while the reading was old already.
        late = min(max(age - self._prompt, 0.0), step) / step
        self._part += (late - self._part) * -math.expm1(-step / _MEMORY)
        least = _PROMPT_AGAIN if self.problem else _LATE
        self.problem = ''
        if self._part > least:
            # Without a figure that changes: what is said anew is published at once.
            part = f'more than {100.0 * _PROMPT_AGAIN:.0f} % of the time'
            self.problem = f'{self._readings} are older than {self._prompt:.2g} s for {part}'


class ReadingAge:
    """
    Compares a sensor's readings with the odometry.

    Parameters
    ----------
    what : str
        What is missing in silence, for the sentence.
    readings : str
        The readings, several of them, for the sentence.
    timeout : float
        Age at which readings are old [s].
    prompt : float
        Age up to which the balance can be kept by them [s].
    patience : float
        Time from the first odometry on in which the first reading is to come [s]; one that never
        comes is not missed if not given.
    """

    def __init__(
        self,
        what: str,
        readings: str,
        timeout: float,
        prompt: float,
        patience: float = math.inf,
    ) -> None:
        self._what = what
        self._readings = readings
        self._timeout = timeout
        self._patience = patience
        self._first = math.inf
        self._now: float | None = None
        self._stamp: float | None = None
        # When the last reading was measured or, if no odometry is as late as that, came.
        self._since: float | None = None
        # The same of the one that was the last when odometry came before.
        self._before: float | None = None
        # When odometry came next after it.
        self._came = -math.inf
        self._is_new = False
        self._missed = self._old = 0
        self.problem = ''
        """What is wrong with the readings, as a sentence; empty if nothing is."""
        self.lateness = Lateness(readings, prompt)
        """Whether they come too late, or too seldom, to keep the balance by."""

    def take(self, stamp: float | None) -> None:
        """Note that a reading has come, measured at a time [s]; None if it has no stamp."""
        self._stamp = stamp
        self._since = self._now if stamp is None else stamp
        self._is_new = True
        self._missed = 0

    def advance(self, time: float) -> bool:
        """Note that odometry of a time [s] has come; return whether there is a reading of now."""
        self._now = time
        self._first = min(self._first, time)
        if self._is_new:
            # A stamp of the future says nothing of when they fall silent.
            self._since = time if self._since is None else min(self._since, time)
            self._came = time
            self._is_new = False
        # Just before the last one came, the one before it was as old as it was going to be.
        oldest = self._since if self._before is None else self._before
        self.lateness.update(time, None if oldest is None else time - oldest)
        self._before = self._since
        self._missed += 1
        age = 0.0 if self._stamp is None else time - self._stamp
        self._old = self._old + 1 if age > self._timeout else 0
        self.problem = self._problem(time, age)
        return self.is_recent(time)

    def is_recent(self, time: float) -> bool:
        """Return whether there is a reading that tells of now [s]."""
        since = self._since
        return since is not None and time - since <= self._timeout and not self._is_ahead()

    @property
    def is_stamped(self) -> bool:
        """Whether the last reading has a stamp, and tells of the time of the last odometry."""
        return self._stamp is not None and (self._now is None or self.is_recent(self._now))

    @property
    def ahead(self) -> float:
        """Time by which the last reading is newer than the odometry, of the same clock [s]."""
        if self._stamp is None or self._now is None or self._is_ahead():
            return 0.0
        return max(self._stamp - self._now, 0.0)

    def _is_ahead(self) -> bool:
        """Return whether the last reading is stamped by another clock, which is ahead."""
        if self._stamp is None or self._now is None:
            return False
        return self._stamp - self._now > LONGEST_GAP

    def _problem(self, time: float, age: float) -> str:
        if self._since is None:
            return f'no {self._what} yet' if time - self._first > self._patience else ''
        silence = time - self._since
        is_silent = time - self._came > self._timeout and self._missed >= LEAST_MISSED
        if silence > self._timeout and is_silent:
            return f'no {self._what} for {silence:.1f} s'
        if self._is_ahead():
            return (
                f'{self._readings} are stamped {-age:.1f} s after the odometry: '
                'do their clocks differ?'
            )
        if self._old >= _LEAST_OLD:
            return f'{self._readings} are {age:.1f} s older than the odometry'
        return ''


class SensorAges:
    """
    Ages of joint states and of the imu's readings, and of the odometry itself.

    Parameters
    ----------
    joints, imu : ReadingAge
        Of the two sensors.
    prompt : PromptAges
        Ages by which the robot can keep its balance.
    """

    def __init__(self, joints: ReadingAge, imu: ReadingAge, prompt: PromptAges) -> None:
        self.joints = joints
        """Age of the joint states."""
        self.imu = imu
        """Age of the imu's readings."""
        self._odometry = Lateness("odometry's readings", prompt.odometry)
        self._travelled = Lateness("odometry's readings", prompt.sensors)
        self._travel = TravelTime()
        self._last: float | None = None
        self.late = ''
        """That any of them come too late to keep the balance by, as a sentence; or empty."""

    def advance(self, time: float, now: float | None = None) -> bool:
        """
        Note that odometry has come.

        Parameters
        ----------
        time : float
            When it was measured [s].
        now : float, optional
            Now, by a clock that may differ from the one by which it is stamped [s].

        Returns
        -------
        bool
            Whether the imu tells of that time.
        """
        self.joints.advance(time)
        is_imu_recent = self.imu.advance(time)
        # Before this one came the last one was as old as it was going to be; and this one is as old
        # as the sensors say.
        before = 0.0 if self._last is None else time - self._last
        self._odometry.update(time, max(before, self.joints.ahead, self.imu.ahead))
        self._last = time
        self._travelled.update(time, self._travel.excess(time, now))
        each = self._odometry, self._travelled, self.imu.lateness, self.joints.lateness
        self.late = next((one.problem for one in each if one.problem), '')
        return is_imu_recent
