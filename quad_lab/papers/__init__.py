"""
Papers' figures drawn again, one file a paper.
"""
