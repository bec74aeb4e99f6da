"""
Campaigns: thousands of walks over what varies, on any number of machines, kept and summed up.
"""
