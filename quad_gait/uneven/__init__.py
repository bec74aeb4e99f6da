"""
Walking over uneven ground, a swing at a time.
"""
