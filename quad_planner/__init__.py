"""
Planning: from a map, a start and a goal to the turning points of a walk.

Obstacles get a boundary at the safety distance (S0 section 3). Within what is left the
shortest way is found: over a mesh as wide as the robot needs for its turns, by Dijkstra's
algorithm, over the cells of the map, or at any angle.
"""
