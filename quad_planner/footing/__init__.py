"""Footing: cells and headings where the robot finds footholds for all its feet."""
