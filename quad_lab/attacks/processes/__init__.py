"""
Starts and stops, and what they leave behind.
"""
