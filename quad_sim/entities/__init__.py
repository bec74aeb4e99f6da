"""
Robots that come and go on request: the services that simulators have in common.
"""
