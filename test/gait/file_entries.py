"""How often code enters each file that decides, followed call by call."""

import gc
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[2]

NOT_COUNTED = {
    'quad_common/': 'poses, maps, kinematics, trajectories: what decisions are about',
    'quad_gait/balance/': 'functions and values: feet and joints from one knot to the next',
    'quad_gait/behaviours/gait_choice.py': 'a value: the gaits, and which of them does a step',
    'quad_gait/cycle/': 'functions: one cycle from a gait, a motion and its ends',
    'quad_gait/ground/': 'functions and values: slopes and footholds of one trot',
    'quad_gait/following/gait_pair.py': 'a value: two gaits, and which of them does a motion',
    'quad_gait/following/motion_sequence.py': 'values: cycles with their times and places',
    'quad_gait/following/reference_path.py': 'geometry of a path',
    'quad_gait/following/step.py': 'values, and a formula',
    'quad_gait/following/stoppable_cycle.py': 'functions: a cycle, and the stop after it',
    'quad_gait/state/body_placement.py': 'geometry of a body over its feet',
    'quad_gait/state/measurement.py': 'a value: what was measured',
    'quad_gait/state/robot_state.py': 'a value: what was measured, and what follows from it',
    'quad_gait/state/stance.py': 'a value: body, feet and loads',
    'quad_gait/faults/command_tracker.py': 'what the joints follow: asked by the detector alone',
    'quad_gait/faults/joint_fault.py': 'a value: what is wrong with a joint',
    'quad_gait/faults/joint_path.py': 'a value: a trajectory and what joints may be off',
    'quad_gait/faults/tipping.py': 'geometry of a body that tips',
    'quad_gait/uneven/ground_model.py': 'geometry of the ground',
    'quad_gait/uneven/stride_goal.py': 'a value: footholds, order of legs, the body afterwards',
    'quad_gait/uneven/swing_course.py': 'a value: where body and feet are in a swing',
    'quad_gait/uneven/joint_motion.py': 'a value: a motion and how far it has got',
    'quad_gait/behaviours/activity.py': 'words: what the robot says of itself',
    'quad_gait/behaviours/behaviour.py': 'the base class: its methods belong to each behaviour',
}
"""Files and folders that may be entered at any time, and why: nothing is decided there."""

MOST = 2


class Entries:
    """Counts by file the calls that come from another one; constructors make, and do not decide."""

    def __init__(self):
        self.calls = defaultdict(list)
        self._names = {}

    def __enter__(self):
        # Generators of other tests that are collected meanwhile would count as calls.
        gc.disable()
        sys.setprofile(self._note)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)
        gc.enable()

    def _file(self, frame):
        name = frame.f_code.co_filename
        if name not in self._names:
            path = Path(name)
            ours = path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0].startswith('quad_')
            self._names[name] = path.relative_to(ROOT).as_posix() if ours else ''
        return self._names[name]

    def _note(self, frame, event, _):
        entered = self._file(frame) if event == 'call' else ''
        if not entered or frame.f_code.co_name == '__init__':
            return
        caller = frame.f_back
        while caller is not None and not self._file(caller):
            caller = caller.f_back
        source = '' if caller is None else self._file(caller)
        if entered != source:
            self.calls[entered].append(f'{source}: {frame.f_code.co_name}')

    def too_many(self):
        """Return the files that are entered too often, with the calls."""
        return {
            file: calls
            for file, calls in self.calls.items()
            if len(calls) > MOST and not file.startswith(tuple(NOT_COUNTED))
        }


class counted:  # noqa: N801
    """A function that does the same as another, and notes which files it enters too often."""

    def __init__(self, update, seen, found):
        self._update, self._seen, self._found = update, seen, found

    def __call__(self, *args):
        """Follow it from its first call on."""
        self._entries = Entries()
        with self._entries:
            outcome = self._update(*args)
        self._seen.update(self._entries.calls)
        self._found.update(self._entries.too_many())
        return outcome

    @staticmethod
    def end():
        """Follow it no farther until it is called again."""
        sys.setprofile(None)
