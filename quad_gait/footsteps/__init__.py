"""
Footsteps: which foot goes where, planned over a height map where strides find no ground.
"""
