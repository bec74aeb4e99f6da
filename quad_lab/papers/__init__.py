"""
Papers' figures and tables, s0 to s4, measured again beside the papers' values.
"""
