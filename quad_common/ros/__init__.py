"""
What every node shares: the guarded node, parameters, diagnostics and conversions of messages.
"""
