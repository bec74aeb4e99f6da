"""Footing: where feet may stand on uneven ground, and what legs reach there."""
