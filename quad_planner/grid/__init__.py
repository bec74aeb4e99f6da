"""
Cells of maps: bits, inflation, traversable ground and lines of sight.
"""
