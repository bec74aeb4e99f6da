"""
Planning: from a map, a start and a goal to the turning points of a walk.

S0 section 3: obstacles get a boundary at the safety distance, a mesh as wide as the
robot needs for its turns is laid over the map, and Dijkstra's algorithm finds the
shortest way over it.
"""
