"""
What no node may ever publish, by the name of each kind.
"""

from __future__ import annotations

NOT_FINITE = 'numbers that are not finite'
OUTSIDE_LIMITS = 'commands outside limits'
JOINTS_OUTSIDE = 'joints outside limits'
TOO_LONG = 'texts too long'
UNREADABLE = 'messages that cannot be read'
