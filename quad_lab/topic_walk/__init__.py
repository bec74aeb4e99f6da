"""
Walks of real nodes over topics, observed and recorded.
"""
