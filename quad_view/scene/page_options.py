"""
How the page is opened, and what can be chosen on it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PageOptions:
    """Options of the page."""

    host: str = '127.0.0.1'
    """Address to listen on."""
    port: int = 8080
    """Port to listen on, or the next free one."""
    plot_rate: float = 4.0
    """Updates of the plots in a second [Hz]."""
    gaits: tuple[str, ...] = ('crawl',)
    """Gaits to choose from."""
    largest_speed: float = 0.3
    """Speed of the pad at its largest [m/s]."""
    largest_turn: float = 0.6
    """Rate of turning of the pad at its largest [rad/s]."""
