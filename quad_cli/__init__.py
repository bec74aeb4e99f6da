"""
The ``quadwalk`` command: it composes planner, gait and simulator for people.
"""
