"""
The page in the browser: the one room that knows viser.
"""
