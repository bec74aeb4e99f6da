"""Quickest paths over cells, in waves: every place where the robot can be after each cycle."""
