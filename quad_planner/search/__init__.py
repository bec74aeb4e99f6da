"""
Searches over cells, headings and corners.
"""
