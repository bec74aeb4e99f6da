"""
Starts viewer_node, as its name does and ``ros2 run quadwalk viewer_node``.
"""

from __future__ import annotations

from quad_common.process.early_signals import end_node_at_once

end_node_at_once()

from quad_common.process.entry import start_node  # noqa: E402


def main(args: list[str] | None = None) -> int:
    """Run the node in a process of its own."""
    return start_node('quad_view.viewer_node', args)


if __name__ == '__main__':
    raise SystemExit(main())
