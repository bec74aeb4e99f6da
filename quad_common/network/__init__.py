"""
Who on the network reaches these nodes, and by what transport, as the environment sets it.
"""
