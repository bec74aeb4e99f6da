"""
The viewer: robots, map and plans on a page in the browser, with buttons to walk them.
"""
