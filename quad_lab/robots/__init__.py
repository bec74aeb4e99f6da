"""
What is measured of robots that are imported from other people's descriptions.
"""
