"""
Descriptions of robots as others write them: URDF, xacro and MJCF, read into one tree of links.
"""
