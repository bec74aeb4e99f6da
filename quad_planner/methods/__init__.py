"""
Planning methods: from a request to the turning points of a plan.
"""
