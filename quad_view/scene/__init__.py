"""
What is shown, as values: no ROS and no browser.
"""
