"""
The model of a camera, its file, and the markers it looks for.
"""
