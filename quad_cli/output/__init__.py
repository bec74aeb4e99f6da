"""
What commands show: tables, pictures and progress.
"""
