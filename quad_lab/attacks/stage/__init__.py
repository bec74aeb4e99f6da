"""
Nodes under attack: started, listened to and judged.
"""
