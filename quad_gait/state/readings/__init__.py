"""
Whether what sensors say is possible, of now, and prompt enough.
"""
