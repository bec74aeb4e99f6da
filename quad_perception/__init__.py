"""
Perception: from the picture of a camera under the ceiling to a map, the robot and the goal.

Colors tell the robot, the obstacles and the goal apart (S1). Where things stand on the
floor follows from the camera's model and pose: nothing else is known about the room.
"""
