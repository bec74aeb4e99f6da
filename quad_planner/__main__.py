"""
Starts planner_node, as ``planner_node`` and ``ros2 run quadwalk planner_node`` do.
"""

from __future__ import annotations

from quad_common.process.early_signals import end_node_at_once

end_node_at_once()

from quad_common.process.entry import start_node  # noqa: E402


def main(args: list[str] | None = None) -> int:
    """Run the node in a process of its own."""
    return start_node('quad_planner.planner_node', args)


if __name__ == '__main__':
    raise SystemExit(main())
